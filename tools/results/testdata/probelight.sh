#!/bin/sh
# Stands in for the program in the tests of `measure`: answers at once, and fails for whatever is named "broken".
case "$*" in
    *broken*) exit 1 ;;
    bake*)
        : > "$4"
        echo '{"format_version": 7, "receivers": 1000, "probes": 2, "matrix_bytes_per_receiver": 50.0,
               "file_bytes": 60000, "seconds": 3.0, "report": {"mean_cluster_error": 0.02}}'
        ;;
    eval*) echo '{"relative_rmse": 0.1, "mean_bias": 0.01}' ;;
    bench*moving*) echo '{"scenes": [{"frame": {"shortest_ms": 2.0}}]}' ;;
    bench*) echo '{"scenes": [{"frame": {"shortest_ms": 1.0}}]}' ;;
esac

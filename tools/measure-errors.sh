#!/usr/bin/env bash
# Bakes a scene and prints the error of each setup against its reference points, as Markdown rows: relative RMSE, mean
# bias, median and 95th percentile of relative errors. Of more than four setups the median relative RMSE follows.
#
#   tools/measure-errors.sh GROUNDTRUTH OUT SCENE.glb SETUP... [-- BAKE_OPTION...]
#
# GROUNDTRUTH holds setups/SETUP.json and points/SETUP.csv; baked files and JSON reports go to OUT.
set -euo pipefail

groundtruth=$1 out=$2 scene=$3
shift 3
# shellcheck source=tools/evaluation.sh
source "$(dirname "${BASH_SOURCE[0]}")/evaluation.sh"
percent() { awk -v x="$1" 'BEGIN { printf "%.2f %%", 100 * x }'; }

name=$(basename "$scene" .glb)
mkdir -p "$out"
probelight bake "$scene" -o "$out/$name.plight" --json --quiet "$@" > "$out/$name.bake.json"
report="$out/$name.bake.json"
printf '%s: %s receivers, %s probes, %.0f bytes per receiver, %.0f s\n' "$name" "$(number receivers "$report")" \
    "$(number probes "$report")" "$(number matrix_bytes_per_receiver "$report")" "$(number seconds "$report")"
errors_of_all=()
for setup in "${setups[@]}"; do
    errors="$out/$setup.eval.json"
    probelight eval "$out/$name.plight" --setup "$groundtruth/setups/$setup.json" \
        --points "$groundtruth/points/$setup.csv" --json --quiet > "$errors"
    printf '| %s | %s | %s | %s | %s |\n' "$setup" "$(percent "$(number relative_rmse "$errors")")" \
        "$(percent "$(number mean_bias "$errors")")" "$(percent "$(number median_relative_error "$errors")")" \
        "$(percent "$(number p95_relative_error "$errors")")"
    errors_of_all+=("$(number relative_rmse "$errors")")
done
if ((${#setups[@]} > 4)); then
    printf '| median of %d | %s | | | |\n' ${#setups[@]} \
        "$(percent "$(printf '%s\n' "${errors_of_all[@]}" | sort -g | sed -n "$(((${#setups[@]} + 1) / 2))p")")"
fi

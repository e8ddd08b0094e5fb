#!/usr/bin/env python3
"""Plots what `probelight bench --scaling -o FILE.json` measured: time of a frame against the bytes it must move.

    pip install matplotlib
    tools/plot-scaling.py OUT.svg FILE.json...
"""

import json
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "probelight"  # the same input gives the same file
import matplotlib.pyplot as plt


def main(out, files):
    figure, axes = plt.subplots(figsize=(7, 4.5))
    for file in files:
        with open(file) as source:
            report = json.load(source)
        frames = [scene["frame"] for scene in report["scenes"]]
        megabytes = [frame["bytes"] / 1e6 for frame in frames]
        (line,) = axes.plot(megabytes, [frame["shortest_ms"] for frame in frames], "o-", label=report["device"])
        copied = [frame["bytes"] / report["copy_gb_per_s"] / 1e6 for frame in frames]
        axes.plot(megabytes, copied, "--", color=line.get_color(), alpha=0.5, label="as many bytes copied")
    axes.set(xscale="log", yscale="log", xlabel="bytes that a frame must move, MB", ylabel="shortest frame, ms")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    figure.tight_layout()
    figure.savefig(out, metadata={"Date": None})


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])

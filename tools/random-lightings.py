#!/usr/bin/env python3
"""Makes references under random lights that no bake knows, for `results measure`.

    tools/random-lightings.py SCENE.glb POINTS.csv OUT COUNT

POINTS.csv holds positions and normals on surfaces (`kind` 0), and positions in open space (`kind` 1) for lamps and spots.
OUT/setups/NAME.json and OUT/points/NAME.csv are written, NAME being SCENE_random_00, SCENE_random_01 and so on; lights
that reach nothing are drawn again. Files that exist are kept, so an interrupted run goes on. The path tracer is the program's own.
"""

import csv
import json
import math
import random
import subprocess
import sys
from pathlib import Path

SURFACE_POINTS = 500
SAMPLES = 2048
KINDS = ["point", "spot", "directional", "point", "spot", "sky"]


def direction(rng):
    z, angle = rng.uniform(-1, 1), rng.uniform(0, 2 * math.pi)
    r = math.sqrt(1 - z * z)
    return [r * math.cos(angle), z, r * math.sin(angle)]


def color(rng):
    return [rng.uniform(0.3, 1) for _ in range(3)]


def light(kind, rng, open_space):
    match kind:
        case "point":
            return {"type": kind, "position": rng.choice(open_space), "intensity": color(rng)}
        case "spot":
            outer = rng.uniform(12, 45)
            cone = {"direction": direction(rng), "inner_deg": outer * rng.uniform(0.5, 0.9), "outer_deg": outer}
            return {"type": kind, "position": rng.choice(open_space), "intensity": color(rng)} | cone
        case "directional":
            x, y, z = direction(rng)
            return {"type": kind, "direction": [x, -abs(y), z], "irradiance": color(rng)}
        case "sky":
            return {"type": kind} | {part: color(rng) for part in ("zenith", "horizon", "ground")}


def is_dark(truth):
    with open(truth, newline="") as source:
        columns = [f"{part}_{channel}" for part in ("E_indirect", "E_sky") for channel in "rgb"]
        return not any(float(row[column]) for row in csv.DictReader(source) for column in columns)


def main(scene, points, out, count):
    with open(points, newline="") as source:
        rows = list(csv.DictReader(source))
    surface = [row for row in rows if float(row["kind"]) == 0]
    open_space = [[float(row[f"position_{axis}"]) for axis in "xyz"] for row in rows if float(row["kind"]) == 1]
    surface = surface[:: math.ceil(len(surface) / SURFACE_POINTS)]
    for part in ("setups", "points"):
        (out / part).mkdir(parents=True, exist_ok=True)
    where = out / "where.csv"
    with open(where, "w", newline="") as target:
        columns = [f"{part}_{axis}" for part in ("position", "normal") for axis in "xyz"] + ["kind"]
        table = csv.DictWriter(target, columns, extrasaction="ignore")
        table.writeheader()
        table.writerows(surface)
    for i in range(count):
        name = f"{Path(scene).stem}_random_{i:02}"
        setup, truth = out / "setups" / f"{name}.json", out / "points" / f"{name}.csv"
        rng = random.Random(i)
        while not truth.exists():
            lights = [light(KINDS[i % len(KINDS)], rng, open_space)]
            described = {"version": 1, "name": name, "scene": Path(scene).name, "use_emissive": False}
            setup.write_text(json.dumps(described | {"lights": lights, "cameras": []}, indent=1))
            arguments = ["reference", scene, "--setup", setup, "--points", where, "--samples", str(SAMPLES), "-o", truth]
            subprocess.run(["cargo", "run", "--release", "--quiet", "--", *arguments], check=True)
            if is_dark(truth):
                truth.unlink()


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]))

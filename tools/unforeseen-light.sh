#!/usr/bin/env bash
# Compares the radiance metric with the plain one under light that the bake's ensemble never holds, as Markdown rows.
#
#   tools/unforeseen-light.sh SCENE.glb POINTS.csv OUT PLAIN_ERROR SETUP.json... [-- BAKE_OPTION...]
#
# The scene is baked twice: as by default, and with the plain metric and an error of PLAIN_ERROR, to be
# chosen so that both take about the same bytes. The truth is path-traced at the positions in POINTS.csv.
# tools/unforeseen-light/ has a spot of three degrees, a lamp that nearly touches the floor, and blue light from below.
set -euo pipefail

scene=$1 points=$2 out=$3 plain_error=$4
shift 4
# shellcheck source=tools/evaluation.sh
source "$(dirname "${BASH_SOURCE[0]}")/evaluation.sh"
error_of() {
    probelight eval "$out/$1.plight" --setup "$2" --points "$3" --json --quiet > "$out/eval.json"
    awk -v x="$(number relative_rmse "$out/eval.json")" -v p="$(number p95_relative_error "$out/eval.json")" \
        'BEGIN { printf "%.2f %% | %.1f %%", 100 * x, 100 * p }'
}

mkdir -p "$out"
probelight bake "$scene" -o "$out/radiance.plight" --json --quiet "$@" > "$out/radiance.json"
probelight bake "$scene" -o "$out/plain.plight" --json --quiet --metric plain --error "$plain_error" "$@" \
    > "$out/plain.json"
printf 'bytes per receiver: radiance %.0f, plain %.0f\n' "$(number matrix_bytes_per_receiver "$out/radiance.json")" \
    "$(number matrix_bytes_per_receiver "$out/plain.json")"
for setup in "${setups[@]}"; do
    name=$(basename "$setup" .json)
    truth="$out/$name.csv"
    [[ -e $truth ]] ||
        probelight reference "$scene" --setup "$setup" --points "$points" --samples 1024 -o "$truth" --quiet
    printf '| %s | %s | %s |\n' "$name" "$(error_of radiance "$setup" "$truth")" "$(error_of plain "$setup" "$truth")"
done

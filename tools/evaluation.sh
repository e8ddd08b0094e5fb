# What the scripts that bake and evaluate share; to be sourced when "SETUP... [-- BAKE_OPTION...]" is left of the arguments.
# Sets `setups`, and leaves the bake options in "$@".

setups=()
while (($#)) && [[ $1 != -- ]]; do
    setups+=("$1")
    shift
done
shift || true

probelight() { cargo run --release --quiet -- "$@"; }
# The first number of that name in pretty-printed JSON.
number() { sed -nE "s/^ *\"$1\": (-?[0-9.e-]+),?$/\1/p" "$2" | head -n 1; }

#!/usr/bin/env bash
# What browsers get: the runtime on the GPU, and the page with the window. Sees to it that nothing comes along that needs
# threads, files or waiting, checks all of it for WebAssembly, where warnings are errors, and builds the page. Where the target's
# standard library is not installed, rustup is asked for it; without it checking and building is skipped, which is said.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

target=wasm32-unknown-unknown
runtime=(-p probelight-runtime --no-default-features --features gpu)
page=(-p probelight-web)
# The page finds what the mouse points at by the tracer, whose threads are then the page's only one.
not_in_runtime=(gltf obvhs pollster probelight-trace rayon tempfile)
not_in_page=(egui-file-dialog faer probelight-bake tempfile uvunwrap)

# Which of some crates the arguments for `cargo tree` lead to: find NAMES ARGUMENTS...
find_crates() {
    local -n names=$1
    local tree
    tree=$(cargo tree --edges normal --prefix none --format '{p}' "${@:2}")
    cut -d ' ' -f 1 <<<"$tree" | sort -u | grep -xF -f <(printf '%s\n' "${names[@]}") | xargs || true
}

# lacks WHAT NAMES ARGUMENTS...: fails if it has one of them.
lacks() {
    local found
    found=$(find_crates "${@:2}")
    [[ -z $found ]] || { echo "In browsers $1 must do without these crates: $found" >&2; exit 1; }
}

# has NAMES ARGUMENTS...: if natively one were missing by name, `lacks` would find nothing either.
has() {
    local found
    local -n all=$1
    found=$(find_crates "$@")
    [[ $found == "${all[*]}" ]] ||
        { echo "Of the crates that browsers do without (${all[*]}), these are all that others use: $found" >&2; exit 1; }
}

lacks 'the runtime' not_in_runtime --target "$target" "${runtime[@]}"
has not_in_runtime -p probelight-runtime -p probelight-asset
lacks 'the page' not_in_page --target "$target" "${page[@]}"
has not_in_page -p probelight-viewer

is_installed() { [[ -d $(rustc --print target-libdir --target "$target") ]]; }
if ! is_installed; then
    timeout 60 rustup target add "$target" >/dev/null 2>&1 || true
fi
if is_installed; then
    # Instead of the workspace's own flags, which are for native code.
    RUSTFLAGS='' cargo clippy --profile web --target "$target" "${page[@]}" --features library -- -D warnings
    tools/build-web.sh
else
    echo "Skipped: building for browsers needs \`rustup target add $target\`, which did not work here." >&2
fi

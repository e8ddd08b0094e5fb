#!/usr/bin/env bash
# The runtime on the GPU as browsers get it: compiles it for WebAssembly, where warnings are errors, and sees to it that
# nothing comes along that needs threads, files or waiting. Where the target's standard library is not installed, rustup
# is asked for it; without it the compilation is skipped, which is said.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

target=wasm32-unknown-unknown
browser=(-p probelight-runtime --no-default-features --features gpu)
unwanted=(gltf obvhs pollster probelight-trace rayon tempfile)

# Which of the unwanted crates the arguments for `cargo tree` lead to.
find_unwanted() {
    local tree
    tree=$(cargo tree --edges normal --prefix none --format '{p}' "$@")
    cut -d ' ' -f 1 <<<"$tree" | sort -u | grep -xF -f <(printf '%s\n' "${unwanted[@]}") | xargs || true
}

found=$(find_unwanted --target "$target" "${browser[@]}")
if [[ -n $found ]]; then
    echo "In browsers the runtime must do without these crates: $found" >&2
    exit 1
fi
# If natively none were missing by name, the check above would find nothing either.
found=$(find_unwanted -p probelight-runtime -p probelight-asset)
if [[ $found != "${unwanted[*]}" ]]; then
    echo "Of the crates that browsers do without (${unwanted[*]}), these are all that others use: $found" >&2
    exit 1
fi

is_installed() { [[ -d $(rustc --print target-libdir --target "$target") ]]; }
if ! is_installed; then
    timeout 60 rustup target add "$target" >/dev/null 2>&1 || true
fi
if is_installed; then
    # Instead of the workspace's own flags, which are for native code.
    RUSTFLAGS='-D warnings' cargo check --target "$target" "${browser[@]}"
else
    echo "Skipped: compiling for browsers needs \`rustup target add $target\`, which did not work here." >&2
fi

#!/usr/bin/env bash
# Builds the page for browsers into apps/web/dist (or the folder given): static files, to be handed out by any server.
# Needs the target wasm32-unknown-unknown, which rustup is asked for where it is missing. If `wasm-opt` (of binaryen) is
# there, it makes the module smaller.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

target=wasm32-unknown-unknown
page=${1:-apps/web/dist}
built=${CARGO_TARGET_DIR:-target}

[[ -d $(rustc --print target-libdir --target "$target") ]] || rustup target add "$target"
# Instead of the workspace's own flags, which are for native code.
RUSTFLAGS='' cargo build --profile web --target "$target" -p probelight-web
cargo build --release -p web-bindings

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$built/release/web-bindings" "$built/$target/web/probelight_web.wasm" "$work"
if command -v wasm-opt >/dev/null; then
    module=$work/probelight_web_bg.wasm
    wasm-opt -Os --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext --enable-reference-types \
        --enable-multivalue --enable-mutable-globals "$module" -o "$module"
fi
cp apps/web/static/* "$work"
rm -f "$work"/*.d.ts
mkdir -p "$page"
cp "$work"/* "$page"

compressed() { gzip -9 -c "$@" | wc -c; }
printf '%s: %d bytes, compressed by gzip %d\n' "$page" "$(cat "$page"/* | wc -c)" "$(compressed "$page"/*)"

#!/usr/bin/env bash
# Builds for browsers: `build-web.sh` the page, into apps/web/dist; `build-web.sh package` the JavaScript package, into
# apps/web/package. Both are static files, to be handed out by any server. Needs the target wasm32-unknown-unknown, which
# rustup is asked for where it is missing. If `wasm-opt` (of binaryen) is there, it makes the modules smaller.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

target=wasm32-unknown-unknown
built=${CARGO_TARGET_DIR:-target}
case ${1:-page} in
page) out=apps/web/dist features=page ;;
package) out=apps/web/package features=library ;;
*) echo "usage: $0 [page|package]" >&2 && exit 2 ;;
esac

[[ -d $(rustc --print target-libdir --target "$target") ]] || rustup target add "$target"
# Instead of the workspace's own flags, which are for native code.
RUSTFLAGS='' cargo build --profile web --target "$target" -p probelight-web --no-default-features --features "$features"

cargo build --release -p web-bindings

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$built/release/web-bindings" "$built/$target/web/probelight_web.wasm" "$work"
module=$work/probelight_web_bg.wasm
if command -v wasm-opt >/dev/null; then
    # An old one may not know the module; it is good without.
    wasm-opt -Os --all-features "$module" -o "$work/small" && mv "$work/small" "$module" || rm -f "$work/small"
fi
mkdir -p "$out"
[[ $features == library ]] || cp apps/web/static/* "$out"
cp "$work"/*.js "$module" "$out"

files=("$out"/*.*)
compressed=0
for file in "${files[@]}"; do
    compressed=$((compressed + $(gzip -9 -c "$file" | wc -c)))
done
echo "$out: $(cat "${files[@]}" | wc -c) bytes, compressed by gzip $compressed"

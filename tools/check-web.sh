#!/usr/bin/env bash
# Uses the page of `probelight web` in a browser without a window, whose GPU is a driver in software: tools/check-web/check.mjs
# says how. Leaves pictures and setups in the folder given. Needs the page that tools/build-web.sh builds, Chromium and
# Node.js (tools/test.sh installs these two); without them it says that it is skipped. PROBELIGHT names the program.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

skip() {
    echo "SKIPPED: $*" >&2
    exit 0
}

out=$(realpath "$1")
page=apps/web/dist
module=$page/probelight_web_bg.wasm
browser=
for name in chromium chromium-browser google-chrome; do
    browser=${browser:-$(command -v "$name" || true)}
done
[[ -n $browser ]] || skip 'there is no Chromium'
command -v node >/dev/null || skip 'there is no Node.js'
[[ -f $module ]] || skip 'the page is not built: run tools/build-web.sh'
newer=$(find crates/*/src apps/web/src apps/web/static -newer "$module" -name '*.*' -print -quit)
[[ -z $newer ]] || skip "$newer is newer than the page: run tools/build-web.sh"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PROBELIGHT:-target/release/probelight}" web "$work/site" crates/probelight-render/tests/data/cornell.plight \
    --setup assets/setups/cornell_lamp.json --quiet
node tools/check-web/check.mjs "$browser" "$work/site" "$out"

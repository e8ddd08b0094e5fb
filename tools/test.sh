#!/usr/bin/env bash
# All tests. Those of the GPU need a Vulkan driver: where there is none, Mesa's driver in software is installed first,
# if this is a Debian-like Linux and we may. Without one they say that they are skipped; with CI=true they fail.
# The test that uses the window needs Xvfb, xdotool, ImageMagick and Weston, which are installed likewise; without them it is skipped.
# So is the test that uses the page in a browser without Chromium, Node.js, and the page, which tools/build-web.sh builds.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

has_vulkan_driver() {
    [[ -n ${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-} ]] ||
        compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}

install() {
    local as_root=()
    ((EUID == 0)) || as_root=(sudo --non-interactive)
    run() { "${as_root[@]}" apt-get install -y -q "$@"; }
    { run "$@" || { "${as_root[@]}" apt-get update -q && run "$@"; }; } >&2
}

if [[ $(uname) == Linux ]] && ! has_vulkan_driver; then
    if ! command -v apt-get >/dev/null; then
        echo 'No Vulkan driver: tests of the GPU are skipped. Install your system'\''s Mesa Vulkan drivers to run them.' >&2
    else
        echo 'No Vulkan driver: installing mesa-vulkan-drivers, which runs the tests of the GPU in software.' >&2
        install mesa-vulkan-drivers || echo 'It could not be installed: tests of the GPU are skipped.' >&2
    fi
fi
if [[ $(uname) == Linux ]] && command -v apt-get >/dev/null && ! { command -v Xvfb && command -v xdotool && command -v import && command -v weston; } >/dev/null; then
    echo 'Installing xvfb, xdotool, imagemagick and weston for the test of the window.' >&2
    install xvfb xdotool imagemagick weston || echo 'They could not be installed: it is skipped.' >&2
fi

if [[ $(uname) == Linux ]] && command -v apt-get >/dev/null && ! { command -v chromium || command -v google-chrome; } >/dev/null; then
    echo 'Installing chromium for the test of the page.' >&2
    install chromium || echo 'It could not be installed: the test is skipped.' >&2
fi
if [[ $(uname) == Linux ]] && command -v apt-get >/dev/null && ! command -v node >/dev/null; then
    echo 'Installing nodejs for the test of the page.' >&2
    install nodejs || echo 'It could not be installed: the test is skipped.' >&2
fi

# Vulkan drivers complain without a folder of their own.
if [[ -z ${XDG_RUNTIME_DIR:-} ]]; then
    XDG_RUNTIME_DIR=$(mktemp -d)
    export XDG_RUNTIME_DIR
    trap 'rm -rf "$XDG_RUNTIME_DIR"' EXIT
fi

cargo test --release --workspace "$@"

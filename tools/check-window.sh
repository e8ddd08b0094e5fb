#!/usr/bin/env bash
# Opens the window on a display of its own, uses keys and mouse as one would, and checks what comes of it: pictures, saved
# setup, exit code; then once more on Wayland. With a folder as argument it leaves screenshots for the documents
# there. Needs Xvfb, xdotool and ImageMagick, and for Wayland Weston (tools/test.sh installs them); what it cannot do
# without them it says. PROBELIGHT names the program; without it, it is built.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
pictures=${1:+$(realpath "$1")}

for tool in Xvfb xdotool import; do
    command -v "$tool" >/dev/null || {
        echo "SKIPPED: there is no $tool" >&2
        exit 0
    }
done

[[ -n ${PROBELIGHT:-} ]] || cargo build --release
program=$(realpath "${PROBELIGHT:-target/release/probelight}")
work=$(mktemp -d)
export HOME=$work XDG_RUNTIME_DIR=$work XDG_DATA_HOME=$work
unset WAYLAND_DISPLAY
Xvfb -displayfd 3 -screen 0 1280x720x24 3>"$work/display" >/dev/null 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null; rm -rf "$work"' EXIT
for _ in $(seq 50); do [[ -s $work/display ]] && break || sleep 0.1; done
DISPLAY=:$(cat "$work/display")
export DISPLAY

fail() {
    echo "FAILED: $*" >&2
    exit 1
}
wait_for() { # SECONDS WHAT COMMAND...
    local deadline=$((SECONDS + $1)) what=$2
    shift 2
    until "$@"; do
        ((SECONDS < deadline)) || fail "$what"
        sleep 0.3
    done
}
key() { xdotool key --delay 60 "$@"; sleep 0.7; }
# Around the scene by the mouse, as slowly as a hand.
drag() {
    xdotool mousemove 560 420 sleep 0.1 mousedown 1
    for x in 570 580 590 600; do xdotool sleep 0.1 mousemove "$x" $((420 + (x - 560) / 6)); done
    xdotool sleep 0.1 mouseup 1
}
shot() { import -window root "$work/$1.png"; }
# Mean brightness of the picture's middle, 0 to 1.
brightness() { convert "$work/$1.png" -gravity center -crop 300x200+0-80 -colorspace Gray -format '%[fx:mean]' info:; }
differ() { [[ $(compare -metric AE -fuzz 3% "$work/$1.png" "$work/$2.png" null: 2>&1 | cut -d. -f1) -gt 2000 ]]; }
is_lit() { shot now; awk "BEGIN { exit !($(brightness now) > 0.05) }"; }
has_another_lamp() { [[ $(grep -c '"type": "point"' "$work/setup.json") = $((lamps + 1)) ]]; }

# Small and coarse, as drivers in software take their time; for the documents better.
coarse=(--receivers 3000 --rays 64 --grid 0) resolution=0.25 slow=1
[[ -z $pictures ]] || coarse=(--quality preview) resolution=0.6 slow=4
"$program" bake assets/scenes/cornell.glb -o "$work/scene.plight" "${coarse[@]}" --quiet
cp assets/setups/cornell_lamp.json "$work/setup.json"
lamps=$(grep -c '"type": "point"' "$work/setup.json" || true)
cd "$work"
"$program" view scene.plight --setup setup.json --size 1280x720 --resolution $resolution 2>"$work/log" &
viewer=$!
has_opened_or_ended() { xdotool search --name Probelight >/dev/null || ! kill -0 "$viewer" 2>/dev/null; }
wait_for 180 'no window opened' has_opened_or_ended
if grep -q 'no GPU was found' log; then
    echo 'SKIPPED: there is no Vulkan driver' >&2
    exit 0
fi
wait_for 60 'no window opened' xdotool search --name Probelight >/dev/null
xdotool search --name Probelight windowmove 0 0 windowfocus 2>/dev/null || true
# Once its light has settled it rests, and costs nothing.
ticks() { awk '{ print $14 + $15 }' "/proc/$viewer/stat"; }
rests() {
    local before
    before=$(ticks)
    sleep 3
    (($(ticks) - before <= 9))
}
# Large pictures take their time.
pause() { sleep $(($1 * slow)); }

wait_for 300 'the picture stays dark' is_lit
pause 3
shot lit
[[ -z $pictures ]] || cp lit.png "$pictures/viewer.png"

# The mouse: the camera goes around; what is clicked is picked.
drag
pause 3
shot turned
differ lit turned || fail 'dragging does not turn the camera'
xdotool mousemove 600 460 click 1
pause 6
shot picked
differ turned picked || fail 'a click picks nothing'
[[ -z $pictures ]] || cp picked.png "$pictures/viewer-picked.png"

# Keys: a lamp and a ball, undone and done again; saved.
key l
key b
key ctrl+z
key ctrl+z
key ctrl+shift+z
key ctrl+s
wait_for $((10 * slow)) 'the lamp was not saved' has_another_lamp
key g
pause 2
shot direct
differ picked direct || fail 'indirect light cannot be switched off'
key g c
pause 3
shot compared
[[ -z $pictures ]] || cp compared.png "$pictures/viewer-compared.png"
key c c 8
pause 3
shot clusters
differ compared clusters || fail 'digits do not change the view'
key 1 F1
pause 1
shot help
differ clusters help || fail 'there is no help'
key F1 F12
wait_for $((20 * slow)) 'no picture was saved' test -s probelight-001.png

# All frames of a drag are saved, none after it.
key F11
drag
wait_for $((20 * slow)) 'no frames were saved' test -s probelight-frames-001/00002.png
key F11
pause 1
frames=$(ls probelight-frames-001 | wc -l)
drag
pause 2
[[ $(ls probelight-frames-001 | wc -l) = "$frames" ]] || fail 'frames are still saved'

wait_for $((600 * slow)) 'it never rests' rests

key ctrl+q
wait_for $((20 * slow)) 'it does not quit' bash -c "! kill -0 $viewer 2>/dev/null"
wait "$viewer" || fail "exit code $?: $(cat log)"
! grep -i -E 'panic|error' log || fail 'it complained'

# The same on Wayland, on a compositor of its own.
if ! command -v weston >/dev/null; then
    echo 'SKIPPED on Wayland: there is no weston' >&2
else
    weston --backend=headless-backend.so --use-pixman --debug --width=1280 --height=720 --socket=wayland-check --idle-time=0 >"$work/weston" 2>&1 &
    compositor=$!
    trap 'kill "$server" "$compositor" 2>/dev/null; rm -rf "$work"' EXIT
    export WAYLAND_DISPLAY=wayland-check
    wait_for 20 'no compositor' test -S "$work/wayland-check"
    env -u DISPLAY "$program" view scene.plight --setup setup.json --size 1000x600 --resolution 0.25 2>"$work/log" &
    viewer=$!
    is_lit_on_wayland() {
        kill -0 "$viewer" || fail "it ended on Wayland: $(cat log)"
        rm -f wayland-screenshot-*.png
        weston-screenshooter && mv wayland-screenshot-*.png now.png
        awk "BEGIN { exit !($(brightness now) > 0.05) }"
    }
    wait_for 120 'the picture stays dark on Wayland' is_lit_on_wayland
    wait_for 300 'it never rests on Wayland' rests
    kill "$viewer"
    ! grep -i -E 'panic|error' log || fail 'it complained on Wayland'
fi
echo 'the window works'

#!/bin/bash
# SPDX-License-Identifier: MIT
# Times Penumbra against POV-Ray on one scene: vs_povray.sh BUILD [SCENE] [RUNS]
# For soft shadows: soft_room.py > soft_room.json, with soft_room.json as SCENE.
# Both run as whole programs with two threads and write a PNG. Their runs are interleaved, so that
# other load on the machine slows both alike; the ratio is that of the medians. Processor time does not
# show how well threads are used, but it is more reliable than wall time on a busy machine.
set -eu
here=$(dirname "$0")
build=${1:?usage: vs_povray.sh BUILD [SCENE] [RUNS]}
scene=${2:-$here/../../scenes/room.json}
runs=${3:-5}
threads=2

command -v povray >/dev/null || { echo "vs_povray.sh: povray is not installed (apt-get install povray)" >&2; exit 3; }
command -v python3 >/dev/null || { echo "vs_povray.sh: python3 is not installed" >&2; exit 3; }
[ -x "$build/penumbra" ] || { echo "vs_povray.sh: $build/penumbra is not built" >&2; exit 3; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 "$here/to_pov.py" "$scene" > "$work/scene.pov"
read -r width height < <(sed -n '1s|^// width=\([0-9]*\) height=\([0-9]*\).*|\1 \2|p' "$work/scene.pov")

render_penumbra() {
    "$build/penumbra" render "$scene" -o "$work/penumbra.png" --threads $threads >"$work/penumbra.log" 2>&1
}
render_povray() {
    HOME=$work povray "+I$work/scene.pov" "+O$work/povray.png" +FN "+W$width" "+H$height" \
        "+WT$threads" +Q9 -A -D -P -V >"$work/povray.log" 2>&1
}
# Runs a function, and appends its wall time and processor time in seconds to its file.
timed() {
    local TIMEFORMAT='%R %U %S'
    if ! { time "$1"; } 2>"$work/time"; then
        echo "vs_povray.sh: $1 failed:" >&2
        tail -n 20 "$work/${1#render_}.log" >&2
        exit 1
    fi
    awk '{ print $1, $2 + $3 }' "$work/time" >>"$work/$1.times"
}
# The median, least and greatest value of a column of a function's file.
median() {
    awk -v column="$2" '{ print $column }' "$work/$1.times" | sort -n | awk '{ t[NR] = $1 } END {
        m = NR % 2 ? t[(NR + 1) / 2] : (t[NR / 2] + t[NR / 2 + 1]) / 2
        printf "%.3f %.3f %.3f\n", m, t[1], t[NR] }'
}

for ((i = 0; i < runs; i++)); do
    timed render_penumbra
    timed render_povray
done
echo "$(basename "$scene"), ${width}x$height, $threads threads, $runs interleaved runs"
for column in 1 2; do
    [ $column = 1 ] && kind=wall || kind=processor
    read -r pen pen_low pen_high < <(median render_penumbra $column)
    read -r pov pov_low pov_high < <(median render_povray $column)
    echo "$kind time"
    echo "  penumbra  median $pen s  ($pen_low to $pen_high)"
    echo "  povray    median $pov s  ($pov_low to $pov_high)"
    awk -v a="$pov" -v b="$pen" 'BEGIN { printf "  povray / penumbra = %.2f\n", a / b }'
done

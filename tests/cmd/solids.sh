#!/bin/sh
# SPDX-License-Identifier: MIT
# Features of users' scenes besides shapes: an index of 1, triangles without area, colours from 0 to 255, a
# view along y, a cone seen along its axis. The scenes are from reports.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
corpus=$root/tests/io/corpus/good
report() { printf '%s' "$corpus/report-$1.json"; }
quietly() { "$penumbra" render "$@" -q 2>/dev/null; }
rmse() { "$penumbra" compare "$1" "$2" --json | jq .rmse; }

# A bubble is the same with an index of 1 and of nearly 1, and another picture without one
quietly "$(report bubble-ior-1)" -o one.pfm
sed 's/"ior": 1}/"ior": 1.000000001}/' "$(report bubble-ior-1)" >nearly.json
sed 's/, "ior": 1}/}/' "$(report bubble-ior-1)" >none.json
quietly nearly.json -o nearly.pfm
quietly none.json -o none.pfm
expect "the bubble is there" "$(jq -n "$(rmse one.pfm nearly.pfm) < 1e-6")" true
expect "without an index it is not" "$(jq -n "$(rmse one.pfm none.pfm) > 0.05")" true

# Where the box of no other solid is near, a written 1 changes no byte and no count of rays
same_without() { # NAME: NAME.json, and that scene without the key
    sed 's/, "ior": 1}/}/' "$1.json" >"$1-none.json"
    for scene in "$1" "$1-none"; do
        quietly "$scene.json" -o "$scene.png" --stats "$scene.stats"
    done
    check "$1: 1 changes no byte" cmp "$1.png" "$1-none.png"
    expect "$1: and no ray" "$(jq -c '.rays, .effects, .kernel' "$1.stats")" \
        "$(jq -c '.rays, .effects, .kernel' "$1-none.stats")"
}
sed 's/\[0, 1, 0\], "radius": 0.95/[0, 4, 0], "radius": 0.95/' "$(report bubble-ior-1)" >apart.json
same_without apart
sed 's/, "ior": 1.5}/}/' "$(report bubble-ior-1)" >air.json
same_without air

# What is left out changes no byte; the render says what it has left out
jq 'del(.objects[1])' "$(report one-degenerate-triangle)" >one.json
quietly one.json -o one.png
exits "a triangle without area" 0 "$penumbra" render "$(report one-degenerate-triangle)" -o all.png -q
prints "it is counted" stderr "/objects/1: warning: 1 triangle or polygon without area"
check "the rest is the picture" cmp one.png all.png
for scene in polygon-closed left-out; do
    exits "$scene" 0 "$penumbra" render "$corpus/$scene.json" -o s.png --set width=40 --set height=30 -q
    prints "$scene: vertices are counted" stderr "at the end, which is left out"
done

# A view along y: the picture is that of the `up` told
exits "looking down" 0 "$penumbra" render "$(report looking-down)" -o down.png -q
prints "up is told" stderr "[0, 0, -1] is taken as up"
jq '.camera.up = [0, 0, -1]' "$(report looking-down)" >up.json
exits "with up" 0 "$penumbra" render up.json -o up.png -q
expect "with up, nothing is told" "$(cat stderr)" ""
check "the same picture" cmp down.png up.png
jq '.camera.up = [0, -2, 0]' "$(report looking-down)" >parallel.json
exits "a written parallel up" 3 "$penumbra" render parallel.json -o up.png -q

exits "colours from 0 to 255" 0 "$penumbra" render "$(report colours-255)" -o c.png -q
prints "the likely meaning" stderr "/background: warning: [40, 90, 160] looks like a colour from 0 to 255"
exits "nothing visible" 0 "$penumbra" render "$corpus/nothing-visible.json" -o n.png --set width=40 --set height=30 -q
prints "it is told" stderr "nothing is visible: all objects are behind the camera"

for pixel in 30,30 29,30 30,31; do
    value=$("$penumbra" render "$(report cone-apex)" --pixel $pixel --json | jq '.linear[0]')
    expect "the cone's apex, pixel $pixel" "$(jq -n "$value - 0.5 * (2 | sqrt) | fabs < 1e-9")" true
done
finish

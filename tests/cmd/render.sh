#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbra render`, `validate`, `scenes` and `compare`: no daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

cat >scene.json <<'SCENE'
{
  "format": "penumbra-scene/1",
  "background": [0.1, 0.2, 0.4],
  "ambient": [0.05, 0.05, 0.05],
  "camera": {"position": [0, 0, 10], "look_at": [0, 0, 0], "fov_degrees": 40},
  "views": [{"name": "front", "camera": {}},
            {"name": "side", "camera": {"position": [10, 2, 0]}}],
  "lights": [{"type": "point", "intensity": [0.9, 0.8, 0.7], "position": [4, 5, 6]}],
  "objects": [
    {"type": "sphere", "center": [0, 0, 0], "radius": 2,
     "material": {"kd": [0.8, 0.3, 0.2], "ks": 0.4, "shininess": 20, "kr": 0.2}},
    {"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0], "material": {"kd": 0.6}}
  ],
  "render": {"width": 61, "height": 43}
}
SCENE
sed 's/"radius": 2,/"radius": -2,/; s/"kd": 0.6/"kd": 7/; s/"ambient"/"ambiant"/' scene.json >bad.json

# Numbers that are too coarse for the picture
sed 's/\[0, 0, 10\]/[1e13, 0, 10]/; s/\[0, 0, 0\]/[1e13, 0, 0]/' scene.json >coarse.json
ends "render far away" 0 "$penumbra" render coarse.json -o far.png --stats far.json
says "warns" stderr 'coarse.json: view "front": warning: coordinates reach to 1e+13'
expect "in the statistics, too" "$(jq '.precision | .resolution < 256 and has("warning")' far.json)" true
ends "validate far away" 0 "$penumbra" validate coarse.json
says "warns of the view" stderr 'coarse.json: /views/0: warning: coordinates reach to 1e+13'
ends "the other view of it" 0 "$penumbra" render scene.json --view side -o near.png --stats near.json
expect "is not warned of" "$(cat stderr)$(jq '.precision | .resolution > 1e9 and (has("warning") | not)' near.json)" true

# Formats and sources
ends "render to png" 0 "$penumbra" render scene.json -o a.png
expect "prints nothing" "$(cat stdout stderr)" ""
expect "writes a png" "$(head -c 4 a.png | tail -c 3)" "PNG"
ends "render to pfm" 0 "$penumbra" render scene.json -o a.pfm
expect "writes a pfm" "$(head -n 2 a.pfm | tr '\n' ' ')" "PF 61 43 "
ends "render to 16 bits" 0 "$penumbra" render scene.json -o deep.png --format png16
expect "writes 16 bits a channel" "$(od -An -tu1 -j24 -N1 deep.png | tr -d ' ')" 16
ends "--format wins over the ending" 0 "$penumbra" render scene.json -o odd.png --format pfm
check "and gives the same bytes" cmp odd.png a.pfm
"$penumbra" render - -o b.png <scene.json
check "standard input" cmp a.png b.png
"$penumbra" render scene.json -o - --format png >c.png
ends "standard output for two things" 2 "$penumbra" render scene.json -o - --format png --json
check "standard output" cmp a.png c.png
ends "a built-in scene" 0 "$penumbra" render builtin:spheres -o s.png --set width=40 --set height=30
check "is the file" sh -c "'$penumbra' render '$root/scenes/spheres.json' -o t.png --set width=40 \
    --set height=30 && cmp s.png t.png"

# The same bytes whatever the means
for threads in 1 2 3 8; do
    "$penumbra" render scene.json -o t.pfm --threads $threads
    check "$threads threads, same bytes" cmp t.pfm a.pfm
done
"$penumbra" render scene.json -o t.pfm --set tile=7 --set accelerator=none
check "other tiles and no accelerator, same bytes" cmp t.pfm a.pfm

# Settings, views, statistics
ends "--set" 0 "$penumbra" render scene.json -o small.pfm --set width=20 --set height=8e0
expect "changes the picture's size" "$(sed -n 2p small.pfm)" "20 8"
mkdir folder.png
for out in folder.png none/x.png; do # and not only when hours of work are done
    ends "a picture that cannot be written: $out" 8 timeout 60 "$penumbra" render scene.json \
        -o "$out" --set width=6000 --set height=4300 --set samples_per_pixel=100000
    says "is told at once" stderr "cannot write $out"
    ends "statistics that cannot be written: $out" 8 timeout 60 "$penumbra" render scene.json \
        --stats "$out" --set width=6000 --set height=4300 --set samples_per_pixel=100000
done
ends "picture and statistics in one file" 2 "$penumbra" render scene.json -o x.png --stats x.png
expect "leaves nothing behind" "$(echo x.png* folder.png*)" "x.png* folder.png"
ends "a setting that is misspelt" 2 "$penumbra" render scene.json -o x.png --set widht=20
says "is answered with the nearest" stderr '"width"'
ends "a setting out of range" 2 "$penumbra" render scene.json -o x.png --set width=0
ends "--view" 0 "$penumbra" render scene.json -o side.png --view side
if cmp -s side.png a.png; then
    not_ok "another view is another picture" "same bytes"
else
    ok "another view is another picture"
fi
"$penumbra" render scene.json -o front.png --view front
check "the first view is the default" cmp front.png a.png
ends "a view that is not there" 4 "$penumbra" render scene.json -o x.png --view sidd
says "is answered with the nearest" stderr 'nearest is "side"'
ends "--stats" 0 "$penumbra" render scene.json --stats stats.json --threads 2
expect "counts primary rays" "$(jq .rays.primary stats.json)" $((61 * 43))
expect "counts threads" "$(jq .threads stats.json)" 2
ends "--json" 0 "$penumbra" render scene.json -o a.png --json
expect "prints one line" "$(wc -l <stdout | tr -d ' ')" 1
expect "with what was made" "$(jq -c '[.output, .format, .view, .width, .height]' stdout)" \
    '["a.png","png","front",61,43]'
expect "and the statistics" "$(jq .stats.rays.primary stdout)" $((61 * 43))

# One pixel: the very values of the film, which has its bottom row first
cat >film_pixel.py <<'PYTHON'
import json, struct, sys
film, x, y = open(sys.argv[1], "rb").read(), int(sys.argv[2]), int(sys.argv[3])
at = len(film) - 61 * 43 * 12 + ((42 - y) * 61 + x) * 12
pixel = json.load(sys.stdin)
sys.exit([float.fromhex(v) for v in pixel["film_hex"]] != list(struct.unpack_from("<3f", film, at)))
PYTHON
for at in 30,20 0,0 60,42 12,33; do
    "$penumbra" render scene.json --pixel $at --json >pixel.json
    check "--pixel $at is the film's" python3 film_pixel.py a.pfm ${at%,*} ${at#*,} <pixel.json
done
ends "--pixel for people" 0 "$penumbra" render scene.json --pixel 30,20
says "shows rays" stdout "rays    primary 1, shadow"
says "shows hexadecimal floats" stdout "0x1."

# A result is there whole or not at all
echo precious >keep.png
chmod 640 keep.png
ends "a scene with errors" 3 "$penumbra" render bad.json -o keep.png
expect "leaves the old output" "$(cat keep.png)" precious
says "locates a wrong value" stderr "bad.json: "
says "by pointer" stderr "/objects/0/radius"
says "locates another" stderr "/objects/1/material/kd"
says "names the nearest key" stderr '"ambient"'
expect "prints one line an error" "$(grep -c '^penumbra: bad.json' stderr)" 3
ends "and with --json" 3 "$penumbra" render bad.json -o keep.png --json
expect "a problem document too" "$(jq .status stdout)" 422
check "a picture replaces the old one" "$penumbra" render scene.json -o keep.png
check "whole" cmp keep.png a.png
expect "and keeps its mode" "$(stat -c %a keep.png)" 640
ln -s keep.png link.png
check "a link is followed" "$penumbra" render scene.json -o link.png --view side
check "to what it leads to" sh -c "test -L link.png && cmp keep.png side.png"
expect "no temporary file stays" "$(ls | grep -c '.png.')" 0
ends "an output that cannot be written" 8 "$penumbra" render scene.json -o /nonexistent/a.png
ends "a full disk" 8 "$penumbra" render scene.json -o /dev/full --format png
ends "an input that is not there" 4 "$penumbra" render nothing.json -o x.png
ends "an input that is a folder" 8 "$penumbra" render . -o x.png
ends "a built-in scene that is not there" 4 "$penumbra" render builtin:sheres -o x.png
says "is answered with the nearest" stderr 'nearest is "spheres"'
printf '{"format": "penumbra-scene/1",\n "camera": }' >broken.json
ends "malformed JSON" 3 "$penumbra" render broken.json -o x.png
says "is located by line and column" stderr "broken.json:2:"
ends "an empty input" 3 "$penumbra" render /dev/null -o x.png

# validate and scenes
ends "validate a good scene" 0 "$penumbra" validate scene.json builtin:room
says "says so" stdout "scene.json: valid"
ends "validate a bad one among good ones" 3 "$penumbra" validate scene.json bad.json
says "says which" stderr "penumbra: bad.json: "
says "and still does the others" stdout "scene.json: valid"
ends "validate --json" 0 "$penumbra" validate scene.json --json
expect "is the service's answer" "$(jq .valid stdout)" true
ends "scenes" 0 "$penumbra" scenes
says "lists the room" stdout "room"
ends "scenes NAME" 0 "$penumbra" scenes room
check "prints the scene" cmp stdout "$root/scenes/room.json"
ends "scenes --json" 0 "$penumbra" scenes --json
expect "is a list" "$(jq -r '.scenes | map(.name) | index("spheres") != null' stdout)" true
ends "scenes of a wrong name" 4 "$penumbra" scenes rom

# compare
ends "equal pictures" 0 "$penumbra" compare a.png front.png --max-error 0
says "have no error" stdout "rmse       0"
ends "different pictures without a bound" 0 "$penumbra" compare a.png side.png
ends "different pictures" 7 "$penumbra" compare a.png side.png --max-rmse 0.001
says "are said to differ" stderr "the pictures differ: rmse"
ends "different pictures, largest error" 7 "$penumbra" compare a.png side.png --max-error 0.001 -q
expect "quietly" "$(cat stdout stderr)" ""
ends "8 bits against the film" 0 "$penumbra" compare a.png a.pfm --json
expect "differ by rounding only" "$(jq '.max_error < 0.00197 and .max_error > 0' stdout)" true
expect "name their figures" "$(jq -c 'has("rmse") and has("psnr") and has("differing")' stdout)" true
ends "pictures of different sizes" 3 "$penumbra" compare a.png small.pfm
ends "a file that is no picture" 3 "$penumbra" compare a.png scene.json
says "is named" stderr "scene.json"

finish

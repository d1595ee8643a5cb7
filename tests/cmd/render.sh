#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbra render`, `validate`, `scenes` and `compare`, without a daemon.
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

# Coordinates at which doubles are too coarse for the picture
sed 's/\[0, 0, 10\]/[1e13, 0, 10]/; s/\[0, 0, 0\]/[1e13, 0, 0]/' scene.json >coarse.json
exits "render with large coordinates" 0 "$penumbra" render coarse.json -o far.png --stats far.json
prints "warns of the view" stderr 'coarse.json: view "front": warning: coordinates reach to 1e+13'
expect "the statistics have the warning, too" "$(jq '.precision | .resolution < 256 and has("warning")' far.json)" true
exits "validate with large coordinates" 0 "$penumbra" validate coarse.json
prints "warns of the view" stderr 'coarse.json: /views/0: warning: coordinates reach to 1e+13'
# A wall narrower than 2^-30 of its length
jq '.objects[1] = {type: "polygon", vertices: [[0,0,0], [1,0,0], [1,1e-10,0], [0,1e-10,0]]}' scene.json >thin.json
exits "render with a thin wall" 0 "$penumbra" render thin.json -o far.png --stats far.json
prints "warns of the wall" stderr 'thin.json: primitive 1: warning: is 1e-10 wide and 1 long'
expect "the statistics have that warning, too" "$(jq '.precision | .thinness < 2e-10 and (.warning | startswith("primitive 1 is"))' far.json)" true
exits "validate with a thin wall" 0 "$penumbra" validate thin.json
prints "warns of the wall" stderr 'thin.json: /objects/1: warning: is 1e-10 wide and 1 long'
exits "render of a view with enough precision" 0 "$penumbra" render scene.json --view side -o near.png --stats near.json
expect "gives no warning" "$(cat stderr)$(jq '.precision | .resolution > 1e9 and (has("warning") | not)' near.json)" true

# Paths that fork at every surface
cat >forks.json <<'SCENE'
{
  "format": "penumbra-scene/1",
  "background": [1, 1, 1],
  "camera": {"position": [0, 0, 10], "look_at": [0, 0, 0], "fov_degrees": 25},
  "materials": {"all": {"kr": 1, "kt": 1}},
  "objects": [
    {"type": "sphere", "center": [-1.05, -0.6, 0], "radius": 1, "material": "all"},
    {"type": "sphere", "center": [1.05, -0.6, 0], "radius": 1, "material": "all"},
    {"type": "sphere", "center": [0, 1.2, 0], "radius": 1, "material": "all"}
  ],
  "render": {"width": 32, "height": 32, "max_depth": 60}
}
SCENE
exits "render a scene whose paths explode" 0 "$penumbra" render forks.json -o forks.pfm --stats forks-stats.json
cut=$(jq .truncated_paths forks-stats.json)
check "the statistics count paths cut off" [ "$cut" -gt 0 ]
prints "and a warning says how many" stderr "forks.json: view \"main\": warning: $cut paths are cut off"
"$penumbra" render forks.json --threads 1 --set tile=5 --set accelerator=none -o t.pfm --stats t.json 2>/dev/null
check "the picture is the same in another way" cmp t.pfm forks.pfm
expect "and so is the count" "$(jq .truncated_paths t.json)" "$cut"
for isa in base avx2 avx512; do
    PENUMBRA_ISA=$isa "$penumbra" render forks.json -o t.pfm 2>/dev/null
    check "the picture is the same with at most $isa" cmp t.pfm forks.pfm
done
exits "render it with max_depth 11" 0 "$penumbra" render forks.json --set max_depth=11 -o t.pfm --stats t.json
expect "nothing is cut off" "$(cat stderr)$(jq .truncated_paths t.json)" 0

# Samples that no picture can hold
sed 's/\[0.9, 0.8, 0.7\]/[1e60, 0, 0]/' scene.json >glaring.json
exits "render with a light of 1e60" 0 "$penumbra" render glaring.json -o glaring.png --stats glaring.stats
prints "says that samples are dropped" stderr ' of 2623 pixel samples are brighter than a picture can hold'
expect "as many as the statistics count" \
    "$(sed 's/.*warning: \([0-9]*\) of .*/\1/' stderr)" "$(jq .dropped_samples glaring.stats)"
exits "one such pixel" 0 "$penumbra" render glaring.json --pixel 30,40
prints "says it too" stderr 'warning: 1 of 1 pixel samples are brighter'

# Formats and sources
exits "render to png" 0 "$penumbra" render scene.json -o a.png
expect "render prints nothing" "$(cat stdout stderr)" ""
expect "writes a png" "$(head -c 4 a.png | tail -c 3)" "PNG"
exits "render to pfm" 0 "$penumbra" render scene.json -o a.pfm
expect "writes a pfm" "$(head -n 2 a.pfm | tr '\n' ' ')" "PF 61 43 "
exits "render to 16 bits" 0 "$penumbra" render scene.json -o deep.png --format png16
expect "writes 16 bits a channel" "$(od -An -tu1 -j24 -N1 deep.png | tr -d ' ')" 16
exits "an ending in capitals" 0 "$penumbra" render scene.json -o A.PNG
exits "an ending in both cases" 0 "$penumbra" render scene.json -o a.Pfm
check "gives the same formats" sh -c "cmp A.PNG a.png && cmp a.Pfm a.pfm"
exits "--format wins over the ending" 0 "$penumbra" render scene.json -o odd.png --format pfm
check "and gives the same bytes" cmp odd.png a.pfm
"$penumbra" render - -o b.png <scene.json
check "a scene from standard input gives the same bytes" cmp a.png b.png
"$penumbra" render scene.json -o - --format png >c.png
exits "standard output for picture and JSON" 2 "$penumbra" render scene.json -o - --format png --json
check "a picture on standard output has the same bytes" cmp a.png c.png
exits "render a built-in scene" 0 "$penumbra" render builtin:spheres -o s.png --set width=40 --set height=30
check "it equals the scene's file" sh -c "'$penumbra' render '$root/scenes/spheres.json' -o t.png --set width=40 \
    --set height=30 && cmp s.png t.png"

# The same bytes with any number of threads, tile size and accelerator
for threads in 1 2 3 8; do
    "$penumbra" render scene.json -o t.pfm --threads $threads
    check "$threads threads give the same bytes" cmp t.pfm a.pfm
    "$penumbra" render scene.json -o t.png --threads $threads --set tile=$((3 * threads))
    check "$threads threads and other tiles give the same PNG" cmp t.png a.png
    "$penumbra" render scene.json -o t.png --threads $threads --format png16 --set tile=$((5 * threads))
    check "$threads threads and other tiles give the same PNG of 16 bits" cmp t.png deep.png
done
"$penumbra" render scene.json -o t.pfm --set tile=7 --set accelerator=none
check "other tiles and no accelerator give the same bytes" cmp t.pfm a.pfm

# Rows are encoded while others are rendered, but a file is written only when all are. One thread would take
# minutes for these.
timeout 0.5 "$penumbra" render scene.json -o stopped.png --threads 1 --set samples_per_pixel=100000 --set tile=1 >output 2>&1
expect "a render that is stopped" $? 124
expect "leaves no file" "$(echo stopped.png*)" "stopped.png*"

# Settings, views, statistics
exits "--set" 0 "$penumbra" render scene.json -o small.pfm --set width=20 --set height=8e0
expect "--set changes the picture's size" "$(sed -n 2p small.pfm)" "20 8"
mkdir folder.png
for out in folder.png none/x.png; do # these renders would take hours
    exits "a picture that cannot be written is refused before rendering: $out" 8 timeout 60 "$penumbra" render scene.json \
        -o "$out" --set width=6000 --set height=4300 --set samples_per_pixel=100000
    prints "the error names the file" stderr "cannot write $out"
    exits "statistics that cannot be written are refused before rendering: $out" 8 timeout 60 "$penumbra" render scene.json \
        --stats "$out" --set width=6000 --set height=4300 --set samples_per_pixel=100000
done
exits "picture and statistics in one file" 2 "$penumbra" render scene.json -o x.png --stats x.png
expect "no file is left behind" "$(echo x.png* folder.png*)" "x.png* folder.png"
exits "a misspelt setting" 2 "$penumbra" render scene.json -o x.png --set widht=20
prints "the error names the nearest setting" stderr '"width"'
exits "a setting out of range" 2 "$penumbra" render scene.json -o x.png --set width=0
exits "--view" 0 "$penumbra" render scene.json -o side.png --view side
if cmp -s side.png a.png; then
    not_ok "another view is another picture" "same bytes"
else
    ok "another view is another picture"
fi
"$penumbra" render scene.json -o front.png --view front
check "the first view is the default" cmp front.png a.png
exits "an unknown view" 4 "$penumbra" render scene.json -o x.png --view sidd
prints "the error names the nearest view" stderr 'nearest is "side"'
exits "--stats" 0 "$penumbra" render scene.json --stats stats.json --threads 2
expect "--stats counts primary rays" "$(jq .rays.primary stats.json)" $((61 * 43))
expect "--stats counts threads" "$(jq .threads stats.json)" 2
exits "--json" 0 "$penumbra" render scene.json -o a.png --json
expect "--json prints one line" "$(wc -l <stdout | tr -d ' ')" 1
expect "--json describes the picture" "$(jq -c '[.output, .format, .view, .width, .height]' stdout)" \
    '["a.png","png","front",61,43]'
expect "--json has the statistics" "$(jq .stats.rays.primary stdout)" $((61 * 43))

# One pixel: exactly the values of the film, whose first row is the bottom one
cat >film_pixel.py <<'PYTHON'
import json, struct, sys
film, x, y = open(sys.argv[1], "rb").read(), int(sys.argv[2]), int(sys.argv[3])
at = len(film) - 61 * 43 * 12 + ((42 - y) * 61 + x) * 12
pixel = json.load(sys.stdin)
sys.exit([float.fromhex(v) for v in pixel["film_hex"]] != list(struct.unpack_from("<3f", film, at)))
PYTHON
for at in 30,20 0,0 60,42 12,33; do
    "$penumbra" render scene.json --pixel $at --json >pixel.json
    check "--pixel $at prints the film's values" python3 film_pixel.py a.pfm ${at%,*} ${at#*,} <pixel.json
done
exits "--pixel as text" 0 "$penumbra" render scene.json --pixel 30,20
prints "--pixel prints ray counts" stdout "rays    primary 1, shadow"
prints "--pixel prints hexadecimal floats" stdout "0x1."

# Outputs are replaced as a whole or not at all
echo precious >keep.png
chmod 640 keep.png
exits "render a scene with errors" 3 "$penumbra" render bad.json -o keep.png
expect "the old output stays" "$(cat keep.png)" precious
prints "errors name the file" stderr "bad.json: "
prints "errors have a JSON Pointer" stderr "/objects/0/radius"
prints "further errors are reported, too" stderr "/objects/1/material/kd"
prints "an unknown key's error names the nearest key" stderr '"ambient"'
expect "each error is one line" "$(grep -c '^penumbra: bad.json' stderr)" 3
exits "render a scene with errors and --json" 3 "$penumbra" render bad.json -o keep.png --json
expect "--json prints a problem document, too" "$(jq .status stdout)" 422
echo '{"scene": "builtin:room", "render": {"width": 8}}' >job.json
exits "render a job" 3 "$penumbra" render job.json -o keep.png
expect "its only error tells which command takes jobs" "$(cat stderr)" \
    'penumbra: job.json: at /scene: must be a scene, found a job, which has one; `penumbra submit` takes jobs'
check "a picture replaces the old one" "$penumbra" render scene.json -o keep.png
check "the new picture is complete" cmp keep.png a.png
expect "the file keeps its mode" "$(stat -c %a keep.png)" 640
ln -s keep.png link.png
check "a picture replaces the target of a link" "$penumbra" render scene.json -o link.png --view side
check "the link stays" sh -c "test -L link.png && cmp keep.png side.png"
expect "no temporary file stays" "$(ls | grep -c '.png.')" 0
exits "an output in a missing folder" 8 "$penumbra" render scene.json -o /nonexistent/a.png
exits "a full disk" 8 "$penumbra" render scene.json -o /dev/full --format png
exits "a missing input" 4 "$penumbra" render nothing.json -o x.png
exits "an input that is a folder" 8 "$penumbra" render . -o x.png
exits "an unknown built-in scene" 4 "$penumbra" render builtin:sheres -o x.png
prints "the error names the nearest scene" stderr 'nearest is "spheres"'
printf '{"format": "penumbra-scene/1",\n "camera": }' >broken.json
exits "malformed JSON" 3 "$penumbra" render broken.json -o x.png
prints "the error has line and column" stderr "broken.json:2:"
exits "an empty input" 3 "$penumbra" render /dev/null -o x.png

# validate and scenes
exits "validate valid scenes" 0 "$penumbra" validate scene.json builtin:room
prints "validate prints that they are valid" stdout "scene.json: valid"
exits "validate an invalid and a valid scene" 3 "$penumbra" validate scene.json bad.json
prints "the error names the invalid one" stderr "penumbra: bad.json: "
prints "the other one is reported as valid" stdout "scene.json: valid"
exits "validate --json" 0 "$penumbra" validate scene.json --json
expect "validate --json prints the API's answer" "$(jq .valid stdout)" true
exits "scenes" 0 "$penumbra" scenes
expect "scenes lists each scene with a line that says more than its name" \
    "$(awk '{ name = $1; sub(/^[^ ]* +/, "") } $0 != name && NF > 3 && length(name $0) < 78' stdout | wc -l)" \
    "$(ls "$root"/scenes/*.json | wc -l)"
exits "scenes NAME" 0 "$penumbra" scenes room
check "scenes NAME prints the scene" cmp stdout "$root/scenes/room.json"
exits "scenes --json" 0 "$penumbra" scenes --json
expect "scenes --json prints a list" "$(jq -r '.scenes | map(.name) | index("spheres") != null' stdout)" true
exits "scenes with an unknown name" 4 "$penumbra" scenes rom

# The classroom's colours are a screen's: the numbers stay, and the file says sRGB.
cat >screen.xml <<'END'
<scene background-color="40 90 160">
    <ambient-light color="220 150 90"/>
    <geometries><sphere center="0 0 -90" radius="40"/></geometries>
    <render width="30" height="30"/>
</scene>
END
exits "XML's picture" 0 "$penumbra" render screen.xml -o screen.png
expect "is sRGB to others, and says more to compare" "$(grep -aoE 'sRGB|transfer.display' screen.png | tr '\0\n' ' ,')" "sRGB,transfer display,"
exits "XML's pixels" 0 "$penumbra" render screen.xml -o screen.pfm
exits "both are the same" 0 "$penumbra" compare screen.png screen.pfm --max-error 1e-6
exits "the same numbers with another tag" 0 "$penumbra" render screen.xml --set transfer=linear -o tag.png
exits "are the same picture" 0 "$penumbra" compare screen.png tag.png --max-error 0
prints "and compare tells of the tags" stdout "tags          differ, and the values are equal"
exits "audit reads the numbers" 0 "$penumbra" audit screen.xml screen.png --max-wrong 0.05

# compare
exits "compare equal pictures" 0 "$penumbra" compare a.png front.png --max-error 0
prints "their error is 0" stdout "rmse          0"
exits "compare different pictures without a bound" 0 "$penumbra" compare a.png side.png
exits "compare different pictures with --max-rmse" 7 "$penumbra" compare a.png side.png --max-rmse 0.001
prints "the error has the RMSE" stderr "the pictures differ: rmse"
exits "compare different pictures with --max-error" 7 "$penumbra" compare a.png side.png --max-error 0.001 -q
expect "-q prints nothing" "$(cat stdout stderr)" ""
exits "compare different pictures with --max-flip" 7 "$penumbra" compare a.png side.png --max-flip 0.001
prints "the error has FLIP" stderr "the pictures differ: flip 0."
exits "compare different pictures with --min-ssim" 7 "$penumbra" compare a.png side.png --min-ssim 0.999
prints "the error has SSIM" stderr "the pictures differ: ssim 0."
for bound in "--max-rmse 0" "--max-flip 0" "--min-ssim 1" "--max-error 0"; do
    exits "equal pictures satisfy $bound" 0 "$penumbra" compare a.png front.png $bound -q
    exits "different ones do not" 7 "$penumbra" compare a.png side.png $bound -q
done
exits "compare and draw the errors" 0 "$penumbra" compare a.png side.png -o map.png
prints "the figures are printed, too" stdout "flip          0."
expect "the map says what it shows" "$(grep -a -c 'FLIP: black is 0, pale yellow is 1' map.png)" 1
exits "the map has the size of the pictures" 0 "$penumbra" compare map.png a.png -q
exits "draw that there are no errors" 0 "$penumbra" compare a.png front.png -q -o black.png
exits "compare both maps" 7 "$penumbra" compare map.png black.png --max-error 0.5 -q
exits "errors as numbers" 0 "$penumbra" compare a.png side.png -q -o map.pfm
exits "the picture is not those numbers, but colours" 7 "$penumbra" compare map.png map.pfm --max-error 0.1 -q
expect "they are a PFM file of that size" "$(head -c 9 map.pfm | tr '\n' ' ')" "PF 61 43 "
"$penumbra" compare a.png side.png --json >figures.json
tail -c $((61 * 43 * 12)) map.pfm | od -An -v -w12 -t f4 | awk '{ if ($1 > most) most = $1; sum += $1 }
    END { print most, sum / NR }' >pooled
expect "the largest and the mean are those of the figures" "$(jq --argjson pooled "[$(tr ' ' , <pooled)]" \
    '[.flip_max, .flip] | [., $pooled] | transpose | map((.[0] - .[1] | fabs) < 1e-5) | all' figures.json)" true
exits "errors to standard output" 0 "$penumbra" compare a.png side.png -q -o - --format pfm
check "they are the same" cmp stdout map.pfm
exits "errors and figures to standard output" 2 "$penumbra" compare a.png side.png -o - --format pfm
exits "errors and JSON to standard output" 2 "$penumbra" compare a.png side.png -o - --format pfm -q --json
exits "errors in an unknown format" 2 "$penumbra" compare a.png side.png -o map.gif
exits "--format without -o" 2 "$penumbra" compare a.png side.png --format png
exits "errors to a folder that is not there" 8 "$penumbra" compare a.png side.png -o nowhere/map.png
exits "compare 8 bits with the film" 0 "$penumbra" compare a.png a.pfm --json
expect "they differ only by rounding" "$(jq '.max_error < 0.00197 and .max_error > 0' stdout)" true
expect "--json names the figures" "$(jq -c '[has("rmse", "relative_mse", "psnr", "ssim", "flip", "differing")] | all' stdout)" true
expect "they look the same" "$(jq '.ssim > 0.99 and .flip < 0.03 and .flip > 0' stdout)" true
expect "FLIP's figures are ordered" "$(jq '[.flip_min, .flip_first_quartile, .flip_weighted_median,
    .flip_third_quartile, .flip_max] | . == sort and .[4] <= 1' stdout)" true
bright() { printf 'PF\n4 4\n-1.0\n' && for _ in $(seq 48); do printf "\\0\\0\\$1\\100"; done; }
bright 0 >two.pfm # binary32, little-endian
bright 100 >three.pfm
exits "2 is not 3" 7 "$penumbra" compare two.pfm three.pfm --max-error 0
prints "in any pixel" stdout "differing     16 of 16 pixels"
exits "and not by less than it is" 7 "$penumbra" compare two.pfm three.pfm --max-error 0.25 -q
exits "2 is 2" 0 "$penumbra" compare two.pfm two.pfm --max-error 0
# One pixel, opaque and half transparent.
echo iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGPg5OT8DwABVQEbRny5UQAAAABJRU5ErkJggg== | base64 -d >opaque.png
echo iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGPg5ORsAAAA1gCcaeqYxgAAAABJRU5ErkJggg== | base64 -d >half.png
exits "other alpha is another picture" 7 "$penumbra" compare opaque.png half.png
prints "which is counted" stdout "alpha         differs in 1 pixel"
prints "and said" stderr "in the alpha of 1 pixel"
exits "in JSON, too" 7 "$penumbra" compare half.png opaque.png --json
expect "as a number" "$(jq .alpha_differing stdout)" 1
exits "the same alpha" 0 "$penumbra" compare half.png half.png --max-error 0
exits "compare pictures of different sizes" 3 "$penumbra" compare a.png small.pfm
exits "compare a file that is no picture" 3 "$penumbra" compare a.png scene.json
prints "the error names the file" stderr "scene.json"

finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbra bench`: no daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

small="--set width=40 --set height=30 --repeats 2 --warmup 0"

ends "a matrix" 0 "$penumbra" bench builtin:spheres $small -m accelerator=none,auto --matrix threads=1,0
expect "prints a row for every combination" "$(grep -c '×' stdout)" 4
says "compares the pictures" stdout "identical to row 0"
says "describes the machine" stdout "threads in the pool, Penumbra"
expect "no bar where there is no terminal" "$(cat stderr)" ""

for form in json csv md html; do
    ends "a report as $form" 0 "$penumbra" bench builtin:spheres $small -q -m tile=8,16 -o "r.$form" --csv side.csv
    expect "and quietly" "$(cat stdout stderr)" ""
    expect "the rows beside it too" "$(wc -l <side.csv)" 3
done
expect "JSON has the rows" "$(jq -c '[.rows[].settings]' r.json)" '[{"tile":8},{"tile":16}]'
expect "JSON has medians, speed-ups, rays and tests" "$(jq -c '[.rows[] | (.min_ms <= .median_ms
    and .median_ms <= .max_ms and .speedup > 0 and .rays.primary == 1200 and (.runs_ms | length) == 2
    and .accelerator.box_tests_per_ray > 0)] | all' r.json)" true
expect "JSON names the scene, and the settings of all rows" "$(jq -r '.scene + " " + (.render.width | tostring) + " " + (.render.tile | tostring)' r.json)" "spheres 40 null"
expect "CSV has columns" "$(head -n 1 r.csv | cut -d, -f 1-4)" "row,tile,threads_worked,median_ms"
expect "Markdown has a table" "$(grep -c '^| [01] |' r.md)" 4
expect "HTML has a chart" "$(grep -c '<svg ' r.html)" 1
ends "several forms at once" 0 "$penumbra" bench builtin:spheres $small -q -o two.md -o two.html
expect "are written both" "$(head -c 11 two.md) $(head -c 9 two.html)" "# Benchmark <!doctype"
ends "--format for several" 2 "$penumbra" bench builtin:spheres $small -q -o two.md -o two.html --format md
ends "--format wins over the ending" 0 "$penumbra" bench builtin:spheres $small -q -o odd.txt --format csv
expect "and there is a row without a matrix" "$(wc -l <odd.txt)" 2
ends "JSON to standard output" 0 "$penumbra" bench builtin:spheres $small --json -m threads=1,2 --baseline threads=2
expect "with the baseline asked for" "$(jq '.baseline, .rows[1].speedup' stdout | tr '\n' ' ')" "1 1 "
ends "a report to standard output" 0 "$penumbra" bench builtin:spheres $small -o - --format csv
expect "and nothing else there" "$(wc -l <stdout)" 2

cat >two.json <<'SCENE'
{"format": "penumbra-scene/1", "name": "<i>two</i>", "camera": {"position": [0, 0, 9], "look_at": [0, 0, 0]},
 "views": [{"name": "front", "camera": {}}, {"name": "side", "camera": {"position": [9, 1, 0]}}],
 "ambient": [1, 1, 1], "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 2}]}
SCENE
ends "several views" 0 "$penumbra" bench two.json $small -o two.html --csv two.csv
expect "are rendered all" "$(cut -d, -f 10 two.csv | tail -n 1)" 2400
expect "names are no markup" "$(grep -c '<i>' two.html)" 0
ends "--view" 0 "$penumbra" bench two.json $small --view side --csv two.csv
expect "chooses one" "$(cut -d, -f 10 two.csv | tail -n 1)" 1200

# Mistakes
ends "an unknown setting" 2 "$penumbra" bench builtin:spheres -m thread=1
says "is named" stderr '--matrix thread: unknown key "thread"; did you mean "threads"?'
ends "an unknown value" 2 "$penumbra" bench builtin:spheres -m accelerator=none,automatic
says "is named" stderr '--matrix accelerator: must be one of'
ends "a list without values" 2 "$penumbra" bench builtin:spheres -m accelerator
says "is explained" stderr 'allowed is KEY=VALUE,…'
ends "an empty value" 2 "$penumbra" bench builtin:spheres -m threads=1,,2
ends "a setting given twice" 2 "$penumbra" bench builtin:spheres -m threads=1 -m threads=2
says "is named" stderr 'threads is given twice'
ends "a baseline that is no row" 2 "$penumbra" bench builtin:spheres -m threads=1,2 --baseline threads=3
says "is named" stderr "--baseline threads: must be one of the matrix's values, found 3"
ends "too much work" 3 "$penumbra" bench builtin:spheres -m samples_per_pixel=1000000000
says "is refused before it begins" stderr '--matrix: '
ends "a view that is not there" 4 "$penumbra" bench two.json --view top
ends "an unknown form" 2 "$penumbra" bench builtin:spheres -o report.pdf
says "is explained" stderr '.json, .csv, .md or .html'
ends "a place that cannot be written" 8 timeout 20 "$penumbra" bench builtin:room -o none/r.json
ends "a wrong scene" 3 "$penumbra" bench /dev/null

finish

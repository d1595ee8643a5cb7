#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbra bench`, without a daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

small="--set width=40 --set height=30 --repeats 2 --warmup 0"

exits "bench with a matrix" 0 "$penumbra" bench builtin:spheres $small -m accelerator=none,auto --matrix threads=1,0
expect "bench prints a row for every combination" "$(grep -c '×' stdout)" 4
prints "bench compares the pictures" stdout "identical to row 0"
prints "bench describes the machine" stdout "threads in the pool, Penumbra"
expect "bench draws no progress bar without a terminal" "$(cat stderr)" ""

for form in json csv md html; do
    exits "a report as $form" 0 "$penumbra" bench builtin:spheres $small -q -m tile=8,16 -o "r.$form" --csv side.csv
    expect "bench -q prints nothing" "$(cat stdout stderr)" ""
    expect "--csv writes the rows, too" "$(wc -l <side.csv)" 3
done
expect "JSON has the rows" "$(jq -c '[.rows[].settings]' r.json)" '[{"tile":8},{"tile":16}]'
expect "JSON has medians, speed-ups, rays and tests" "$(jq -c '[.rows[] | (.min_ms <= .median_ms
    and .median_ms <= .max_ms and .speedup > 0 and .rays.primary == 1200 and (.runs_ms | length) == 2
    and .accelerator.box_tests_per_ray > 0)] | all' r.json)" true
expect "JSON names the scene, and the settings of all rows" "$(jq -r '.scene + " " + (.render.width | tostring) + " " + (.render.tile | tostring)' r.json)" "spheres 40 null"
expect "CSV has columns" "$(head -n 1 r.csv | cut -d, -f 1-4)" "row,tile,threads_worked,median_ms"
expect "Markdown has a table" "$(grep -c '^| [01] |' r.md)" 4
expect "HTML has a chart" "$(grep -c '<svg ' r.html)" 1
exits "two reports at once" 0 "$penumbra" bench builtin:spheres $small -q -o two.md -o two.html
expect "both reports are written" "$(head -c 11 two.md) $(head -c 9 two.html)" "# Benchmark <!doctype"
exits "--format with several outputs" 2 "$penumbra" bench builtin:spheres $small -q -o two.md -o two.html --format md
exits "--format wins over the ending" 0 "$penumbra" bench builtin:spheres $small -q -o odd.txt --format csv
expect "without a matrix there is one row" "$(wc -l <odd.txt)" 2
exits "JSON to standard output" 0 "$penumbra" bench builtin:spheres $small --json -m threads=1,2 --baseline threads=2
expect "--baseline chooses the baseline" "$(jq '.baseline, .rows[1].speedup' stdout | tr '\n' ' ')" "1 1 "
exits "a report to standard output" 0 "$penumbra" bench builtin:spheres $small -o - --format csv
expect "standard output has only the report" "$(wc -l <stdout)" 2

cat >two.json <<'SCENE'
{"format": "penumbra-scene/1", "name": "<i>two</i>", "camera": {"position": [0, 0, 9], "look_at": [0, 0, 0]},
 "views": [{"name": "front", "camera": {}}, {"name": "side", "camera": {"position": [9, 1, 0]}}],
 "ambient": [1, 1, 1], "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 2}]}
SCENE
exits "bench of several views" 0 "$penumbra" bench two.json $small -o two.html --csv two.csv
expect "all views are rendered" "$(cut -d, -f 10 two.csv | tail -n 1)" 2400
expect "a scene's name is escaped in HTML" "$(grep -c '<i>' two.html)" 0
exits "bench --view" 0 "$penumbra" bench two.json $small --view side --csv two.csv
expect "--view chooses one view" "$(cut -d, -f 10 two.csv | tail -n 1)" 1200

# Wrong command lines
exits "a matrix of an unknown setting" 2 "$penumbra" bench builtin:spheres -m thread=1
prints "the error names the unknown setting" stderr '--matrix thread: unknown key "thread"; did you mean "threads"?'
exits "a matrix with an unknown value" 2 "$penumbra" bench builtin:spheres -m accelerator=none,automatic
prints "the error names the unknown value" stderr '--matrix accelerator: must be one of'
exits "a matrix without values" 2 "$penumbra" bench builtin:spheres -m accelerator
prints "the error shows the form KEY=VALUE" stderr 'allowed is KEY=VALUE,…'
exits "a matrix with an empty value" 2 "$penumbra" bench builtin:spheres -m threads=1,,2
exits "a matrix with a setting twice" 2 "$penumbra" bench builtin:spheres -m threads=1 -m threads=2
prints "the error names the repeated setting" stderr 'threads is given twice'
exits "a baseline that is no row" 2 "$penumbra" bench builtin:spheres -m threads=1,2 --baseline threads=3
prints "the error names the value that is no row" stderr "--baseline threads: must be one of the matrix's values, found 3"
exits "a matrix of too much work" 3 "$penumbra" bench builtin:spheres -m samples_per_pixel=1000000000
prints "is refused because of --matrix" stderr '--matrix: '
exits "bench of an unknown view" 4 "$penumbra" bench two.json --view top
exits "a report with an unknown ending" 2 "$penumbra" bench builtin:spheres -o report.pdf
prints "the error lists the endings" stderr '.json, .csv, .md or .html'
exits "a report in a missing folder is refused before the runs" 8 timeout 20 "$penumbra" bench builtin:room -o none/r.json
exits "bench of an empty scene file" 3 "$penumbra" bench /dev/null

finish

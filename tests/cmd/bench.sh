#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbra bench`, without a daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

tiny="--set width=16 --set height=12"
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
expect "JSON has a hash beside every time" "$(jq -c '[.rows[].picture_hash] | unique | map(test("^[0-9a-f]{16}$"))' r.json)" '[true]'
expect "JSON has the build id of the program" "$(jq -r .host.build r.json)" \
    "$(readelf -n "$penumbra" | sed -n 's/.*Build ID: //p')"
expect "three repeats decide nothing" "$(jq -c '[.rows[].verdict], .noise, .ended_by' r.json | tr '\n' ' ')" \
    '["baseline","undecided"] null "repeats" '
if [ -n "${PEN_TIMED:-}" ]; then # on a busy machine no interval may become narrow
    exits "bench until the intervals are narrow" 0 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 --interval 1 --budget 3600 -o i.json
    # On a machine that takes the processors away from most runs, there is no interval after 640 repeats.
    expect "it ends at a doubling of 10, and has a twin" "$(jq -c '[.repeats % 10, .noise.pairs - .repeats,
        if .rows[1].ratio.low != null then .ended_by == "interval"
        else .ended_by == "repeats" and .repeats == 640 and .rows[1].ratio.spoiled >= 160 end]' i.json)" '[0,0,true]'
    prints "the noise floor is printed" stdout "Noise floor: the baseline against itself "
fi
exits "bench until the budget ends" 0 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 --interval 0.000001 --budget 0.3 -o i.json
expect "the budget ends it" "$(jq -r .ended_by i.json)" budget
exits "the order of runs is repeated by its seed" 0 "$penumbra" bench builtin:spheres $tiny --order-seed 77 -o i.json
expect "the seed is in the report" "$(jq .order_seed i.json)" 77
expect "JSON names the scene, and the settings of all rows" "$(jq -r '.scene + " " + (.render.width | tostring) + " " + (.render.tile | tostring)' r.json)" "spheres 40 null"
expect "CSV has columns" "$(head -n 1 r.csv | cut -d, -f 1-4)" "row,tile,threads_worked,median_ms"
expect "Markdown has a table" "$(grep -c '^| [01] |' r.md)" 4
expect "HTML has the report as data, and tables" "$(sed -n 's|^<script type="application/json" id="data">\(.*\)</script>$|\1|p' r.html |
    jq '.rows | length') $(grep -c '<table>' r.html)" "2 2"
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
expect "all views are rendered" "$(csv two.csv rays_primary)" 2400
expect "a scene's name is escaped in HTML" "$(grep -c '<i>' two.html)" 0
exits "bench --view" 0 "$penumbra" bench two.json $small --view side --csv two.csv
expect "--view chooses one view" "$(csv two.csv rays_primary)" 1200

# Against reports made earlier
exits "bench for later" 0 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 --repeats 10 -q -o a.json
exits "bench against a report" 0 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 --repeats 10 --baseline a.json --baseline tile=16
prints "the comparison has both builds" stdout "after: "
exits "bench against a report, as JSON" 0 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 --repeats 10 --baseline a.json --json
expect "the report has the comparison" "$(jq -c '.comparison | [.counters, .pictures, .host_differences, (.rows | length)]' stdout)" '["same","same",[],2]'
exits "compare two reports" 0 "$penumbra" compare a.json a.json
prints "compares counters, pictures and times" stdout "calibrated  counters"
jq '.rows[1].rays.shadow += 1' a.json >b.json
exits "a counter that differs" 7 "$penumbra" compare a.json b.json
prints "the counter is named" stdout "row 1: rays.shadow "
exits "bench against a report of other counts" 7 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 -q --baseline b.json
exits "bench --compare nothing" 0 "$penumbra" bench builtin:spheres $tiny -m tile=8,16 -q --baseline b.json --compare nothing
jq '.rows[].spoiled_runs = [] | .rows[].runs_ms |= map(10) | .noise = null' a.json >slow.json
jq '.rows[].runs_ms |= map(5)' slow.json >fast.json
exits "a slower report advises" 0 "$penumbra" compare fast.json slow.json
exits "a slower report fails with --time" 7 "$penumbra" compare fast.json slow.json --time
prints "it says so" stderr "2 rows are slower"
exits "compare --json" 0 "$penumbra" compare fast.json slow.json --json
expect "has the verdicts" "$(jq -c '[.rows[].verdict]' stdout)" '["slower","slower"]'
printf '{"kind": "effects"}' >bill.json
exits "compare a report of another kind" 3 "$penumbra" compare a.json bill.json
prints "the error names the file, the place and what is allowed" stderr 'bill.json: at /kind: must be "benchmark"'
exits "bench against a missing report" 4 "$penumbra" bench builtin:spheres --baseline none.json
exits "bench against two reports" 2 "$penumbra" bench builtin:spheres --baseline a.json --baseline b.json
exits "bench against what is no job" 2 "$penumbra" bench builtin:spheres --baseline http://127.0.0.1:1/jobs
prints "the error shows what a job's URL is" stderr "allowed is http://HOST/v1/jobs/ID"
exits "bench with two rows as baseline" 2 "$penumbra" bench builtin:spheres -m tile=8,16 --baseline tile=8 --baseline tile=16
exits "bench --compare without a report" 2 "$penumbra" bench builtin:spheres --compare time
exits "submit with a report as baseline" 2 "$penumbra" submit builtin:spheres --kind benchmark --baseline a.json

# The history of reports
mkdir history
for i in 1 2 3 4 5 6 7 8 9; do
    jq --arg i "$i" '.began_at = "2026-01-0" + $i + "T00:00:00.000Z" | .rows[].spoiled_runs = []
        | .rows[0].runs_ms |= map(if ($i | tonumber) > 4 then 12 else 10 end)' a.json >"history/$((10 - i)).json"
done
exits "a history" 0 "$penumbra" bench --history history -o h.html -o h.json
prints "has the change" stdout "change at 2026-01-05 build"
expect "as JSON" "$(jq -c '.kind, (.reports | length), .rows[0].changes[0].point' h.json | tr '\n' ' ')" '"history" 9 4 '
expect "as a page with a line for each point" "$(grep -c '<th scope="row">' h.html)" 18
jq '.scene = "other"' a.json >history/other.json
printf '[' >history/broken.json
exits "a history of two scenes" 3 "$penumbra" bench --history history
prints "the error names both" stderr 'such as "spheres" and "other": name one'
exits "a history of the scene that is named" 0 "$penumbra" bench --history history spheres --json
expect "has its reports" "$(jq '.reports | length' stdout)" 9
prints "a file that is no report is named" stderr "left out: history/broken.json:1:"
exits "a history of a folder without reports" 4 "$penumbra" bench --history .. nonesuch
exits "a history of no folder" 4 "$penumbra" bench --history nowhere
exits "a history as CSV" 0 "$penumbra" bench --history history spheres -q -o h.csv
expect "has a line for each point" "$(csv h.csv median_ms | grep -c .)" 18
exits "bench without a scene" 2 "$penumbra" bench

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
exits "repeats beside an interval" 2 "$penumbra" bench builtin:spheres --interval 0.1 --repeats 3
prints "the error names both" stderr "--repeats: must not be there beside interval"
exits "an interval of nothing" 2 "$penumbra" bench builtin:spheres --interval 0
prints "the error says what is allowed" stderr "--interval: must be a number above 0 and at most 1, found 0"
exits "a report with an unknown ending" 2 "$penumbra" bench builtin:spheres -o report.pdf
prints "the error lists the endings" stderr '.json, .csv, .md or .html'
exits "a report in a missing folder is refused before the runs" 8 timeout 20 "$penumbra" bench builtin:room -o none/r.json
exits "bench of an empty scene file" 3 "$penumbra" bench /dev/null

finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# Benchmarks through a daemon: by the command line, over HTTP, and when workers are killed, jobs are
# cancelled and the daemon is stopped.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
threads=2
daemon_start
PENUMBRA_URL=$url
export PENUMBRA_URL

small="--kind benchmark --set width=40 --set height=30 --repeats 2 -m accelerator=none,auto -m threads=1,0"
# Runs of a fraction of a second on any machine and build; many of them, or few.
run="--set width=200 --set height=150"
run="--kind benchmark $run --set tile=8 --set samples_per_pixel=$(samples_lasting 70 builtin:spheres $run)"
lengthy="$run --repeats 100"
idle() {
    [ "$(curl -s "$url/v1/workers" | jq '[.workers[].batches[]] | length')" = 0 ]
}

# From submit to report
for form in html json csv md; do
    exits "submit and fetch as $form" 0 "$penumbra" submit builtin:spheres $small -q -o "r.$form"
done
expect "JSON has the rows" "$(jq -c '[.rows[] | [.settings.accelerator, .threads, .row]]' r.json)" \
    '[["none",1,0],["none",2,1],["auto",1,2],["auto",2,3]]'
expect "all pictures of the report are the same" "$(jq '[.rows[] | .identical and .same_as == 0] | all' r.json)" true
expect "the HTML report is a page" "$(head -n 1 r.html)" "<!doctype html>"
expect "the CSV report has a line for each row" "$(wc -l <r.csv)" 5
exits "the same benchmark without a daemon" 0 "$penumbra" bench builtin:spheres --set width=40 --set height=30 \
    --repeats 2 -m accelerator=none,auto -m threads=1,0 -q --threads 2 -o local.json
facts='del(.began_at, .ended_at, .load_average, .notes, .order_seed, .calibration, .host.build) | .rows |= map(del(.median_ms,
    .min_ms, .max_ms, .runs_ms, .speedup, .ratio, .spoiled_runs, .cpu_share, .steal_ms, .build_ms, .render_ms, .cpu_ms,
    .mrays_per_second, .accelerator.build_ms))'
expect "gives the same report except times" "$(jq -cS "$facts" local.json)" "$(jq -cS "$facts" r.json)"
# bench on the daemon
jobs() { "$penumbra" list --limit 1000 --json | jq '.jobs | length'; }
before=$(jobs)
set -- builtin:spheres --set width=40 --set height=30 --repeats 2 -m accelerator=none,auto -m threads=1,0
exits "PENUMBRA_URL alone" 0 "$penumbra" bench "$@" --threads 2 --csv local.csv
cp stdout local.txt
expect "sends nothing" "$(jobs)" "$before"
exits "bench --server" 0 "$penumbra" bench "$@" --server "$url" -o remote.json -o remote.html --csv remote.csv
cp stdout remote.txt
expect "sends a job" "$(jobs)" $((before + 1))
expect_match "and prints its id on standard error" "$(cat stderr)" "penumbra: job ????????-????-7???-????-????????????"
expect "gives the same report except times" "$(jq -cS "$facts" remote.json)" "$(jq -cS "$facts" local.json)"
expect "has the name of the host, its processor and load" \
    "$(jq -c '[.host.name, (.host.cpu | length > 0), (.load_average.before | type)]' remote.json)" "[\"$(uname -n)\",true,\"number\"]"
table() { # FILE: its lines and columns
    grep -c -e '×' "$1"
    grep '^row ' "$1" | tr -s ' ' '\n' | sort -u
}
expect "prints the same table" "$(table remote.txt)" "$(table local.txt)"
prints "below which is the host" stdout "$(uname -n): "
expect "has the same rows and columns as CSV" "$(head -n 1 remote.csv; csv remote.csv rays_shadow; csv remote.csv threads_worked)" \
    "$(head -n 1 local.csv; csv local.csv rays_shadow; csv local.csv threads_worked)"
expect "has a page" "$(head -n 1 remote.html)" "<!doctype html>"
exits "bench --server --json" 0 "$penumbra" bench "$@" --server "$url" -q --json
expect "prints the report as a line" "$(wc -l <stdout) $(jq '.rows | length' stdout) $(wc -c <stderr)" "1 4 0"
id=$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')
exits "bench --server against a job" 0 "$penumbra" bench "$@" --server "$url" --baseline "$id"
prints "prints the comparison" stdout "after: "
jq '.rows[1].rays.shadow += 1' remote.json >other.json
exits "bench --server against other counts" 7 "$penumbra" bench "$@" --server "$url" -q --baseline other.json
jq '. + {views: [{name: "front"}, {name: "side", camera: {position: [5, 2, 9]}}]}' "$root/scenes/spheres.json" >views.json
exits "bench --server of a view" 0 "$penumbra" bench views.json --set width=8 --set height=6 --view side --server "$url" -o view.json
expect "has that view" "$(jq -c .views view.json)" '["side"]'
echo '<scene><camera position="0 0 9" look-at="0 0 0" image="8 6"/><geometries><sphere center="0 0 0" radius="1"/>
    </geometries></scene>' >scene.xml
exits "bench --server of a scene in XML" 0 "$penumbra" bench scene.xml --server "$url" --csv xml.csv
expect "has its pixels" "$(csv xml.csv rays_primary)" 48
exits "bench --server of a wrong matrix" 2 "$penumbra" bench builtin:spheres -m thread=1 --server "$url"
prints "has the error of a local run" stderr '--matrix thread: unknown key "thread"; did you mean "threads"?'
exits "bench --server --threads" 2 "$penumbra" bench builtin:spheres --threads 2 --server "$url"
prints "the error says what to use" stderr "--set threads=N"
(
    "$penumbra" bench builtin:spheres ${lengthy#--kind benchmark} --server "$url" -q 2>cancelled
    echo $? >code
) &
latest() { "$penumbra" list --limit 1 --json | jq -r '.jobs[0] | select(.state == "running").id'; }
running() { [ -n "$(latest)" ]; }
within running
"$penumbra" cancel "$(latest)" >stdout
wait $!
expect "bench --server of a job that is cancelled" "$(cat code) $(grep -c 'was cancelled' cancelled)" "6 1"
exits "bench --server without a daemon" 5 "$penumbra" bench builtin:spheres --server http://127.0.0.1:9 --retry 0

# Wait and fetch
job=$("$penumbra" submit builtin:spheres $small)
exits "wait for a benchmark" 0 "$penumbra" wait "$job"
expect "its progress counts all runs" "$(curl -s "$url/v1/jobs/$job" | jq -c '.progress | [.done, .total]')" "[14,14]"
exits "fetch --report" 0 "$penumbra" fetch --report "$job" -o f.md
expect "fetches Markdown for .md" "$(head -c 12 f.md)" "# Benchmark:"
exits "fetch --report as a picture" 2 "$penumbra" fetch --report "$job" -o f.png
exits "fetch without --report" 4 "$penumbra" fetch "$job" -o f.png
prints "the error says that the job has a report" stderr "it has a report and no picture"
exits "stats of a benchmark" 0 "$penumbra" stats "$job"
expect "have intersection tests per ray" "$(jq '.accelerator.primitive_tests_per_ray > 0' stdout)" true
printf '{"scene": "builtin:spheres", "kind": "benchmark", "repeats": 1, "render": {"width": 9, "height": 9}}' >job.json
exits "submit a benchmark from a file and fetch its report" 0 "$penumbra" submit job.json -q -o j.csv
exits "submit a benchmark with a picture as output" 2 "$penumbra" submit job.json --kind benchmark -o j.png
exits "submit a wrong matrix" 3 "$penumbra" submit builtin:spheres --kind benchmark -m accelerator=nine
prints "the error has the place of the wrong value" stderr "/matrix/accelerator/0: must be one of"
exits "submit a matrix without --kind benchmark" 3 "$penumbra" submit builtin:spheres -m threads=1,2
prints "the error names the kind that has a matrix" stderr "belongs to jobs of kind"

exits "bench against a job" 0 "$penumbra" bench builtin:spheres --set width=40 --set height=30 --repeats 2 \
    -m accelerator=none,auto -m threads=1,0 --threads 2 --baseline "$job"
prints "has all rows of both" stdout "after: "
exits "bench against a job's URL" 0 "$penumbra" bench builtin:spheres --set width=40 --set height=30 --repeats 2 \
    -m accelerator=none,auto --threads 2 --baseline "$url/v1/jobs/$job" --json
expect "has the rows of both" "$(jq '.comparison.rows | length' stdout)" 2
exits "bench against a job that is not there" 4 "$penumbra" bench builtin:spheres --baseline 01890a5d-ac96-774b-bcce-b302099a8057

# The report over HTTP
call "/v1/jobs/$job/report"
expect "GET report gives a page" "$status $(header content-type)" "200 text/html; charset=utf-8"
expect_match "the page may load nothing, and run its script" "$(header content-security-policy)" \
    "default-src 'none'; script-src 'sha256-*'; style-src 'sha256-*'; img-src data:"
expect "it says so itself" "$(sed -n 's/.*Content-Security-Policy" content="\(.*\)">$/\1/p' "$work/body" | sed "s/&#39;/'/g")" \
    "$(header content-security-policy)"
tag=$(header etag)
call "/v1/jobs/$job/report" -H "If-None-Match: $tag"
expect "GET report with its ETag gives 304" "$status" 304
call "/v1/jobs/$job/report" -H 'Accept: application/json' -H "If-None-Match: $tag"
expect "each media type of a report has its own ETag" "$status $(header content-type) $(header vary)" "200 application/json Accept, Accept-Encoding"
call "/v1/jobs/$job/report" -H 'Accept: image/png'
expect_problem "a media type that reports do not have" 406 '*text/html, application/json, text/csv or text/markdown*image/png*'
call "/v1/jobs/$job/report" -I
expect "HEAD of a report" "$status" 200
call "/v1/jobs/$job/image"
expect_problem "GET image of a benchmark" 404 '*it has a report*'

# Alone in its worker, and cancelled
job=$("$penumbra" submit builtin:spheres $lengthy)
within has_runs "$job" 2 || not_ok "progress counts runs during a benchmark" "$(done_runs "$job")"
render=$("$penumbra" submit builtin:spheres --set width=20 --set height=20)
sleep 0.5
expect "a worker runs nothing beside a benchmark" "$(curl -s "$url/v1/workers" | jq -c '[.workers[].batches[].kind]')" '["benchmark"]'
call "/v1/jobs/$job/report"
expect_problem "GET report of a running benchmark" 409 '*is running*'
expect "has Retry-After" "$(header retry-after)" 1
begun=$(now_ms)
"$penumbra" cancel "$job" >/dev/null
within sh -c "curl -s '$url/v1/jobs/$render' | jq -e '.state == \"succeeded\"'" || not_ok "the next job after a cancelled benchmark" "does not run"
timed "a cancelled benchmark ends within 5 s" $(($(now_ms) - begun)) 5000
call "/v1/jobs/$job/report"
expect_problem "GET report of a cancelled benchmark" 409 '*is cancelled*'

# The worker is killed
# It has kept a state after four runs, and is far from its end.
middle="$run --repeats 20 -m threads=1,2"
job=$("$penumbra" submit builtin:spheres $middle)
within has_runs "$job" 4 || not_ok "the benchmark whose worker is killed" "does not run"
kill -KILL "$(child work)"
killed=$(date -u +%Y-%m-%dT%H:%M:%S.%3NZ) # to the millisecond, as the report has it
exits "the benchmark of a killed worker succeeds" 0 "$penumbra" wait "$job" -q
"$penumbra" fetch --report "$job" -o k.json
began=$(jq -r .began_at k.json)
if [ "$(printf '%s\n%s\n' "$killed" "$began" | sort | head -n 1)" = "$killed" ]; then
    not_ok "the next worker goes on with the benchmark" "it began again at $began, killed at $killed"
else
    ok "the next worker goes on with the benchmark"
fi
expect "its report says that it was interrupted" "$(jq '[.notes[] | select(test("interrupted 1 time"))] | length' k.json)" 1
expect "its report has all runs" "$(jq -c '[.rows[].runs_ms | length]' k.json)" "[20,20]"
expect "a killed worker is not charged to its benchmark" "$(curl -s "$url/v1/jobs/$job" | jq .attempts)" 1

# A job of higher priority comes between two runs, a job of the same priority waits
job=$("$penumbra" submit builtin:spheres $lengthy)
check_gives_way "$job" 3
"$penumbra" cancel "$job" >/dev/null
within idle || not_ok "the worker is idle after a cancel" "$(curl -s "$url/v1/workers")"

# The daemon is stopped during a benchmark
job=$("$penumbra" submit builtin:spheres $lengthy)
within has_runs "$job" 2 || not_ok "the benchmark of a daemon that stops" "does not run"
begun=$(now_ms)
daemon_stop TERM
timed "a stopping daemon does not wait for a benchmark" $(($(now_ms) - begun)) 5000
daemon_start
PENUMBRA_URL=$url
within has_runs "$job" 3 && ok "the next daemon goes on with the benchmark" || not_ok "the next daemon goes on with the benchmark" "$(done_runs "$job")"
expect "the stop is not charged to the benchmark" "$(curl -s "$url/v1/jobs/$job" | jq .attempts)" 1
"$penumbra" cancel "$job" >/dev/null
within idle && ok "the worker is idle after a cancel" || not_ok "the worker is idle after a cancel" "$(curl -s "$url/v1/workers")"

# A benchmark that crashes its worker or runs out of memory
sanitized=
case $build in *asan* | *tsan*) sanitized=yes ;; esac
bad='{"scene": "builtin:spheres", "kind": "benchmark", "name": "bad", "render": {"width": 64, "height": 48}}'
run_bad() { # FAULT: starts a daemon with this fault, and runs the job `bad` to its end
    daemon_stop
    PENUMBRA_TEST_FAULT=$1
    export PENUMBRA_TEST_FAULT
    daemon_start
    PENUMBRA_URL=$url
    submit "$bad"
    id=${job##*/}
    "$penumbra" wait "$id" >/dev/null 2>&1
    call "/v1/jobs/$id"
}
run_bad segv@3,5@bad
expect "a benchmark that crashes its worker fails" "$(body '.state + " " + (.attempts | tostring)')" "failed 3"
if [ -z "$sanitized" ]; then
    expect "its error has signal and pixel" "$(body '.error.signal + " " + (.error.pixel | join(","))')" "SIGSEGV 3,5"
    expect_match "its error names the benchmark" "$(body .error.detail)" "*at a run of view*"
    line=$(body .error.repeat)
    (PATH=$build:$PATH && eval "$line") >repeated 2>&1
    expect_match "the command line in its error repeats the benchmark" "$(cat repeated)" "row *median ms*"
fi
forget_injected_segv
if [ -z "$sanitized" ]; then # under a sanitizer there is no memory limit, and filling memory takes minutes
    run_bad alloc@3,5@bad
    expect_match "a benchmark that runs out of memory fails" "$(body '.state + " " + .error.type')" "failed *:no-memory"
fi
submit '{"scene": "builtin:spheres", "render": {"width": 16, "height": 12}}'
"$penumbra" wait "${job##*/}" >/dev/null 2>&1
call "$job"
expect "the worker renders the next job" "$(body .state)" succeeded
if [ -z "$sanitized" ]; then
    daemon_stop
    PENUMBRA_TEST_FAULT=alloc@3,5
    daemon_start
    exits "bench --server ends in the code of the job's error" 9 "$penumbra" bench builtin:spheres --server "$url" -q
fi

finish

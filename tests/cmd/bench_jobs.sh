#!/bin/sh
# SPDX-License-Identifier: MIT
# Benchmarks through a daemon: by the command line, against kills, cancels and ends of the daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
daemon_start
PENUMBRA_URL=$url
export PENUMBRA_URL

small="--kind benchmark --set width=40 --set height=30 --repeats 2 -m accelerator=none,auto -m threads=1,0"
# Runs of a fraction of a second, whatever the machine and the build; many of them, or few.
"$penumbra" render builtin:spheres --set width=200 --set height=150 --stats stats.json
run="--kind benchmark --set width=200 --set height=150 --set tile=8"
run="$run --set samples_per_pixel=$(jq '200 / (.timing.render_ms + 1) | floor + 1' stats.json)"
lengthy="$run --repeats 100"
done_runs() { # ID
    curl -s "$url/v1/jobs/$1" | jq .progress.done
}
has_runs() { # ID COUNT
    [ "$(done_runs "$1")" -ge "$2" ]
}
idle() {
    [ "$(curl -s "$url/v1/workers" | jq '[.workers[].batches[]] | length')" = 0 ]
}

# From submit to report
for form in html json csv md; do
    ends "submit and fetch as $form" 0 "$penumbra" submit builtin:spheres $small -q -o "r.$form"
done
expect "JSON has the rows" "$(jq -c '[.rows[] | [.settings.accelerator, .threads, .row]]' r.json)" \
    '[["none",1,0],["none",2,1],["auto",1,2],["auto",2,3]]'
expect "the pictures are the same" "$(jq '[.rows[] | .identical and .same_as == 0] | all' r.json)" true
expect "HTML is a page" "$(head -n 1 r.html)" "<!doctype html>"
expect "CSV has a line for each row" "$(wc -l <r.csv)" 5
ends "the same without a daemon" 0 "$penumbra" bench builtin:spheres --set width=40 --set height=30 \
    --repeats 2 -m accelerator=none,auto -m threads=1,0 -q --threads 2 -o local.json
facts='del(.began_at, .ended_at, .load_average, .notes) | .rows |= map(del(.median_ms, .min_ms, .max_ms,
    .runs_ms, .speedup, .build_ms, .render_ms, .cpu_ms, .mrays_per_second, .accelerator.build_ms))'
expect "gives the same report but for the times" "$(jq -cS "$facts" local.json)" "$(jq -cS "$facts" r.json)"
job=$("$penumbra" submit builtin:spheres $small)
ends "wait" 0 "$penumbra" wait "$job"
expect "counts runs to the end" "$(curl -s "$url/v1/jobs/$job" | jq -c '.progress | [.done, .total]')" "[14,14]"
ends "fetch --report" 0 "$penumbra" fetch --report "$job" -o f.md
expect "brings Markdown" "$(head -c 12 f.md)" "# Benchmark:"
ends "fetch --report as a picture" 2 "$penumbra" fetch --report "$job" -o f.png
ends "fetch without --report" 4 "$penumbra" fetch "$job" -o f.png
says "says what there is" stderr "it has a report and no picture"
ends "stats" 0 "$penumbra" stats "$job"
expect "count tests" "$(jq '.accelerator.primitive_tests_per_ray > 0' stdout)" true
printf '{"scene": "builtin:spheres", "kind": "benchmark", "repeats": 1, "render": {"width": 9, "height": 9}}' >job.json
ends "a job from a file, its report" 0 "$penumbra" submit job.json -q -o j.csv
ends "a picture of a benchmark" 2 "$penumbra" submit job.json --kind benchmark -o j.png
ends "a wrong matrix" 3 "$penumbra" submit builtin:spheres --kind benchmark -m accelerator=nine
says "is named by its place" stderr "/matrix/accelerator/0: must be one of"
ends "a matrix of a render" 3 "$penumbra" submit builtin:spheres -m threads=1,2
says "is refused" stderr "belongs to jobs of kind"

# The report over HTTP
call "/v1/jobs/$job/report"
expect "report is a page" "$status $(header content-type)" "200 text/html; charset=utf-8"
expect "that may load nothing" "$(header content-security-policy)" "default-src 'none'; style-src 'unsafe-inline'"
tag=$(header etag)
call "/v1/jobs/$job/report" -H "If-None-Match: $tag"
expect "report is not sent twice" "$status" 304
call "/v1/jobs/$job/report" -H 'Accept: application/json' -H "If-None-Match: $tag"
expect "each type has a tag of its own" "$status $(header content-type) $(header vary)" "200 application/json Accept"
call "/v1/jobs/$job/report" -H 'Accept: image/png'
expect_problem "no other types" 406 '*text/html, application/json, text/csv or text/markdown*image/png*'
call "/v1/jobs/$job/report" -I
expect "HEAD" "$status" 200
call "/v1/jobs/$job/image"
expect_problem "no picture" 404 '*it has a report*'

# Alone in its worker, and cancelled
job=$("$penumbra" submit builtin:spheres $lengthy)
within 30 has_runs "$job" 2 || not_ok "runs are counted while it goes on" "$(done_runs "$job")"
render=$("$penumbra" submit builtin:spheres --set width=20 --set height=20)
sleep 0.5
expect "nothing runs beside it" "$(curl -s "$url/v1/workers" | jq -c '[.workers[].batches[].kind]')" '["benchmark"]'
call "/v1/jobs/$job/report"
expect_problem "no report yet" 409 '*is running*'
expect "try again" "$(header retry-after)" 1
begun=$(date +%s%N)
"$penumbra" cancel "$job" >/dev/null
within 20 sh -c "curl -s '$url/v1/jobs/$render' | jq -e '.state == \"succeeded\"'" || not_ok "the next job" "does not run"
took=$((($(date +%s%N) - begun) / 1000000))
echo "cancel to the next job's end: $took ms"
if [ "$took" -lt 5000 ]; then ok "cancel is felt soon"; else not_ok "cancel is felt soon" "$took ms"; fi
call "/v1/jobs/$job/report"
expect_problem "a cancelled one has no report" 409 '*is cancelled*'

# Killed
middle="$run --repeats 4 -m threads=1,2"
job=$("$penumbra" submit builtin:spheres $middle)
within 30 has_runs "$job" 2 || not_ok "the one to be killed" "does not run"
kill -KILL "$(child work)"
killed=$(date -u +%Y-%m-%dT%H:%M:%S)
ends "a killed worker's benchmark is done by the next" 0 "$penumbra" wait "$job" -q
"$penumbra" fetch --report "$job" -o k.json
began=$(jq -r .began_at k.json)
if [ "$(printf '%s\n%s\n' "$killed" "$began" | sort | head -n 1)" = "$killed" ]; then
    ok "which measures anew"
else
    not_ok "which measures anew" "began at $began, killed at $killed"
fi
expect "all of it" "$(jq -c '[.rows[].runs_ms | length]' k.json)" "[4,4]"
expect "and nothing is charged" "$(curl -s "$url/v1/jobs/$job" | jq .attempts)" 1

# The daemon ends in the middle
job=$("$penumbra" submit builtin:spheres $lengthy)
within 30 has_runs "$job" 2 || not_ok "the one to be left" "does not run"
begun=$(date +%s%N)
daemon_stop TERM
took=$((($(date +%s%N) - begun) / 1000000))
echo "end of the daemon: $took ms"
if [ "$took" -lt 5000 ]; then ok "a daemon does not wait for it"; else not_ok "a daemon does not wait for it" "$took ms"; fi
daemon_start
PENUMBRA_URL=$url
within 30 has_runs "$job" 1 && ok "and takes it up again" || not_ok "and takes it up again" "$(done_runs "$job")"
expect "uncharged" "$(curl -s "$url/v1/jobs/$job" | jq .attempts)" 1
"$penumbra" cancel "$job" >/dev/null
within 20 idle && ok "the worker is free" || not_ok "the worker is free" "$(curl -s "$url/v1/workers")"

# One that brings its worker down, or runs it out of memory
sanitized=
case $build in *asan* | *tsan*) sanitized=yes ;; esac
bad='{"scene": "builtin:spheres", "kind": "benchmark", "name": "bad", "render": {"width": 64, "height": 48}}'
again() { # FAULT: a daemon with this fault; the bad job to its end
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
again segv@3,5@bad
expect "a benchmark that crashes its worker fails" "$(body '.state + " " + (.attempts | tostring)')" "failed 3"
if [ -z "$sanitized" ]; then
    expect "and says where" "$(body '.error.signal + " " + (.error.pixel | join(","))')" "SIGSEGV 3,5"
    expect_match "and in what" "$(body .error.detail)" "*at a run of the benchmark*"
    line=$(body .error.repeat)
    (PATH=$build:$PATH && eval "$line") >repeated 2>&1
    expect_match "the line that repeats it does" "$(cat repeated)" "row *median ms*"
fi
forget_injected_segv
if [ -z "$sanitized" ]; then # which knows no limit of memory, and takes minutes to fill its own
    again alloc@3,5@bad
    expect_match "one without memory fails" "$(body '.state + " " + .error.type')" "failed *:no-memory"
fi
submit '{"scene": "builtin:spheres", "render": {"width": 16, "height": 12}}'
"$penumbra" wait "${job##*/}" >/dev/null 2>&1
call "$job"
expect "and the worker goes on" "$(body .state)" succeeded

finish

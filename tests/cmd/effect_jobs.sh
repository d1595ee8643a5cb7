#!/bin/sh
# SPDX-License-Identifier: MIT
# Bills of effects as jobs, and explanations over HTTP, in the good case and with errors.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
daemon_start
PENUMBRA_URL=$url
export PENUMBRA_URL

# explain DATA: asks for an explanation, up to three times: one that takes longer than 10 s becomes a job, which
# is removed. DATA is JSON or @FILE.
explain() {
    for _ in 1 2 3; do
        call /v1/explain -H 'Content-Type: application/json' --data-binary "$1"
        [ "$status" = 202 ] || return
        late=$(header location)
        curl -s -o /dev/null -X POST "$url$late/cancel"
        curl -s -o /dev/null -X DELETE "$url$late"
    done
}
jobs_left() {
    curl -s "$url/v1/jobs?kind=explain" | jq '.jobs | length'
}

# Bills of effects
bill="--kind effects --set width=40 --set height=30 --repeats 2"
for form in html json csv md; do
    exits "submit and fetch as $form" 0 "$penumbra" submit builtin:glass $bill -q -o "r.$form"
done
expect "CSV has a line for each effect, and one for all" "$(wc -l <r.csv | tr -d ' ')" 11
expect "Markdown has a table" "$(grep -c '^| row | without |' r.md)" 1
expect "HTML has a picture for each effect, and the whole one" "$(grep -o 'data:image/png;base64,' r.html | wc -l | tr -d ' ')" 10
exits "the same bill without a daemon" 0 "$penumbra" effects builtin:glass --set width=40 --set height=30 \
    --repeats 2 -q --threads 2 -o local.json
facts='del(.scene, .timing) | .rows |= map(del(.median_ms, .min_ms, .max_ms, .spoiled, .cost_ms, .cost_share, .cost_below_ms))'
expect "gives the same report except times" "$(jq -cS "$facts" local.json)" "$(jq -cS "$facts" r.json)"
job=$("$penumbra" submit builtin:glass $bill)
exits "wait for a bill" 0 "$penumbra" wait "$job"
call "/v1/jobs/$job"
expect "its progress counts all renders" "$(body '.progress | [.done, .total] | tostring')" "[30,30]"
expect "the job says how often" "$(body '[.kind, .repeats] | tostring')" '["effects",2]'
call "/v1/jobs/$job/report"
expect "GET report gives the page" "$status $(header content-type)" "200 text/html; charset=utf-8"
call "/v1/jobs/$job/report" -H 'Accept: text/csv'
expect "or CSV" "$status $(header content-type)" "200 text/csv; charset=utf-8"
call "/v1/jobs/$job/image"
expect_problem "it has no picture" 404 '*it has a report*'
call "/v1/jobs/$job/stats"
expect "statistics are those of the whole scene" "$(body '[.rays.primary, .effects | tostring] | tostring')" \
    "$(jq -c '[.rows[0].rays.primary, (.rows | map(.without) | .[1:])] | map(tostring)' r.json)"
submit '{"scene": "builtin:room", "kind": "effects", "views": ["main", "main"]}'
expect_problem "views that are too many" 422 '*'
submit '{"scene": "builtin:glass", "kind": "effects", "repeats": 100, "render": {"width": 9000, "height": 9000}}'
expect_problem "pictures that are too large" 413 '*'

# A bill is alone in its worker, can be cancelled, gives way to a job of higher priority, and goes on when
# its worker dies.
run="--set width=160 --set height=120"
run="--kind effects $run --set tile=8 --set samples_per_pixel=$(($(samples_lasting 60 builtin:glass $run) + 1))"
job=$("$penumbra" submit builtin:glass $run --repeats 100)
within has_runs "$job" 2 || not_ok "progress counts renders during a bill" "$(done_runs "$job")"
expect "the worker says what it does" "$(curl -s "$url/v1/workers" | jq -c '[.workers[].batches[].kind]')" '["effects"]'
call "/v1/jobs/$job/report"
expect_problem "GET report of a running bill" 409 '*is running*'
"$penumbra" cancel "$job" >/dev/null
explain "$small"
expect "an explanation after a cancelled bill" "$status" 200
job=$("$penumbra" submit builtin:glass $run --repeats 2)
check_goes_on "$job" 4
exits "the bill of a killed worker succeeds" 0 "$penumbra" wait "$job" -q
expect "and all its renders are counted" "$(curl -s "$url/v1/jobs/$job" | jq -c '.progress.done == .progress.total')" true
job=$("$penumbra" submit builtin:glass $run --repeats 100) # the first may end before another job is there
check_gives_way "$job" 2
"$penumbra" cancel "$job" >/dev/null

# Explanations
explain '{"scene": "builtin:glass", "render": {"width": 160, "height": 120}}'
expect "an explanation" "$status $(header content-type)" "200 application/json"
expect "says what the scene calls for" "$(body '[.effects[].name] | join(" ")')" \
    "ambient hard_shadows shadow_transmittance mirror transmission specular sky patterns refraction"
expect "and what is expected" "$(body '.rays.total | .low <= .expected and .expected <= .high')" true
expect "the same as on the command line" "$(body '[.effects, .absent, .kernel, .rays] | tostring')" \
    "$("$penumbra" explain builtin:glass --set width=160 --set height=120 --json | jq -r '[.effects, .absent, .kernel, .rays] | tostring')"
expect "without a render nothing is actual" "$(body '.time_ms | has("actual")')" false
explain '{"scene": "builtin:glass", "analyze": true, "render": {"width": 160, "height": 120}}'
expect "--analyze over HTTP" "$status $(body '.rays.primary.actual')" "200 19200"
explain @"$root/tests/golden/scenes/refraction.json"
expect "a bare scene" "$status" 200
call /v1/explain -H 'Content-Type: text/xml' --data-binary '<fog/>'
expect_problem "a wrong scene in XML" 422 '*'
explain '{"scene": "builtin:room", "views": ["left"], "render": {"width": 16, "height": 16}}'
expect_problem "a view that is not there" 422 '*'
explain '{"scene": "builtin:room", "kind": "effects"}'
expect_problem "another kind" 422 '*must be one of render, explain*'
explain '{"scene": "builtin:room", "analyze": "yes"}'
expect_problem "analyze must be a boolean" 422 '*must be true or false*'
call /v1/explain
expect "the method GET" "$status" 405
explain '{"scene": "builtin:glass", "analyze": true, "timeout_seconds": 0.2, "render": {"width": 3000, "height": 2400, "samples_per_pixel": 64}}'
expect_problem "the error of an explanation that fails" 504 '*longer than its timeout_seconds*'
failed=$(header location)
expect "the failed job is kept" "$(curl -s "$url$failed" | jq -r .state)" failed
curl -s -X DELETE "$url$failed"
expect "no explanation that was answered is kept" "$(jobs_left)" 0

# One that takes longer than 10 s becomes a job.
if [ -n "${PEN_TIMED:-}" ]; then
    begun=$(now_ms)
    call /v1/explain -H 'Content-Type: application/json' \
        --data-binary '{"scene": "builtin:glass", "analyze": true, "render": {"width": 3000, "height": 2400, "samples_per_pixel": 64}}'
    took=$(($(now_ms) - begun))
    expect "a long explanation" "$status $(body .kind)" "202 explain"
    expect "is answered after 10 s" "$((took >= 9900))" 1
    timed "and before 30 s" "$took" 30000
    job=$(header location)
    expect "the job can be followed" "$(curl -s "$url$job" | jq -r .state)" running
    curl -s -o /dev/null -X POST "$url$job/cancel"
fi
job=$(curl -s "$url/v1/jobs" -d '{"scene": "builtin:room", "kind": "explain"}' | jq -r .errors[0].pointer)
expect "jobs of kind explain are made by explain alone" "$job" /kind
check_sanitizer_reports
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# What the log says of requests: those that change the store, but not all if they are many, and of
# others little; and the counters that tell how many there were.
. "$(dirname "$0")/lib.sh"

metric() { # SERIES: its value
    curl -s "$url/metrics" | awk -v series="$1" '$1 == series { print $2 }'
}
lines() { # PATTERN: the number of lines of the log that match
    grep -c "$1" "$work/log"
}
# Requests are counted and logged after their answers were sent, and a thread of its own writes the
# lines: wait_for_line PATTERN, wait_for_value SERIES VALUE
wait_for_line() {
    within grep -q "$1" "$work/log"
}
has_value() {
    [ "$(metric "$1")" = "$2" ]
}
wait_for_value() {
    within has_value "$@"
}
repeat() { # COUNT PATH [CURL-ARGUMENT...]: makes a request so many times on one connection
    many=$1 path=$2
    shift 2
    curl -s -o /dev/null "$@" "$url$path#[1-$many]"
}

daemon_start --max-queue 1
submit "$long" -H 'Idempotency-Key: once'
expect submitted "$status" 202
wait_for_line 'POST /v1/jobs 202'
expect submit-is-logged "$(lines 'POST /v1/jobs 202')" 1

# An earlier submit's answer, a check, and a full queue change nothing.
repeat 20 /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: once' -d "$long"
expect repeated-submits-are-not "$(lines 'POST /v1/jobs 202')" 1
repeat 20 /v1/validate -H 'Content-Type: application/json' -d "$small"
expect validations-are-not "$(lines /v1/validate)" 0
repeat 30 /v1/jobs -H 'Content-Type: application/json' -d "$small"
wait_for_value 'penumbra_http_refused_requests_total{code="429"}' 30
expect refusals-are-counted "$(metric 'penumbra_http_refused_requests_total{code="429"}')" 30
expect others-are-not "$(metric 'penumbra_http_refused_requests_total{code="503"}') $(metric penumbra_http_failed_requests_total)" "0 0"
wait_for_line 'POST /v1/jobs 429'
expect few-refusals-are-logged "$([ "$(lines 'POST /v1/jobs 429')" -le 5 ] && echo yes)" yes

# One cancel of many cancels, and one delete deletes.
repeat 20 "$job/cancel" -X POST
wait_for_line "POST $job/cancel 202"
expect cancel-is-logged-once "$(lines "POST $job/cancel 202")" 1
repeat 20 "$job" -X DELETE
wait_for_line "DELETE $job 204"
expect delete-is-logged-once "$(lines "DELETE $job 204") $(lines "DELETE $job")" "1 1"

# With the end at the latest the log tells how many were refused. The daemon waits no longer than a second
# for its last lines, and so may end without them on a machine that halts it: then once more.
tell() { # PATTERN LEVEL KIND: sets $told and $more, the requests with lines of their own and without
    told=$(lines "$1")
    more=$(sed -n "s/.* $2 .* \([0-9]*\) more requests $3 since 2.*/\1/p" "$work/log" | awk '{ sum += $1 } END { print sum + 0 }')
}
tell_refusals() {
    daemon_stop
    tell 'POST /v1/jobs 429' warn 'were refused (429, 503)'
}
tell_refusals
if [ $((told + more)) -ne 30 ]; then
    daemon_start --max-queue 1
    : >"$work/log"
    submit "$long"
    repeat 30 /v1/jobs -H 'Content-Type: application/json' -d "$small"
    call "$job/cancel" -X POST
    tell_refusals
fi
expect all-refusals-are-told "$((told + more))" 30

# Of submits only so many in a minute have lines of their own; a test that takes minutes has more.
tell_submits() {
    begun=$(date +%s)
    daemon_start
    : >"$work/log"
    repeat 900 /v1/jobs -H 'Content-Type: application/json' -d '{"scene": "builtin:spheres", "render": {"width": 1, "height": 1}}'
    daemon_stop
    minutes=$((($(date +%s) - begun) / 60 + 1))
    tell 'POST /v1/jobs 202' info 'changed the store'
}
tell_submits
[ $((told + more)) -eq 900 ] || tell_submits
expect submits-are-told "$((told + more))" 900
expect few-submits-have-lines "$([ "$told" -le $((600 * minutes)) ] && echo yes)" yes
[ "$minutes" -gt 1 ] || expect others-are-counted "$((more > 0))" 1

finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# Requests in the log. Requests that change the store have a line. Requests that read or are refused have
# none, because clients decide how many there are; they are counted.
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
before=$(metric 'penumbra_http_refused_requests_total{code="503"}') # while the store was being opened
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
expect others-are-not "$(metric 'penumbra_http_refused_requests_total{code="503"}') $(metric penumbra_http_failed_requests_total)" "$before 0"
expect refusals-are-not-logged "$(lines 'POST /v1/jobs 429')" 0

# One cancel of many cancels, and one delete deletes.
repeat 20 "$job/cancel" -X POST
wait_for_line "POST $job/cancel 202"
expect cancel-is-logged-once "$(lines "POST $job/cancel 202")" 1
repeat 20 "$job" -X DELETE
wait_for_line "DELETE $job 204"
expect delete-is-logged-once "$(lines "DELETE $job 204") $(lines "DELETE $job")" "1 1"

finish

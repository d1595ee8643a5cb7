#!/bin/sh
# SPDX-License-Identifier: MIT
# Bad requests leak no memory: between the 1 000th and the 10 000th bad request the api process grows
# by less than 4 MiB.
. "$(dirname "$0")/lib.sh"
daemon_start

api=$daemon # or its api child, if it has one
for child in $(pgrep -P "$daemon"); do
    [ "$(cat "/proc/$child/comm")" = penumbrad-api ] && api=$child
done
resident_kib() {
    awk '/^VmRSS:/ {print $2}' "/proc/$api/status"
}

# Bodies: a syntax error, deep nesting, many errors, too large, no text.
awk 'BEGIN {printf "{\"scene\": ["; for (i = 0; i < 20000; i++) printf "[1,2],"; print "}"}' >"$work/syntax"
awk 'BEGIN {for (i = 0; i < 100000; i++) printf "["}' >"$work/deep"
awk 'BEGIN {
    printf "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0,0,9], \"look_at\": [0,0,0]}, \"objects\": ["
    for (i = 0; i < 5000; i++) printf "{\"type\": \"sphere\", \"center\": [0,0,%d], \"radius\": -1, \"colour\": 5},", i
    print "{}]}"
}' >"$work/invalid"
head -c 17000000 /dev/zero >"$work/large"
head -c 70000 /dev/urandom >"$work/noise"

request() { # PATH [CURL-CONFIG-LINE...]
    echo "url = $url$1"
    echo 'output = /dev/null'
    shift
    for line in "$@"; do echo "$line"; done
    echo next
}
hundred() {
    for path in /v1/jobs /v1/validate; do
        for body in syntax deep invalid noise; do
            request $path "data-binary = @$work/$body"
        done
        request $path "upload-file = $work/large" 'request = POST' # the daemon refuses it before reading all of it
        request $path 'data = <scene>'
        request $path 'data = {}' 'header = "Content-Type: text/plain"'
        request $path 'data = {}' 'header = "Transfer-Encoding: chunked"'
        request $path 'data = {}' 'header = "Origin: http://evil.com"'
        request $path 'data = {}' 'header = "Host: evil.com"'
        request $path 'request = PATCH'
        request "$path?x=1" 'data = {}'
        for i in 1 2 3 4 5 6 7 8 9 10; do
            request $path 'data = {"scene": "builtin:rom"}' "header = \"Idempotency-Key: $i\""
            request $path 'data = {"scene": "builtin:spheres", "render": {"width": 0}, "prio": 1}'
        done
    done
    for i in 1 2 3 4 5 6; do
        request "/nowhere/$i"
        request '/v1/jobs/01890a5d-ac96-774b-bcce-b302099a8057/image'
        request '/v1/jobs/01890a5d-ac96-774b-bcce-b302099a8057?wait=60'
        request '/v1/jobs?limit=0'
        request '/v1/jobs?cursor=%%%'
        request "/v1/scenes/$i"
    done
}
for n in 1 2 3 4 5 6 7 8 9 10; do
    hundred "$n"
done >"$work/thousand"
expect a-thousand "$(grep -c ^next "$work/thousand")" 1000

thousand() {
    curl -s -Z --parallel-max 8 -K "$work/thousand" 2>/dev/null
}
# The least size within 2 s: memory that was just freed may go back to the system a moment later.
settled_kib() {
    least=$(resident_kib)
    for _ in 1 2 3 4 5 6 7 8 9 10; do
        sleep 0.2
        now=$(resident_kib)
        [ "$now" -lt "$least" ] && least=$now
    done
    echo "$least"
}
if nm "$build/penumbrad" | grep -qE '__(asan|tsan)_init'; then
    # A sanitizer keeps freed memory; its own report of leaks is checked instead.
    thousand
    call /healthz
    expect alive-after-a-thousand "$status" 200
    finish
fi
thousand
first=$(settled_kib)
for _ in 2 3 4 5 6 7 8 9 10; do thousand; done
for _ in 1 2 3 4 5; do # a daemon that is halted returns memory later
    last=$(settled_kib)
    [ $((last - first)) -ge 4096 ] || break
done
echo "resident: $first KiB after 1000 bad requests, $last KiB after 10000"
expect growth-under-4-MiB "$([ $((last - first)) -lt 4096 ] && echo yes || echo "$first to $last KiB")" yes
call /v1/jobs
expect nothing-was-stored "$status $(body '.jobs | length')" "200 0"
finish

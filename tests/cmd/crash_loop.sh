#!/bin/sh
# SPDX-License-Identifier: MIT
# Processes that die again and again: the supervisor replaces them after growing pauses, readiness
# says why it is lost, and a process that stays alive restores it. Mostly waits, so that run.sh may
# run it beside other tests.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
start() {
    daemon_start
    export PENUMBRA_URL="$url"
}

# A program that cannot work: pauses, and readiness that says so
start
for _ in 1 2 3 4; do
    within 5 child work
    worker=$(child work)
    kill -KILL "$worker"
    within 2 gone "$worker"
done
code=$(curl -s -o ready.json -w '%{http_code}' "$url/readyz")
expect "a worker that keeps dying is not ready" "$code" 503
expect_match "and readiness says why" "$(jq -r .detail ready.json)" '*worker process ended*SIGKILL*'
check "it is replaced all the same" within 10 child work
check "the log says so" grep -q "(3 in a row)" "$work/log"
check "and is forgotten once it lives" within 15 sh -c \
    "[ \"\$(curl -s -o /dev/null -w '%{http_code}' '$url/readyz')\" = 200 ]"

# An api that keeps dying says so once it answers again
for _ in 1 2 3 4; do
    within 8 child api
    api=$(child api)
    kill -KILL "$api"
    within 2 gone "$api"
done
check "an api that keeps dying is not ready" within 8 sh -c \
    "[ \"\$(curl -s -o ready.json -w '%{http_code}' '$url/readyz')\" = 503 ]"
expect_match "and says so itself" "$(jq -r .detail ready.json)" '*api process ended*SIGKILL*'
check "and forgets it once it lives" within 15 sh -c \
    "[ \"\$(curl -s -o /dev/null -w '%{http_code}' '$url/readyz')\" = 200 ]"

finish

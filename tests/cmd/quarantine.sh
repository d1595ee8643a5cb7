#!/bin/sh
# SPDX-License-Identifier: MIT
# Jobs that crash or block their worker. Each fails alone, with an error that has the place and the reason,
# and other jobs succeed.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
unset PENUMBRA_MEMORY_LIMIT
sanitized=
threads=1
case $build in *asan* | *tsan*) sanitized=yes ;; esac
start() { # FAULT [ARGUMENT…]
    PENUMBRA_TEST_FAULT=$1
    export PENUMBRA_TEST_FAULT
    shift
    daemon_start "$@"
    export PENUMBRA_URL="$url"
}
bad() { # MEMBERS: submits a job called bad, and sets $id
    submit "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 64, \"height\": 48}, \"name\": \"bad\"$1}"
    id=${job##*/}
}
good() {
    submit "$small"
    echo "${job##*/}" >>goods
}
all_good() { # whether every good job has succeeded
    while read -r one; do
        "$penumbra" wait "$one" >/dev/null 2>&1 || return 1
    done <goods
}
failed() { # NAME TYPE: the bad job failed with a problem document of this type; it is in $work/body
    "$penumbra" wait "$id" >/dev/null 2>&1
    call "/v1/jobs/$id"
    expect "$1" "$(body .state) $(body .error.type)" "failed urn:penumbra:problem:$2"
}

# A scene that crashes the renderer fails alone
start segv@3,5@bad
bad ', "priority": 100'
: >goods
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do good; done
failed "a job that crashes its worker fails" job-failed
expect "it fails after three attempts" "$(body .attempts)" 3
expect "its error has the batch" "$(body '.error.batch | [.view, .first_tile] | join(",")')" 0,0
expect_match "and the last log lines" "$(body '.error.log | join("|")')" "*job=$id batch=*"
line=$(body .error.repeat)
if [ -z "$sanitized" ]; then
    expect "and the signal" "$(body .error.signal)" SIGSEGV
    expect "and the pixel" "$(body '.error.pixel | join(",")')" 3,5
    (PATH=$build:$PATH && eval "$line") >repeated 2>&1
    expect_match "and a command line that repeats the failure" "$(cat repeated)" "*pixel   3,5 of 64 x 48*"
else
    expect_match "and a command line that repeats the failure" "$line" "*penumbra render -*"
fi
check "20 other jobs succeed meanwhile" all_good
expect "on their first attempt" \
    "$("$penumbra" list --json | jq -c '[.jobs[] | select(.name != "bad") | .attempts] | unique')" "[1]"
expect "all 21 jobs are listed" "$("$penumbra" list --json | jq '.jobs | length')" 21
daemon_stop
forget_injected_segv

# What a job is charged with is not held against the worker: the daemon stays ready
start segv@1,1@bad
(while :; do curl -s -o /dev/null -w '%{http_code}\n' "$url/readyz" && sleep 0.05; done) >ready &
loop=$!
bad ''
failed "a job that crashes its worker thrice fails" job-failed
: >goods
good
check "the next job succeeds" all_good
sleep 1
kill $loop
wait $loop 2>/dev/null
expect "and the daemon was ready all the time" "$(sort -u ready)" 200
check "the log tells whose fault it was" grep -q "(1 in a row; this one is charged to its job)" "$work/log"
daemon_stop
forget_injected_segv

# A worker that crashes over each job is not sound
start segv@1,1
not_ready() { [ "$(curl -s -o ready.json -w '%{http_code}' "$url/readyz")" = 503 ]; }
for _ in 1 2 3 4 5 6; do bad ', "max_attempts": 1'; done # three in a row count, each within 10 s of its start
check "a daemon whose worker crashes over each job is not ready" within not_ready
expect_match "/readyz gives the reason" "$(jq -r .detail ready.json)" '*worker process ended * times*or over different jobs*'
daemon_stop
forget_injected_segv

# Other kinds of crashes
for kind in abort exit; do
    start $kind@0,0@bad
    bad ', "max_attempts": 1'
    failed "a job is charged with $kind" job-failed
    case $kind in
    exit) expect "its error has the exit code" "$(body .error.exit_code)" 1 ;;
    abort) [ -n "$sanitized" ] || expect "its error has the signal" "$(body .error.signal)" SIGABRT ;;
    esac
    daemon_stop
done

# A worker's end by SIGKILL is charged to no job, unless memory ran out meanwhile
echo "oom_kill 7" >events
PENUMBRA_TEST_OOM=$work/events
export PENUMBRA_TEST_OOM
start kill@0,0@bad
bad ', "max_attempts": 1, "priority": 100'
: >goods
for _ in 1 2 3 4 5 6; do good; done
died_often() { [ "$(grep -c 'signal 9' "$work/log")" -ge 4 ]; }
check "a job whose worker is killed is tried again" within died_often
check "other jobs succeed" all_good
call "/v1/jobs/$id"
expect "and the job is not charged" "$(body .state) $(body .attempts)" "running 1"
(n=8 && while :; do echo "oom_kill $n" >events.new && mv events.new events && n=$((n + 1)) && sleep 0.02; done) &
loop=$!
failed "a job whose worker the OOM killer ends fails" job-failed
expect "its error has the signal" "$(body .error.signal)" SIGKILL
kill $loop
daemon_stop
unset PENUMBRA_TEST_OOM

# Memory
if [ -z "$sanitized" ]; then
    start alloc@0,0@bad --memory-limit 1024
    within child work
    worker=$(child work)
    bad ''
    failed "a job that takes too much memory fails" no-memory
    good
    check "the next job succeeds" all_good
    expect "the worker process is the same" "$(child work)" "$worker"
    daemon_stop
fi

# A pixel that never ends
start hang@2,1@bad
within child work
worker=$(child work)
bad ', "timeout_seconds": 1'
begun=$(now_ms)
failed "a job with a pixel that never ends fails with a timeout" timeout
timed "it fails within 4 s" $(($(now_ms) - begun)) 4000
expect "its error has the pixel" "$(body '.error.pixel | join(",")')" 2,1
: >goods
good
check "other jobs succeed" all_good
check "in another worker" gone "$worker"
worker=$(child work)
runs() {
    call "/v1/jobs/$id"
    [ "$(body .state)" = running ]
}
# A worker that had not come to the pixel when its job was cancelled goes on, and gets another such job.
for _ in 1 2 3 4 5; do
    bad ''
    within runs
    sleep 0.5
    "$penumbra" cancel "$id" >stdout 2>stderr
    cancelled=$?
    within gone "$worker" && break
done
expect "such a job can be cancelled" "$cancelled" 0
prints "and is cancelled" stdout "$id cancelled"
good
check "other jobs succeed" all_good
check "in another worker" gone "$worker"
expect "no other job was charged" \
    "$("$penumbra" list --json | jq -c '[.jobs[] | select(.name != "bad") | .attempts] | unique')" "[1]"

finish

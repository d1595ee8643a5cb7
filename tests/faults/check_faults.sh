#!/bin/sh
# SPDX-License-Identifier: MIT
# A daemon whose disk fails. It accepts no job that could be lost, loses no accepted job, and serves
# everything that can be read. It recovers by itself when the disk works again. Processes that meet an I/O
# error are replaced. preload.c simulates the failing disk; if tmpfs may be mounted, there is also a disk that
# is really full.
. "$(dirname "$0")/../cmd/lib.sh"
cd "$work" || exit 1
export FAULTS_STORE="$store" FAULTS_CONTROL="$work/control"
# The sanitizer's library insists on being loaded first; here preload.so comes before it.
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}verify_asan_link_order=0"
: >control
start() {
    LD_PRELOAD="$build/tests/faults/preload.so" daemon_start "$@"
    export PENUMBRA_URL="$url"
}
fault() { # TEXT: the faults from now on, see preload.c
    printf '%s\n' "$1" >control.new
    mv control.new control
}
state_of() { # ID
    curl -s "$url/v1/jobs/$1" | jq -r .state
}
has_begun() { # ID: whether the job is running, or has succeeded already; sets $state
    state=$(state_of "$1")
    [ "$state" = running ] || [ "$state" = succeeded ]
}
# Submits the job of this script and sets $id, as often as five times until one is seen while it runs: this
# script may be held up for longer than the job takes.
begin_job() {
    for _ in 1 2 3 4 5; do
        id=$("$penumbra" submit scene.json $args)
        echo "$id" >>taken
        within has_begun "$id" && [ "$state" = running ] && return
    done
    return 1
}
is_ready() { [ "$(curl -s -o ready.json -w '%{http_code}' "$url/readyz")" = 200 ]; }
# A job that takes half a second or more.
"$penumbra" scenes forest >scene.json
set -- --set width=200 --set height=150
set -- "$@" --set samples_per_pixel=$(samples_lasting 400 scene.json "$@")
"$penumbra" render scene.json "$@" -o wanted.pfm
: >taken # every job that was answered with 202
longest=0

is_told() { # PATTERN: whether /readyz gives a reason that matches
    call /readyz
    # shellcheck disable=SC2254
    case $(body .detail) in
    $1) ;;
    *) return 1 ;;
    esac
}

# refuses NAME STATUS DETAIL-PATTERN: a submit is refused, and /readyz gives the same reason.
refuses() {
    # Until the daemon meets the fault, it may still accept a submit; such a job must not be lost.
    for _ in 1 2 3 4 5 6 7 8; do
        submit "$small"
        [ "$status" = 202 ] || break
        basename "$job" >>taken
    done
    expect_problem "$1: a submit is refused" "$2" "$3"
    [ -n "$(header retry-after)" ] && ok "$1: the refusal has Retry-After" ||
        not_ok "$1: the refusal has Retry-After" "no Retry-After"
    within is_told "$3" # a process may be starting
    expect_problem "$1: the daemon is not ready" 503 "$3"
}

# serves NAME ID: stored jobs and pictures can be read.
serves() {
    call "/v1/jobs/$2"
    expect "$1: a job is served" "$status $(body .state)" "200 succeeded"
    call "/v1/jobs/$2/image"
    expect "$1: its picture is served" "$status" 200
    call "/v1/jobs?limit=3"
    expect "$1: lists of jobs are served" "$status" 200
    call /healthz
    expect "$1: /healthz answers" "$status" 200
}

# accepts_again: the daemon is ready and accepts a job. It may refuse one after it was ready: another
# process can report a fault that it met just before the disk worked again.
accepts_again() {
    is_ready || return 1
    submit "$small"
    [ "$status" = 202 ]
}

# recovers NAME: without the fault jobs are accepted again, within 5 s.
recovers() {
    begun=$(now_ms)
    fault ""
    if within accepts_again; then
        took=$(($(now_ms) - begun))
        [ "$took" -le "$longest" ] || longest=$took
        basename "$job" >>taken
        echo "# $1: jobs are accepted $took ms after the disk works"
        ok "$1: jobs are accepted afterwards"
        timed "$1: within 5 s" "$took" 5000
    else
        not_ok "$1: jobs are accepted afterwards" "$(cat ready.json body)"
    fi
}

# fails_and_recovers NAME FAULT STATUS DETAIL-PATTERN READS: the fault occurs while a job is running
# and ends again. READS: `read` if stored results can be read meanwhile, `unread` if not.
fails_and_recovers() {
    begin_job || not_ok "$1: the job starts" "$state"
    fault "$2"
    refuses "$1" "$3" "$4"
    [ "$5" = unread ] || serves "$1" "$done_id"
    sleep 1.5 # time for the worker to meet the fault; it keeps what it has rendered
    recovers "$1"
    exits "$1: the running job succeeds" 0 "$penumbra" wait "$id"
    "$penumbra" fetch "$id" -o got.pfm
    check "$1: its picture has the same bytes" cmp got.pfm wanted.pfm
}

args=$*
start
done_id=$("$penumbra" submit builtin:spheres --set width=32 --set height=32 --wait -o first.png)
done_id=$("$penumbra" list --json | jq -r '.jobs[0].id')
echo "$done_id" >>taken
children="$(child api) $(child work)"
fails_and_recovers "full disk" "write ENOSPC" 507 '*disk is full*' read
fails_and_recovers "disk that fills in mid write" "write SHORT" 507 '*disk is full*' read
expect "a disk without space: the processes are the same" "$(child api) $(child work)" "$children"
# A process that is started again cannot open a store that takes no writes at all
fails_and_recovers "write errors" "write EIO" 503 '*disk I/O error*' unread
fails_and_recovers "failed fsync" "sync EIO" 503 '*disk I/O error*' read
fails_and_recovers "fsync without space" "sync ENOSPC" 503 '*disk I/O error*' read
fails_and_recovers "read errors" "read EIO
write EIO" 503 '*(SQLite error *' unread

# Every third sync fails for a while: an accepted job is on disk nevertheless
fault "sync EIO 3"
for _ in 1 2 3 4 5 6 7 8 9 10 11 12; do
    submit "$small"
    case $status in
    202) basename "$job" >>taken ;;
    503) ;;
    *) not_ok "a disk that fails now and then" "$status" ;;
    esac
    sleep 0.2
done
recovers "a disk that fails now and then"
echo "# longest time until jobs are accepted: $longest ms"

lines=$(grep -c 'trying again' log)
expect "the log is not flooded" "$((lines < 60))" 1
check "the log says why a process ends" grep -q 'the store has an I/O error, so this process ends: .*disk I/O error' log
expect "and no job is charged for it" \
    "$("$penumbra" list --json --limit 500 | jq -c '[.jobs[].attempts] | unique - [0]')" "[1]"

# A daemon stopped while the disk fails ends in time and loses nothing
begin_job || not_ok "a job starts before the daemon stops" "$state"
fault "sync EIO"
submit "$small"
sleep 1
begun=$(now_ms)
daemon_stop
timed "a daemon whose disk fails ends within 11 s" $(($(now_ms) - begun)) 11000
fault ""
start
exits "the next daemon completes the job" 0 "$penumbra" wait "$id"
"$penumbra" fetch "$id" -o got.pfm
check "its picture has the same bytes" cmp got.pfm wanted.pfm

# Every accepted job is there and has ended
exits "wait for all accepted jobs" 0 "$penumbra" wait $(cat taken)
"$penumbra" wait $(cat taken) >ends 2>>log
expect "every accepted job succeeds" "$(grep -c ' succeeded$' ends)" "$(sort -u taken | wc -l | tr -d ' ')"
daemon_stop

# A daemon started with a failing disk reports that and ends
fault "read EIO"
exits "a daemon does not start with a store that it cannot read" 8 env LD_PRELOAD="$build/tests/faults/preload.so" \
    "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
prints "the error has the cause" stderr "disk I/O error"
fault ""

has_bytes() { # FILE COUNT
    [ "$(wc -c <"$1")" -eq "$2" ]
}

# A disk that is really full
full=$work/full
mkdir "$full"
if why=$(mount -t tmpfs -o size=128m tmpfs "$full" 2>&1); then
    trap 'daemon_stop; umount "$full" 2>/dev/null; clean_up' EXIT
    store=$full/penumbra.db
    daemon_start
    within child work # it may not bear its name yet
    children="$(child api) $(child work)"
    submit "$small"
    first=$(basename "$job")
    PENUMBRA_URL=$url "$penumbra" wait "$first" >/dev/null
    # Jobs to be deleted, one that runs and one that waits
    ended=
    for i in $(seq 30); do
        submit "$small"
        ended="$ended $(basename "$job")"
    done
    # shellcheck disable=SC2086
    PENUMBRA_URL=$url "$penumbra" wait $ended >/dev/null
    long=$(PENUMBRA_URL=$url "$penumbra" submit builtin:spheres --set width=4000 \
        --set height=4000 --set samples_per_pixel=64)
    waiting=$(PENUMBRA_URL=$url "$penumbra" submit builtin:spheres --priority -1) # for the end of $long
    within has_bytes "$store-reserve" 16777216 # it is made a second after the start
    expect "the reserve is set aside" "$(wc -c <"$store-reserve")" 16777216
    dd if=/dev/zero of="$full/ballast" bs=64k 2>/dev/null
    dd if=/dev/zero of="$full/crumbs" bs=1k 2>/dev/null
    submit "$small"
    expect_problem "a really full disk: a submit is refused" 507 '*no space left*'
    call /readyz
    expect_problem "a really full disk: the daemon is not ready" 503 '*no space left*'
    call "/v1/jobs/$first"
    expect "a really full disk: a job is served" "$status" 200
    for one in $waiting $long; do
        call "/v1/jobs/$one/cancel" -X POST
        expect "a really full disk: a job is cancelled" "$status $(body .state)" "202 cancelled"
    done
    refused=0
    for one in $ended; do
        call "/v1/jobs/$one" -X DELETE
        [ "$status" = 204 ] || refused=$((refused + 1))
    done
    expect "a really full disk: every job is deleted" "$refused" 0
    call "/v1/jobs/$one"
    expect "a really full disk: a deleted job is gone" "$status" 410
    call "/v1/jobs/$one/stats"
    expect "a really full disk: its statistics are there" "$status" 200
    rm "$full"/ballast "$full"/crumbs
    within is_ready && ok "with space on the disk the daemon is ready" || not_ok "with space on the disk the daemon is ready" "$(cat ready.json)"
    has_reserve() { [ "$(wc -c <"$store-reserve")" = 16777216 ]; }
    check "and the reserve is set aside again" within has_reserve
    check "with space on the disk jobs are accepted" within accepts_again
    expect "by the same processes" "$(child api) $(child work)" "$children"
    check "all accepted jobs succeed" within sh -c "[ \$(curl -s '$url/v1/jobs?limit=500&state=succeeded' |
        jq '.jobs | length') = 2 ]"
    daemon_stop
    umount "$full"
else
    skip mount "the disk that is really full: $why"
fi
finish

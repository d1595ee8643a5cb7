#!/bin/sh
# SPDX-License-Identifier: MIT
# A daemon that is used for a long time: jobs of all kinds, cancels, deletions, readers, clients that leave or
# vanish, processes that are killed, restarts, and retention. `make soak MINUTES=30` runs it.
#   soak.sh [BUILD]     the environment may set MINUTES (30)
# In the first third of the time processes are killed, the daemon is restarted, and the store fills up. In the
# other two thirds nothing is disturbed. Memory, descriptors and sizes of files in the last third must be
# those of the second third. All samples are printed at the end. Every acknowledged job must end in its right
# state, or be a job that was removed.
. "$(dirname "$0")/../e2e/lib.sh"
. "$(dirname "$0")/lib.sh"
minutes=${MINUTES:-30}
keep_mib=64
keep_jobs=400
third=$((minutes * 20)) # seconds
ulimit -n "$(ulimit -Hn)"
mkdir "$work/jobs" # a file for each acknowledged job, which has its kind

jobs_json() { # KIND: the body of a submit
    case $1 in
    small) echo '{"scene": "builtin:spheres", "render": {"width": 64, "height": 48}, "labels": {"of": "soak"}}' ;;
    large) echo '{"scene": "builtin:room", "render": {"width": 400, "height": 560}}' ;;
    target) echo '{"scene": "builtin:forest", "render": {"width": 160, "height": 120, "target_error": 0.01}}' ;;
    views) echo '{"scene": "builtin:teapot", "render": {"width": 96, "height": 64}, "priority": 3, "name": "soak"}' ;;
    budget) echo '{"scene": "builtin:soft-shadow", "render": {"width": 160, "height": 100}, "budget_seconds": 0.5}' ;;
    audit) echo '{"scene": "builtin:patterns", "render": {"width": 80, "height": 60}, "audit": {"pixels": 50, "threshold": 0.05}}' ;;
    benchmark) echo '{"scene": "builtin:spheres", "kind": "benchmark", "render": {"width": 64, "height": 48}, "repeats": 3, "matrix": {"threads": [1, 2]}}' ;;
    accuracy) echo '{"scene": "builtin:spheres", "kind": "accuracy", "render": {"width": 48, "height": 36}, "ladder": {"samples_per_pixel": [1, 4]}, "seeds": 2, "budget_seconds": 5}' ;;
    failing) echo '{"scene": "builtin:room-soft", "render": {"width": 2000, "height": 2000}, "timeout_seconds": 1}' ;;
    invalid) echo '{"scene": "builtin:rom", "render": {"width": 64}}' ;;
    esac
}

# A process may be between two lives: requests that fail then are no fault.
request() { # PATH [CURL-ARGUMENT…]: prints the status
    to=$1
    shift
    curl -s -m 20 -o /dev/null -w '%{http_code}' "$@" "$url$to" 2>/dev/null
}

goes_on() {
    [ -d "$work" ] && [ ! -e "$work/end" ]
}

# Jobs of all kinds, as fast as they are rendered.
submitter() {
    n=0
    while goes_on; do
        for kind in small large target views small budget audit small benchmark accuracy small failing invalid; do
            n=$((n + 1))
            id=$(jobs_json $kind | curl -s -m 20 -H "Idempotency-Key: soak-$n" -H 'Content-Type: application/json' \
                --data-binary @- "$url/v1/jobs" 2>/dev/null | jq -r '.id // empty' 2>/dev/null)
            [ -z "$id" ] || echo $kind >"$work/jobs/$id"
            sleep 0.2
            while goes_on && [ "$(waiting)" -gt 20 ]; do sleep 0.5; done
            goes_on || return
        done
    done
}

waiting() { # prints how many jobs wait
    curl -s -m 20 "$url/metrics" | awk '/^penumbra_jobs\{state="queued"\}/ {n = $2} END {print n + 0}'
}

some_job() { # prints the id of one of the last jobs
    ls -t "$work/jobs" 2>/dev/null | head -n 60 | shuf -n 1
}

# Notes a job before it is removed or cancelled: the answer may be lost with its process.
remover() {
    while goes_on; do
        sleep 3
        id=$(some_job)
        [ -n "$id" ] || continue
        echo "$id" >>"$work/removed"
        case $(shuf -i 1-4 -n 1) in
        1) request "/v1/jobs/$id/cancel" -X POST ;;
        2) request "/v1/jobs/$id?stats=true" -X DELETE ;;
        *) request "/v1/jobs/$id" -X DELETE ;;
        esac >/dev/null
    done
}

reader() {
    while goes_on; do
        id=$(some_job)
        for path in "/v1/jobs/$id" "/v1/jobs/$id/stats" "/v1/jobs/$id/image" "/v1/jobs/$id/image?format=pfm" \
            '/v1/jobs?limit=100' '/v1/jobs?label=of:soak' '/v1/jobs?name=soak' /metrics /readyz '/v1/nothing'; do
            request "$path" >/dev/null
        done
        curl -s -m 1 -o /dev/null "$url/v1/jobs/$id?wait=30" # leaves before the answer
        curl -s -m 1 -o /dev/null "$url/v1/jobs/$id/events"
        curl -s -m 1 -o /dev/null --limit-rate 2k "$url/v1/jobs/$id/image?format=pfm"
    done
}

vanishers() {
    while goes_on; do
        id=$(some_job)
        daemon=$(cat "$work/pid")
        "$load" crowd "${url##*:}" "$(child api)" "/v1/jobs/$id" "/v1/jobs/$id/image?format=pfm" 4 8 >/dev/null 2>&1
        sleep 1
    done
}

child() { # ROLE: the process id
    for pid in $(pgrep -P "$daemon"); do
        [ "$(cat "/proc/$pid/comm" 2>/dev/null)" = "penumbrad-$1" ] && echo "$pid"
    done | head -n 1
}

resident_kib() { # PID
    cat "/proc/$1/status" 2>/dev/null | awk '/^VmRSS:/ {n = $2} END {print n + 0}'
}

files_of() { # PID
    find "/proc/$1/fd" -mindepth 1 -maxdepth 1 2>/dev/null | wc -l
}

kib_of() { # FILE
    stat -c %s "$1" 2>/dev/null | awk '{n = int($1 / 1024)} END {print n + 0}'
}

# Adds a line: seconds; resident KiB of supervisor, api and worker; their descriptors; KiB of the store and of
# its log; jobs in the store.
sample() {
    api=$(child api) worker=$(child work)
    echo "$(($(date +%s) - begun)) $(resident_kib "$daemon") $(resident_kib "$api") $(resident_kib "$worker") \
$(files_of "$daemon") $(files_of "$api") $(files_of "$worker") $(kib_of "$store") $(kib_of "$store-wal") \
$(curl -s -m 20 "$url/metrics" | awk '/^penumbra_jobs\{/ {n += $2} END {print n + 0}')" >>"$work/samples"
}

start() {
    daemon_start --keep-bytes "${keep_mib}M" --keep-jobs $keep_jobs --log-level warn
    echo "$daemon" >"$work/pid"
}

# Kills or restarts something; each turn another.
disturb() { # TURN
    case $(($1 % 4)) in
    0 | 2) kill -KILL "$(child work)" ;;
    1) kill -KILL "$(child api)" ;;
    3)
        daemon_stop
        expect "restart-$1" "$stopped" 0
        start
        ;;
    esac
}

# The median of a column of samples from a second on to another.
median() { # COLUMN FROM TO
    awk -v c="$1" -v from="$2" -v to="$3" '$1 >= from && $1 < to {print $c}' "$work/samples" | sort -n |
        awk '{v[NR] = $1} END {print NR ? v[int((NR + 1) / 2)] : "none"}'
}

most() { # COLUMN FROM TO
    awk -v c="$1" -v from="$2" -v to="$3" '$1 >= from && $1 < to && $c > m {m = $c} END {print m + 0}' "$work/samples"
}

least() { # COLUMN FROM TO
    awk -v c="$1" -v from="$2" -v to="$3" '$1 >= from && $1 < to && (!n++ || $c < m) {m = $c} END {print n ? m : "none"}' \
        "$work/samples"
}

# The median, or the least, of the last third is at most that of the second one, a tenth more, and some.
flat() { # NAME COLUMN SOME median|least
    middle=$($4 "$2" $third $((2 * third))) last=$($4 "$2" $((2 * third)) $((3 * third + 60)))
    echo "$1: $middle, then $last; at most $(most "$2" $third $((3 * third + 60)))"
    expect "$1-is-flat" "$(awk -v a="$middle" -v b="$last" -v some="$3" 'BEGIN {print (b <= 1.1 * a + some)}')" 1
}

begun=$(date +%s)
start
listen=${url#http://} # the clients go on there after a restart
submitter &
clients=$!
remover &
clients="$clients $!"
reader &
clients="$clients $!"
vanishers &
clients="$clients $!"
trap 'kill $clients 2>/dev/null; clean_up' EXIT
turn=0
while [ $(($(date +%s) - begun)) -lt $((3 * third)) ]; do
    sleep 10
    sample
    now=$(($(date +%s) - begun))
    if [ $now -lt $((third - 40)) ]; then
        disturb $turn
        turn=$((turn + 1))
    fi
done
touch "$work/end"
# shellcheck disable=SC2086 # a list of process ids
wait $clients
for _ in $(seq 100); do
    busy=$(curl -s "$url/metrics" | awk '/^penumbra_jobs\{state="(queued|running)"\}/ {n += $2} END {print NR ? n : "unknown"}')
    [ "$busy" = 0 ] && break
    sleep 2
done
expect all-jobs-end "$busy" 0

# What became of every job that was acknowledged. Statistics of removed jobs have an eighth of --keep-bytes. Beyond
# that the oldest are forgotten, and the status is 404: right for the first jobs, as many as were forgotten and those
# that ended in another order than they came.
touch "$work/removed"
ls "$work/jobs" >"$work/ids"
sed "s|^|$work/jobs/|" "$work/ids" | xargs cat >"$work/kinds"
sed "s|^|$url/v1/jobs/|" "$work/ids" | xargs -n 100 curl -s -w '\n' | jq -r '.state // .status' >"$work/states"
expect a-state-of-each-job "$(wc -l <"$work/states")" "$(wc -l <"$work/ids")"
paste -d ' ' "$work/kinds" "$work/states" "$work/ids" | awk -v removed="$work/removed" '
    BEGIN { while ((getline id <removed) > 0) gone[id] = 1 }
    {
        kind[$1 " " $2]++
        if ($2 == "succeeded" || $2 == "410") next
        if ($2 == "cancelled" && gone[$3]) next
        if ($2 == "404" && gone[$3]) next
        if ($2 == "404") { forgotten++; last = NR; next }
        if ($2 == "failed" && $1 == "failing") next
        wrong++
    } END {
        for (k in kind) { print k, kind[k]; if (k ~ / 404$/) all += kind[k] }
        print "forgotten", forgotten + 0
        if (last > all + 100) wrong += forgotten
        print "wrong", wrong + 0
    }' | sort >"$work/became"
cat "$work/became"
expect no-job-lost-or-failed "$(awk '$1 == "wrong" {print $2}' "$work/became")" 0
for kind in small large target views budget audit benchmark accuracy failing; do
    expect "$kind-jobs" "$(grep -q "^$kind succeeded\|^$kind failed\|^$kind 410" "$work/became" && echo some)" some
done
echo "seconds, KiB of supervisor, api, worker, their descriptors, KiB of store and log, jobs:"
cat "$work/samples"
flat supervisor-memory 2 2048 median
flat api-memory 3 8192 median
flat worker-memory 4 16384 median
flat supervisor-files 5 2 least
flat api-files 6 60 least # while the crowd is away
flat worker-files 7 4 least
flat log-size 9 4096 median
flat store-size 8 4096 median
expect jobs-within-keep-jobs "$(most 10 $third $((3 * third + 60)) | awk -v most="$((keep_jobs + 100))" '{print ($1 <= most)}')" 1
expect nothing-damaged "$(curl -s "$url/readyz" | jq -r '.damaged // 0')" 0
expect errors-in-the-log "$(grep -c " error " "$work/log")" 0
finish

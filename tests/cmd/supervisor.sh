#!/bin/sh
# SPDX-License-Identifier: MIT
# Processes that die, hang or are told to end: nothing is lost, nothing is left over.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
"$penumbra" scenes forest | jq 'del(.views)' >scene.json
# A job that takes most of a second with two threads, whatever the machine and the build: long enough
# to be met at work by a look every 20 ms.
set -- --set width=300 --set height=200
"$penumbra" render scene.json "$@" --stats stats.json
set -- "$@" --set samples_per_pixel=$(jq '800 / (.timing.render_ms + 1) | floor + 1' stats.json)
"$penumbra" render scene.json "$@" -o wanted.pfm
running() { # ID: whether some of the job's pixels are committed, or it is at work
    [ "$("$penumbra" list --json --retry 0 | jq -r ".jobs[] | select(.id == \"$1\") | .state")" = running ]
}
start() {
    daemon_start "$@"
    export PENUMBRA_URL="$url"
}
all_gone() { # what a test remembered in $children
    gone $children
}

# The worker is killed in the middle of a job
start
for round in 1 2 3; do
    id=$("$penumbra" submit scene.json "$@")
    within 20 running "$id" || not_ok "the job starts" "$("$penumbra" list)"
    worker=$(child work)
    kill -KILL "$worker"
    check "a killed worker is gone" within 2 gone "$worker"
    check "and replaced" within 5 child work
    check "its leases are released at once" \
        within 5 grep -q "released [1-9].* of the dead worker [0-9a-f]" "$work/log"
    ends "its job succeeds ($round)" 0 "$penumbra" wait "$id"
    "$penumbra" fetch "$id" -o got.pfm
    check "H101: with the same bytes" cmp got.pfm wanted.pfm
done
expect "a job that survived a killed worker is on its first attempt" \
    "$("$penumbra" wait "$id" --json | jq .attempts)" 1

# The api is killed: connections wait for its successor
refused=0
for round in 1 2 3 4 5; do
    api=$(child api)
    kill -KILL "$api"
    within 2 gone "$api" # what it had accepted is broken, what comes from now on waits
    for _ in 1 2 3 4 5; do
        code=$(curl -s -m 20 -o /dev/null -w '%{http_code}' "$url/healthz")
        [ "$code" = 200 ] || refused=$((refused + 1))
    done
done
expect "no connection is refused while the api is replaced" "$refused" 0
id=$("$penumbra" submit scene.json "$@")
kill -KILL "$(child api)"
ends "a client that waits survives that" 0 "$penumbra" wait "$id"

# Each submit is one job, also when the api dies under it
(
    for pause in 0.1 0.1 0.2 0.3 0.5 0.7; do # more and it would be a crash loop, with long pauses
        kill -KILL "$(child api)"
        sleep $pause
    done
) 2>/dev/null &
killer=$!
for i in 1 2 3 4 5 6 7 8 9 10; do
    "$penumbra" submit builtin:spheres --set width=8 --set height=8 --name once --retry 60
done >ids 2>>log
wait $killer
expect "submits to an api that keeps dying" "$(sort -u ids | wc -l | tr -d ' ')" 10
"$penumbra" wait $(cat ids) >ends 2>>log
expect "are a job each" "$("$penumbra" list --json |
    jq '[.jobs[] | select(.name == "once")] | length')" 10
expect "and succeed" "$(grep -c ' succeeded$' ends)" 10

# SIGHUP
echo '{"log_level": "warn"}' >config.json
daemon_stop
: >first
"$build/penumbrad" --listen 127.0.0.1:0 --store "$store" --config config.json \
    --log-file "$work/daemon.log" >first 2>>log &
daemon=$!
within 20 grep -q '^listening on' first
url=$(sed -n 's/^listening on //p' first)
export PENUMBRA_URL="$url"
ends "a daemon with a log file" 0 "$penumbra" list
mv daemon.log old.log
echo '{"log_level": "debug", "threads": 1}' >config.json
worker=$(child work)
kill -HUP "$daemon"
check "SIGHUP opens the log anew" within 5 test -e daemon.log
check "and reads the configuration" within 5 grep -q "configuration read again" daemon.log
check "a worker with other threads takes over" within 5 gone "$worker"
check "for the old one" within 5 child work
echo '{"log_level": "no such"}' >config.json
kill -HUP "$daemon"
check "a wrong configuration changes nothing" within 5 grep -q "the old one stays" daemon.log
ends "and the daemon serves on" 0 "$penumbra" list

# SIGTERM: drained within 10 s, the job goes on with the next start
printf '%s' "$long" >long.json
id=$("$penumbra" submit long.json)
within 20 running "$id" || not_ok "the long job starts" "$("$penumbra" list)"
children="$(child api) $(child work)"
begun=$(date +%s)
kill -TERM "$daemon"
within 2 grep -q draining daemon.log
refusal=$(curl -s -o /dev/null -w '%{http_code}' -H 'Content-Type: application/json' \
    --data-binary '{"scene": "builtin:spheres"}' "$url/v1/jobs")
case $refusal in
503 | 000) ok "a draining daemon takes no jobs" ;; # 000: it has ended by now
*) not_ok "a draining daemon takes no jobs" "$refusal" ;;
esac
wait "$daemon"
expect "a drained daemon ends well" "$?" 0
expect "in time" "$(($(date +%s) - begun < 10))" 1
check "its children are gone" all_gone
daemon=
start
expect "the job is still there" "$("$penumbra" list --json | jq -r ".jobs[0].id")" "$id"
check "and goes on" within 10 running "$id"
ends "until it is cancelled" 0 "$penumbra" cancel "$id"

# The supervisor is killed: the children end, stopped ones too, and the next start goes on
id=$("$penumbra" submit scene.json "$@")
within 20 running "$id" || not_ok "the job starts" "$("$penumbra" list)"
children="$(child api) $(child work)"
kill -KILL "$daemon"
wait "$daemon" 2>/dev/null
check "children of a killed supervisor end within 2 s" within 2 all_gone
daemon=
start
ends "their job succeeds after the next start" 0 "$penumbra" wait "$id"
"$penumbra" fetch "$id" -o got.pfm
check "with the same bytes" cmp got.pfm wanted.pfm
id=$("$penumbra" submit scene.json "$@")
within 20 running "$id" || not_ok "the job starts" "$("$penumbra" list)"
children="$(child api) $(child work)"
kill -STOP $children
kill -KILL "$daemon"
wait "$daemon" 2>/dev/null
check "also if they were stopped" within 2 all_gone
daemon=
start
id=$("$penumbra" submit scene.json "$@")
within 20 running "$id"
children="$(child api) $(child work)"
kill -KILL $children "$daemon"
wait "$daemon" 2>/dev/null
daemon=
start
check "the leases of a daemon killed as a whole are released at once" \
    within 5 grep -q "released [1-9].* of other dead workers" "$work/log"
ends "and its job succeeds" 0 "$penumbra" wait "$id"
"$penumbra" fetch "$id" -o got.pfm
check "with the same bytes" cmp got.pfm wanted.pfm

# A worker that does not answer does not hold up the end
kill -STOP "$(child work)"
children="$(child api) $(child work)"
begun=$(date +%s)
daemon_stop
expect "a stopped worker does not hold up the end" "$(($(date +%s) - begun < 10))" 1
expect "which is a good one" "$stopped" 0
check "nothing is left over" all_gone

# One process alone
"$build/penumbrad" --role worker --store "$store" >worker.out 2>>log &
worker=$!
daemon_start --role api
export PENUMBRA_URL="$url"
expect "the api alone has no children" "$(pgrep -P "$daemon" | wc -l | tr -d ' ')" 0
ends "an api and a worker by themselves do the same" 0 "$penumbra" submit scene.json "$@" -o got.pfm
check "the very same" cmp got.pfm wanted.pfm
expect "a worker alone prints nothing" "$(cat worker.out)" ""
daemon_stop
expect "an api alone ends well" "$stopped" 0
kill -TERM $worker
wait $worker
expect "a worker alone ends well" "$?" 0

finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# Processes of the daemon that are killed, stopped or drained: no job is lost, no process is left over.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
"$penumbra" scenes forest | jq 'del(.views)' >scene.json
# A job that takes more than half a second on any machine and build.
set -- --set width=300 --set height=200
set -- "$@" --set samples_per_pixel=$(samples_lasting 400 scene.json "$@")
"$penumbra" render scene.json "$@" -o wanted.pfm
running() { # ID: whether the job's state is running
    [ "$(curl -s -m 5 "$url/v1/jobs/$1" | jq -r .state)" = running ]
}
start() {
    daemon_start "$@"
    export PENUMBRA_URL="$url"
}
has_begun() { # ID: whether the job is running, or has succeeded already
    case $(curl -s -m 5 "$url/v1/jobs/$1" | jq -r .state) in
    running | succeeded) ;;
    *) return 1 ;;
    esac
}
# start_held ARGUMENT…: submits the job of this script and stops its worker while the job is running, which it
# then stays. Sets $id and $worker. A job that has ended before its worker was stopped is followed by another.
start_held() {
    for _ in 1 2 3 4 5 6 7 8; do
        id=$("$penumbra" submit scene.json "$@")
        within has_begun "$id"
        worker=$(child work)
        kill -STOP "$worker"
        running "$id" && return
        kill -CONT "$worker"
    done
    not_ok "the job starts" "$("$penumbra" list)"
}
released() { # COUNT: whether the leases of dead workers were released so many times
    [ "$(grep -c "released [1-9].* of the dead worker [0-9a-f]" "$work/log")" -ge "$1" ]
}
all_gone() { # whether the processes in $children are gone
    gone $children
}

# The worker is killed in the middle of a job
start
for round in 1 2 3; do
    start_held "$@"
    kill -KILL "$worker"
    check "a killed worker is gone" within gone "$worker"
    check "another worker takes its place" within child work
    check "its leases are released at once" within released "$round"
    exits "its job succeeds ($round)" 0 "$penumbra" wait "$id"
    "$penumbra" fetch "$id" -o got.pfm
    check "H101: its picture has the same bytes" cmp got.pfm wanted.pfm
done
expect "a job that survived a killed worker is on its first attempt" \
    "$("$penumbra" wait "$id" --json | jq .attempts)" 1

# The api is killed: connections wait for its successor
refused=0
for round in 1 2 3 4 5; do
    api=$(child api)
    kill -KILL "$api"
    within gone "$api" # connections that it had accepted are broken, new ones wait
    for _ in 1 2 3 4 5; do
        code=$(curl -s -m 20 -o /dev/null -w '%{http_code}' "$url/healthz")
        [ "$code" = 200 ] || refused=$((refused + 1))
    done
done
expect "no connection is refused while the api is replaced" "$refused" 0
id=$("$penumbra" submit scene.json "$@")
kill -KILL "$(child api)"
exits "a client that waits goes on when the api process is killed" 0 "$penumbra" wait "$id"

# Each submit makes one job, also if the api process dies meanwhile
(
    for pause in 0.1 0.1 0.2 0.3 0.5 0.7; do # more kills would make the supervisor's pauses long
        kill -KILL "$(child api)"
        sleep $pause
    done
) 2>/dev/null &
killer=$!
for i in 1 2 3 4 5 6 7 8 9 10; do
    "$penumbra" submit builtin:spheres --set width=8 --set height=8 --name once --retry 60
done >ids 2>>log
wait $killer
expect "ten submits to an api process that keeps dying are acknowledged" "$(sort -u ids | wc -l | tr -d ' ')" 10
"$penumbra" wait $(cat ids) >ends 2>>log
expect "each is one job" "$("$penumbra" list --json |
    jq '[.jobs[] | select(.name == "once")] | length')" 10
expect "all succeed" "$(grep -c ' succeeded$' ends)" 10

# SIGHUP
echo '{"log_level": "warn"}' >config.json
daemon_stop
: >first
"$build/penumbrad" --listen 127.0.0.1:0 --store "$store" --config config.json \
    --log-file "$work/daemon.log" >first 2>>log &
daemon=$!
within grep -q '^listening on' first
url=$(sed -n 's/^listening on //p' first)
export PENUMBRA_URL="$url"
exits "a daemon with a log file" 0 "$penumbra" list
mv daemon.log old.log
echo '{"log_level": "debug", "threads": 1}' >config.json
worker=$(child work)
kill -HUP "$daemon"
check "SIGHUP opens the log anew" within test -e daemon.log
check "SIGHUP reads the configuration again" within grep -q "configuration read again" daemon.log
check "the worker with the old number of threads ends" within gone "$worker"
check "another worker takes its place" within child work
echo '{"log_level": "no such"}' >config.json
kill -HUP "$daemon"
check "a wrong configuration changes nothing" within grep -q "the old one stays" daemon.log
exits "and the daemon goes on serving" 0 "$penumbra" list

# SIGTERM drains within 10 s; the next daemon continues the job
printf '%s' "$long" >long.json
id=$("$penumbra" submit long.json)
within running "$id" || not_ok "the long job starts" "$("$penumbra" list)"
children="$(child api) $(child work)"
begun=$(now_ms)
kill -TERM "$daemon"
# The log has it before the api process knows, which /readyz then says, unless it has already ended (000).
drains() {
    case $(curl -s -m 20 -o ready.json -w '%{http_code}' "$url/readyz") in
    000) ;;
    *) jq -r .detail ready.json | grep -q draining ;;
    esac
}
within drains || not_ok "the api says that it drains" "$(cat ready.json)"
refusal=$(curl -s -o /dev/null -w '%{http_code}' -H 'Content-Type: application/json' \
    --data-binary '{"scene": "builtin:spheres"}' "$url/v1/jobs")
case $refusal in
503 | 000) ok "a draining daemon takes no jobs" ;; # 000: it has already ended
*) not_ok "a draining daemon takes no jobs" "$refusal" ;;
esac
wait "$daemon"
expect "a drained daemon ends with exit code 0" "$?" 0
timed "within 10 s" $(($(now_ms) - begun)) 10000
check "its children are gone" within all_gone
daemon=
start
expect "the next daemon lists the job" "$("$penumbra" list --json | jq -r ".jobs[0].id")" "$id"
check "and continues it" within running "$id"
exits "the job can be cancelled" 0 "$penumbra" cancel "$id"

# The supervisor is killed: its children end, even stopped ones, and the next daemon continues
start_held "$@"
children="$(child api) $worker"
kill -CONT "$worker"
kill -KILL "$daemon"
wait "$daemon" 2>/dev/null
begun=$(now_ms)
check "children of a killed supervisor end" within all_gone
timed "within 2 s" $(($(now_ms) - begun)) 2000
daemon=
start
exits "the next daemon completes their job" 0 "$penumbra" wait "$id"
"$penumbra" fetch "$id" -o got.pfm
check "its picture has the same bytes" cmp got.pfm wanted.pfm
start_held "$@"
children="$(child api) $worker"
kill -STOP $children
kill -KILL "$daemon"
wait "$daemon" 2>/dev/null
check "stopped children of a killed supervisor end, too" within all_gone
daemon=
start
start_held "$@"
# All are stopped first, so that none sees another one die. A lease is released once the worker's lock is,
# which the kernel does when it has taken the process apart.
children="$(child api) $worker"
kill -STOP "$daemon" $children
kill -KILL "$daemon" $children
wait "$daemon" 2>/dev/null
check "the whole daemon is killed" within all_gone
daemon=
start
check "the leases of a daemon killed as a whole are released at once" \
    within grep -q "supervisor.* released [1-9].* of dead workers" "$work/log"
exits "its job succeeds" 0 "$penumbra" wait "$id"
"$penumbra" fetch "$id" -o got.pfm
check "its picture has the same bytes" cmp got.pfm wanted.pfm

# A stopped worker does not hold up a drain
kill -STOP "$(child work)"
children="$(child api) $(child work)"
begun=$(now_ms)
daemon_stop
timed "a drain ends within 10 s although the worker is stopped" $(($(now_ms) - begun)) 10000
expect "it ends with exit code 0" "$stopped" 0
check "no child is left over" within all_gone

finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# Daemons that only serve (--role api) or only render (--role worker), on one store: each is a supervisor
# and its process.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
worker_start() { # ARGUMENT…: adds to $workers, the supervisors
    "$build/penumbrad" --role worker --store "$store" --threads 1 "$@" >>worker.out 2>>log &
    workers="$workers $!"
}
workers_end() { # NAME: all of them end by themselves, with exit code 0
    codes=
    # shellcheck disable=SC2086 # process ids
    within gone $workers
    for one in $workers; do
        wait "$one"
        codes="$codes $?"
    done
    expect "$1" "$codes" "$(echo "$workers" | sed 's/[0-9][0-9]*/0/g')"
    workers=
}
kill_workers() { # what is left of them, if the script ends early
    # shellcheck disable=SC2086 # process ids
    [ -z "$workers" ] || kill $workers
    clean_up
}
workers=
trap kill_workers EXIT
state() { # ID: its state and attempts
    curl -s "$url/v1/jobs/$1" | jq -r '"\(.state) \(.attempts)"'
}
job() { # NAME MEMBERS: submits a job; sets $id
    submit "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 64, \"height\": 48}, \"name\": \"$1\"$2}"
    id=${job##*/}
}

# What a role cannot do
exits "a worker does not listen" 2 "$build/penumbrad" --role worker --listen 127.0.0.1:0
prints "and the message says what to write" stderr "write --role worker alone, or --role api with --listen"
exits "nor by the environment" 2 env PENUMBRA_LISTEN=127.0.0.1:0 "$build/penumbrad" --role worker
for role in api all; do
    exits "one that serves does not end without work: $role" 2 "$build/penumbrad" --role $role --until-idle 1
    prints "and the message says which role does" stderr "only --role worker ends without work"
done

# One of the two processes alone makes no store
exits "a worker alone does not start without a store" 4 "$build/penumbrad" --role worker --store new/typo.db
prints "and says why" stderr "new/typo.db: there is no store"
exits "nor does an api alone" 4 "$build/penumbrad" --role api --listen 127.0.0.1:0 --store new/typo.db
check "and no folder is made" test ! -e new

daemon_start # makes the store
daemon_stop
daemon_start --role api
export PENUMBRA_URL="$url"
expect "--role api has an api process and no other" "$(pgrep -P "$daemon")" "$(child api)"
api=$(child api)
kill -KILL "$api"
within gone "$api"
expect "no connection is refused while it is replaced" \
    "$(curl -s -m 20 -o /dev/null -w '%{http_code}' "$url/healthz")" 200
within curl -sf "$url/readyz"

# A scene that crashes its worker fails alone, whichever supervisor's worker it meets
export PENUMBRA_TEST_FAULT=segv@3,5@bad
job bad ', "priority": 100, "max_attempts": 2'
bad=$id
job good ''
worker_start --until-idle 1
worker_start --until-idle 1
workers_end "--until-idle ends workers once there is no work"
unset PENUMBRA_TEST_FAULT
expect "a job that crashes its workers fails after max_attempts" "$(state "$bad")" "failed 2"
expect "after as many crashes" "$(grep -c 'the worker process .* starting it again' log)" 2
expect "another succeeds on its first attempt" "$(state "$id")" "succeeded 1"
forget_injected_segv

# A worker that is killed, and one that is drained
"$penumbra" render builtin:forest --set width=80 --set height=60 -o wanted.pfm
worker_start
within pgrep -P "${workers# }" -x penumbrad-work
worker=$(pgrep -P "${workers# }" -x penumbrad-work)
expect "--role worker has a worker process and no other" "$(pgrep -P "${workers# }")" "$worker"
inodes=$(readlink /proc/"${workers# }"/fd/* "/proc/$worker/fd"/* | sed -n 's/^socket:.\([0-9]*\).$/\1/p')
expect "and no socket of a network" "$(awk '{ print $10 }' /proc/net/tcp /proc/net/tcp6 | grep -c -wF "$inodes")" 0
expect "and the store's address in its environment alone" \
    "$(grep -a -c "$store" "/proc/$worker/cmdline" "/proc/$worker/environ" | sed 's/.*://' | tr '\n' ' ')" "0 1 "
kill -KILL "$worker"
exits "a job is rendered by the next worker process" 0 "$penumbra" submit builtin:forest --set width=80 \
    --set height=60 -o got.pfm
check "its picture has the same bytes" cmp got.pfm wanted.pfm
kill -TERM "${workers# }"
workers_end "SIGTERM drains a worker"
expect "a worker prints nothing" "$(cat worker.out)" ""
finish

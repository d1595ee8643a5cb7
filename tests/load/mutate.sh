#!/bin/sh
# SPDX-License-Identifier: MIT
# Mutated requests against a daemon that is built with sanitizers. `make mutate` runs it.
#   mutate.sh BUILD MUTATE      the environment may set MINUTES (10), PEN_SEED
# In the first half of the time there are no tokens, and the requests name a job that has a picture. In the
# second half there are tokens, and the job never ends, because there is no worker.
mutate=$2
. "$(dirname "$0")/../e2e/lib.sh"
seconds=$((${MINUTES:-10} * 30))
seed=${PEN_SEED:-$(date +%s)}
echo "seed $seed"
limits='--max-seconds 5 --max-pixels 100000 --max-queue 200 --keep-jobs 200'

run() { # NAME [TOKEN]: mutated requests, with $job
    processes=$(pgrep -P "$daemon")
    "$mutate" "${url##*:}" "$seconds" "$seed" "${job##*/}" "${2:-pen_x}"
    expect "$1-is-alive" "$?" 0
    expect "$1-no-process-ended" "$(pgrep -P "$daemon")" "$processes"
}

# shellcheck disable=SC2086 # words
daemon_start $limits
submit "$small"
call "$job?wait=60"
run open
daemon_stop

token=$("$build/penumbrad" token add load --scope admin --tokens "$work/tokens")
daemon_start --role api --tokens "$work/tokens"
submit "$small" -H "Authorization: Bearer $token"
run with-tokens "$token"
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# The reader of standard error may stop. Requests are still answered, and the log later reports the lines that
# it lost.
. "$(dirname "$0")/lib.sh"

# The reader reads nothing until it is told to.
mkfifo "$work/errors"
sh -c 'while [ ! -e "$1/go" ]; do sleep 0.1; done; exec cat >"$1/read"' reader "$work" <"$work/errors" &
reader=$!
ln -s errors "$work/log" # where daemon_start sends standard error
daemon_start --log-level debug
curl -s -m "$hang" -o /dev/null -H "X-Pad: x" "$url/healthz?$(printf '%300s' '' | tr ' ' 'a')#[1-2000]"
expect requests-are-answered "$?" 0
call /healthz
expect alive "$status" 200
touch "$work/go"
within grep -q 'lines of the log were lost' "$work/read"
expect losses-are-told "$(grep -c 'lines of the log were lost' "$work/read")" 1
daemon_stop
wait "$reader"
if ! grep -q 'api\[.*ended' "$work/read"; then
    # A daemon that is halted for longer than the second that it gives its last lines loses them: once more.
    cat "$work/errors" >>"$work/read" &
    reader=$!
    daemon_start
    daemon_stop
    wait "$reader"
fi
expect last-line-was-written "$(grep -c 'api\[.*ended' "$work/read")" 1
mv "$work/read" "$work/log"
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# What is kept of long heads: little once their requests are answered, 48 MiB of those that wait, and
# nothing when the clients have closed.
. "$(dirname "$0")/lib.sh"
. "$(dirname "$0")/../load/lib.sh"
ulimit -n "$(ulimit -Hn)"
[ "$(ulimit -n)" = unlimited ] || [ "$(ulimit -n)" -ge 4096 ] || {
    echo "skipped: needs 4096 open files"
    exit 77
}
if nm "$build/penumbrad" | grep -qE '__(asan|tsan)_init'; then
    echo "skipped: sanitizers keep freed memory"
    exit 77
fi
daemon_start
for child in $(pgrep -P "$daemon"); do
    [ "$(cat "/proc/$child/comm")" = penumbrad-api ] && api=$child
done
python3 tests/e2e/heads.py "${url##*:}" "$api" "$patience" >"$work/values"
cat "$work/values"
below unread-kib 16384
below unread-closed-kib 3072
below unsent-kib 98304
below unsent-closed-kib 8192
call /healthz
expect alive "$status" 200
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# The wall clock is set back by two hours while a job runs, and then three days ahead. The durations of the
# job are true, and its picture is not removed for its age. Needs Debian's faketime.
. "$(dirname "$0")/lib.sh"
if ! command -v faketime >/dev/null; then
    skip command-faketime "what a clock that jumps does to jobs"
    exit 77
fi
case $build in
*san*)
    skip plain-build "a sanitizer's library must be the first one that is loaded"
    exit 77
    ;;
esac
echo +0 >"$work/clock"
export LD_PRELOAD="$(ls /usr/lib/*/faketime/libfaketime.so.1)" FAKETIME_TIMESTAMP_FILE="$work/clock" \
    FAKETIME_NO_CACHE=1 DONT_FAKE_MONOTONIC=1 FAKETIME_DONT_FAKE_MONOTONIC=1
daemon_start --keep-days 1
unset LD_PRELOAD

noted() { # NAME: housekeeping has noted a time under this name
    python3 -c 'import sqlite3, sys
store = sqlite3.connect("file:%s?mode=ro" % sys.argv[1], uri=True)
sys.exit(not store.execute("SELECT 1 FROM meta WHERE name = ? AND CAST(value AS INTEGER) > 0", (sys.argv[2],)).fetchone())' \
        "$store" "$1"
}
began() {
    call "$job"
    [ "$(body .state)" = running ]
}
within noted purged_ms || not_ok housekeeping "there was none"
begun=$(date +%s)
submit '{"scene": "builtin:gloss", "render": {"width": 120, "height": 90, "samples_per_pixel": 16}}'
within began || not_ok job-begins "it is $(body .state)"
echo -2h >"$work/clock"
call "$job?wait=60"
expect job-succeeds "$(body .state)" succeeded
call "$job/stats"
most=$((($(date +%s) - begun + 1) * 1000))
expect the-clock-was-set-back-and-total-is-true \
    "$(body ".timing | .total_ms >= .queue_ms + .render_ms and .queue_ms >= 0 and .total_ms < $most")" true

echo +3d >"$work/clock"
within noted ages_from_ms || not_ok jump-is-noted "it is not"
call "$job/image"
expect a-picture-that-is-seconds-old-is-kept "$status" 200
finish

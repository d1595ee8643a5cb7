#!/bin/sh
# SPDX-License-Identifier: MIT
# Event streams of a daemon: many at once, and one that is resumed from the next api process.
. "$(dirname "$0")/lib.sh"
daemon_start

api_pid() {
    for child in $(pgrep -P "$daemon"); do
        [ "$(cat "/proc/$child/comm")" = penumbrad-api ] && echo "$child"
    done
}

submit "$long"
expect submitted "$status" 202
has_progress() {
    call "$job"
    [ "$(body .progress.done)" -gt 0 ]
}
within has_progress
python3 tests/e2e/events.py "$url" "$job" "$(api_pid)" "$hang" "${PEN_TIMED:-}" >"$work/many"
expect many-listeners-exit "$?" 0
while read -r line; do
    case $line in
    'ok '*) ok "${line#ok }" ;;
    'not ok '*) not_ok "$(echo "${line#not ok }" | cut -d: -f1)" "${line#*: }" ;;
    *) echo "$line" ;;
    esac
done <"$work/many"

# After the api process is killed, a listener resumes its stream from the next api process.
submit "$long"
curl -sN -m "$hang" "$url$job/events" >"$work/cut" 2>/dev/null &
listener=$!
within grep -q '^event: tile' "$work/cut"
kill -KILL "$(api_pid)"
wait "$listener"
# An event ends with an empty line; a listener ignores the last one if it was cut
awk '{ event = event $0 "\n" } $0 == "" { printf "%s", event; event = "" }' "$work/cut" >"$work/first"
last=$(sed -n 's/^id: //p' "$work/first" | tail -n 1)
expect first-stream-has-an-id "$([ -n "$last" ] && echo yes)" yes
is_ready() {
    call /readyz
    [ "$status" = 200 ]
}
within is_ready
sleep 1 # time for some commits
curl -sN -m "$hang" -H "Last-Event-ID: $last" "$url$job/events" >"$work/second" 2>/dev/null &
listener=$!
within grep -q '^event: progress' "$work/second"
call "$job/cancel" -X POST
wait "$listener"
expect second-stream-ends "$?" 0
expect last-event-is-the-cancelled-state "$(sed -n 's/^event: //p' "$work/second" | tail -n 1) $(sed -n 's/^data: //p' "$work/second" | tail -n 1 | jq -r .state)" "state cancelled"
# The streams sent each rectangle once, and together all committed pixels.
sed -n 's/^data: \({"view".*\)/\1/p' "$work/first" "$work/second" >"$work/tiles"
expect no-tile-twice "$(sort "$work/tiles" | uniq -d | wc -l | tr -d ' ')" 0
call "$job"
expect no-tile-missed "$(jq -s 'map(.width * .height) | add' "$work/tiles")" "$(body .progress.done)"
finish

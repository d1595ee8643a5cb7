#!/bin/sh
# SPDX-License-Identifier: MIT
# Watches a job until it has ended, one line per event; goes on where it was when the connection
# breaks. To look on without a script: curl -N http://127.0.0.1:8080/v1/jobs/ID/events
#   events.sh /v1/jobs/ID
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
job=$1
last=$(mktemp)
trap 'rm -f "$last"' EXIT

while :; do
    curl -sSN -f -H "Last-Event-ID: $(cat "$last")" "$url$job/events" |
        while IFS=' ' read -r key value; do
            case $key in
            event:) type=$value ;;
            id:) id=$value ;;
            data:)
                printf '%s' "$value" | jq -r --arg type "$type" '
                    if $type == "tile" then "\(.view): \(.width)x\(.height) pixels at \(.x),\(.y)"
                    else "\(.state) \(100 * .progress.fraction | floor) %" end'
                echo "$id" >"$last"
                ;;
            esac
        done
    # The stream ends after the job's last state; asked again, a client that knows it gets a 204.
    case $(curl -sS -o /dev/null -w '%{http_code}' -I -H "Last-Event-ID: $(cat "$last")" "$url$job/events") in
    204) exit 0 ;;
    200) sleep 2 ;;
    *) exit 1 ;;
    esac
done

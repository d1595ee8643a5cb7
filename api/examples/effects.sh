#!/bin/sh
# SPDX-License-Identifier: MIT
# What each effect of a scene costs: effects.sh PAGE. Leaves a page with pictures there, and prints a
# line for each effect: its milliseconds, their share of the whole, and how much it changes the picture.
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
page=$1
job=$(curl -sS --fail-with-body -H 'Content-Type: application/json' "$url/v1/jobs" -d '{
  "scene": "builtin:glass", "kind": "effects", "name": "bill", "repeats": 3,
  "render": {"width": 120, "height": 90}}' | jq -r .id)
state=queued
while [ "$state" = queued ] || [ "$state" = running ]; do
    state=$(curl -sS "$url/v1/jobs/$job?wait=60" | jq -r .state)
done
[ "$state" = succeeded ] || { curl -sS "$url/v1/jobs/$job" | jq .error; exit 1; }
curl -sS "$url/v1/jobs/$job/report" -o "$page"
curl -sS "$url/v1/jobs/$job/report" -H 'Accept: application/json' |
    jq -r '.rows[1:][] | (if .cost_ms then "\(.cost_ms) ms \(100 * .cost_share | round) %"
        else "below \(.cost_below_ms // "?") ms" end) as $cost | "\(.without) \($cost) RMSE \(.rmse)"'

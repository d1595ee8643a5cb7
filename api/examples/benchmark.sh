#!/bin/sh
# SPDX-License-Identifier: MIT
# Times a scene under several settings: benchmark.sh FOLDER. Leaves the report there as
# report.html, report.json, report.csv and report.md, and prints each row's speed-up.
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
folder=$1
job=$(curl -sS --fail-with-body -H 'Content-Type: application/json' "$url/v1/jobs" -d '{
  "scene": "builtin:room", "kind": "benchmark", "name": "table",
  "render": {"width": 50, "height": 70},
  "matrix": {"accelerator": ["none", "auto"], "threads": [1, 0]},
  "repeats": 3, "warmup": 1, "baseline": {"accelerator": "none", "threads": 1}}' | jq -r .id)
state=queued
while [ "$state" = queued ] || [ "$state" = running ]; do
    state=$(curl -sS "$url/v1/jobs/$job?wait=60" | jq -r .state)
done
[ "$state" = succeeded ] || { curl -sS "$url/v1/jobs/$job" | jq .error; exit 1; }
curl -sS "$url/v1/jobs/$job/report" -o "$folder/report.html"
curl -sS "$url/v1/jobs/$job/report" -H 'Accept: application/json' -o "$folder/report.json"
curl -sS "$url/v1/jobs/$job/report" -H 'Accept: text/csv' -o "$folder/report.csv"
curl -sS "$url/v1/jobs/$job/report" -H 'Accept: text/markdown' -o "$folder/report.md"
jq -r '.rows[] | "\(.settings.accelerator) \(.threads) \(.median_ms) ms \(.speedup)"' "$folder/report.json"

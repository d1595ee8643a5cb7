#!/bin/sh
# SPDX-License-Identifier: MIT
# Which effects a scene calls for and why, and what a render will take: explain.sh [SCENE.json].
# Prints the reasons, then the rays and the time that are expected, each with its interval.
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
if [ $# -gt 0 ]; then body=@$1; else body='{"scene": "builtin:glass"}'; fi
curl -sS --fail-with-body -H 'Content-Type: application/json' "$url/v1/explain" --data-binary "$body" |
    jq -r '(.effects[] | "\(.name): \(.because)"),
           "rays: \(.rays.total | "\(.expected), \(.low) to \(.high)")",
           "time: \(.time_ms | "\(.expected) ms, \(.low) to \(.high)")"'

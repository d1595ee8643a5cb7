#!/bin/sh
# SPDX-License-Identifier: MIT
# Waits until a job has ended and prints its state.
#   wait.sh /v1/jobs/ID
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}

state=queued
while [ "$state" = queued ] || [ "$state" = running ]; do
    state=$(curl -sS --fail-with-body "$url$1?wait=60" | jq -r .state)
done
echo "$state"

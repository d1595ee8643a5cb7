#!/bin/sh
# SPDX-License-Identifier: MIT
# Cancels a job, then removes it.
#   cancel.sh /v1/jobs/ID
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}

curl -sS --fail-with-body -X POST "$url$1/cancel" | jq -r .state
curl -sS --fail-with-body -X DELETE "$url$1"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Submits so that it may be repeated when the answer got lost: with one Idempotency-Key there is
# one job, however often the request arrives.
#   retry.sh [KEY]
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
key=${1:-$(cat /proc/sys/kernel/random/uuid)}

curl -sS --fail-with-body --retry 5 --retry-connrefused "$url/v1/jobs" \
    -H "Idempotency-Key: $key" \
    -d '{"scene": "builtin:spheres", "render": {"width": 160, "height": 120}}' | jq -r .links.self

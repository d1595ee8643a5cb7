#!/bin/sh
# SPDX-License-Identifier: MIT
# Checks a scene without submitting it; prints what is wrong, one line per place.
#   validate.sh SCENE.json
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}

answer=$(curl -sS -w '\n%{http_code}' -H 'Content-Type: application/json' --data-binary "@$1" \
    "$url/v1/validate")
status=$(printf '%s' "$answer" | tail -n 1)
document=$(printf '%s' "$answer" | sed '$d')
if [ "$status" = 200 ]; then
    echo "valid"
    exit 0
fi
printf '%s' "$document" | jq -r '.detail, (.errors[]? | "  " +
    (if .pointer then .pointer else "\(.line):\(.column)" end) + ": " + .detail)'
exit 1

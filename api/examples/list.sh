#!/bin/sh
# SPDX-License-Identifier: MIT
# Lists all jobs, newest first, page by page.
#   list.sh [STATE]
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
query="limit=100${1:+&state=$1}"
cursor=

while :; do
    page=$(curl -sS --fail-with-body -G "$url/v1/jobs?$query" ${cursor:+--data-urlencode "cursor=$cursor"})
    printf '%s' "$page" | jq -r '.jobs[] | [.id, .state, .name // "-"] | @tsv'
    cursor=$(printf '%s' "$page" | jq -r '.next // ""')
    [ -n "$cursor" ] || break
done

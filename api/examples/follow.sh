#!/bin/sh
# SPDX-License-Identifier: MIT
# Follows a job until it has ended: each request waits at the daemon until the revision differs
# from the one it names, so there is no polling interval to choose.
#   follow.sh /v1/jobs/ID
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
job=$1
etag='"0"'

while :; do
    answer=$(curl -sS -w '\n%{http_code} %header{etag}' -H "If-None-Match: $etag" "$url$job?wait=30")
    last=$(printf '%s' "$answer" | tail -n 1)
    etag=${last#* }
    case ${last%% *} in
    304) continue ;; # nothing new within 30 s
    200) ;;
    *)
        printf '%s\n' "$answer" >&2
        exit 1
        ;;
    esac
    printf '%s' "$answer" | head -n 1 | jq -c '{state, progress}'
    state=$(printf '%s' "$answer" | head -n 1 | jq -r .state)
    case $state in
    succeeded) exit 0 ;;
    failed | cancelled) exit 1 ;;
    esac
done

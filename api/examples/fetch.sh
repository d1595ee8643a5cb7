#!/bin/sh
# SPDX-License-Identifier: MIT
# Fetches the picture and the statistics of a job that has succeeded. Run again, it transfers the
# picture only if it has changed.
#   fetch.sh /v1/jobs/ID PICTURE.png STATS.json
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
job=$1 picture=$2 stats=$3

curl -sS --fail-with-body --etag-compare "$picture.etag" --etag-save "$picture.etag" \
    -o "$picture" "$url$job/image"
curl -sS --fail-with-body -o "$stats" "$url$job/stats"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Submits a built-in scene, small, and prints where the job is.
#   submit.sh [SCENE]
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}
scene=${1:-spheres}

curl -sS --fail-with-body -o /dev/null -w '%header{location}\n' "$url/v1/jobs" \
    -d '{"scene": "builtin:'"$scene"'", "name": "example", "render": {"width": 160, "height": 120}}'

#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon does what api/openapi.yaml says: for each operation every documented status is really
# given, with a documented type of body and the fields that are required, and none that is not
# documented.
. "$(dirname "$0")/lib.sh"
daemon_start
python3 "$(dirname "$0")/openapi.py" "$url" >"$work/said"
code=$?
grep -E '^(not )?ok ' "$work/said"
checks=$(grep -cE '^(not )?ok ' "$work/said")
failures=$(grep -c '^not ok ' "$work/said")
expect openapi-examined "$code" 0
finish

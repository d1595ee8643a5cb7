#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon answers as api/openapi.yaml documents: openapi.py provokes every documented status of every
# operation, and checks type and members of each answer.
. "$(dirname "$0")/lib.sh"
daemon_start
python3 "$(dirname "$0")/openapi.py" "$url" >"$work/output"
code=$?
grep -E '^(not )?ok ' "$work/output"
checks=$(grep -cE '^(not )?ok ' "$work/output")
failures=$(grep -c '^not ok ' "$work/output")
expect openapi-examined "$code" 0
finish

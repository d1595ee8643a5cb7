#!/bin/sh
# SPDX-License-Identifier: MIT
# The edits of mutants.sh fit the present source, so that `make mutants` can judge each of them.
. "$(dirname "$0")/../e2e/lib.sh"
cd "$(dirname "$0")/../.." || exit 1
sh tests/property/mutants.sh "$build" --edits >"$work/edits" 2>&1
status=$?
grep -v 'fit the source' "$work/edits"
expect "the edits of mutants.sh fit the source" "$status" 0
finish

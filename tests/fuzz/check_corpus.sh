#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the initial inputs of the fuzz targets, and the inputs that once broke a target: check_corpus.sh BUILD
. "$(dirname "$0")/../e2e/lib.sh"
for target in tests/fuzz/fuzz_*.c; do
    target=$(basename "${target#*fuzz_}" .c)
    # shellcheck disable=SC2046
    files=$(find $(sh tests/fuzz/corpora.sh "$target") -type f ! -name '*.expect' | sort)
    # shellcheck disable=SC2086
    if "$build/tests/fuzz/replay_$target" $files >"$work/output" 2>&1; then
        ok "$target: $(wc -l <"$work/output") inputs"
    else
        not_ok "$target" "$(tail -n 3 "$work/output")"
    fi
done
finish

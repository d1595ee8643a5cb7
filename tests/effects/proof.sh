#!/bin/sh
# SPDX-License-Identifier: MIT
# Proves that a scene pays for its own effects alone, for `make effects-proof`:
#   tests/effects/proof.sh BUILD "INSTRUCTION-SET…"
# src/shade/KERNELS.md says what each part shows. Runs all parts; exit 1 if one fails.
set -u
build=${1:-build}
isas=${2:-avx2}
cd "$(dirname "$0")/../.." || exit 1
failed=
part() { # TITLE COMMAND…
    echo "== $1"
    title=$1
    shift
    begun=$(date +%s)
    if "$@"; then
        echo "   ok, $(($(date +%s) - begun)) s"
    else
        echo "   FAILED"
        failed="$failed, $title"
    fi
}
PEN_PROOF=full
export PEN_PROOF
part "rays of absent effects" "$build/tests/effects/test_rays"
part "frames by every superset of effects" "$build/tests/effects/test_masks"
part "weak secondary rays call for no effect" "$build/tests/scene/test_effects"
part "the disassembly of kernels" sh tests/effects/disassembly.sh "$build" $isas
part "instructions, against kernels stripped by hand" sh tests/effects/instructions.sh "$build"
if [ -n "$failed" ]; then
    echo "failed: ${failed#, }"
    exit 1
fi
echo "all effects proven"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Pixel kernels contain the code of their effects and of no others. The stripped kernels, whose instructions
# `make effects-proof` counts, give the same bits. That proof also reads the block kernels.
case ${1:-build} in
*asan* | *tsan*)
    echo "skipped: plain-build: kernels with sanitizers are not those that are installed"
    exit 77
    ;;
esac
. "$(dirname "$0")/../e2e/lib.sh"
cd "$(dirname "$0")/../.." || exit 1
# Without -g nothing says which source an instruction is of.
if command -v objdump >/dev/null && objdump -h "$build/src/shade/pixel_kernels.o" | grep -q debug_line; then
    sh tests/effects/disassembly.sh "$build" >"$work/kernels" 2>&1
    expect "kernels show their effects and no others" "$?" 0
    grep -E ' (has|lacks): ' "$work/kernels"
    # The check finds a marker that is not where it should be.
    sed 's/^both sky line/both ambient line/' tests/effects/markers.txt >"$work/markers"
    MARKERS=$work/markers sh tests/effects/disassembly.sh "$build" >"$work/kernels" 2>&1
    expect "the check finds what a kernel should not lack" "$?" 1
else
    skip command-objdump "which source the instructions of kernels are of"
fi
if grep -qw avx2 /proc/cpuinfo 2>/dev/null; then
    for set in none hard soft mirror; do
        "$build/tests/effects/instructions" "$set" scenes/spheres.json
        expect "the stripped kernel $set gives the same bits" "$?" 0
    done
else
    skip avx2 "the stripped kernels"
fi
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# H104, as `make stability` judges it: films do not depend on glibc's choice for the processor. The other rows
# of determinism are in test_property; rows that need other builds are in matrix.sh.
case ${1:-build} in
*asan* | *tsan*)
    echo "skipped: plain-build: test_golden renders the same films, and sanitizers see nothing new of glibc's choice"
    exit 77
    ;;
esac
. "$(dirname "$0")/../e2e/lib.sh"
cd "$(dirname "$0")/../.." || exit 1
films=$build/tests/property/films
# libpenumbra calls no function of which glibc has several, as the last line checks; so some films by one
# instruction set stand for all.
parts="spheres gloss-floor lens-glass patterns soft-spot-grid" isas=base
[ "${PEN_CASES:-}" != all ] || parts='' isas="avx512 avx2 base"
# shellcheck disable=SC2086
"$films" $parts >"$work/plain" 2>&1
expect "H104: films are those of the table" "$?" 0
for isa in $isas; do
    # shellcheck disable=SC2086
    PENUMBRA_ISA=$isa GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4 "$films" $parts >"$work/masked" 2>&1
    expect "H104: with glibc's AVX2 and FMA masked off, by $isa" "$?" 0
    expect "H104: and so are the values they are rounded from" \
        "$(diff "$work/plain" "$work/masked" | head -c 600)" ""
done
expect "H104: no libm in the renderer" "$(sh deploy/libm.sh "$build/libpenumbra.a")" ""
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# Prints the symbols of libm that an archive needs, except those with one right answer: sqrt, fma and
# rounding. The others differ between glibc's variants for different processors (row H104).
#   deploy/libm.sh build/libpenumbra.a
set -eu
libm=$(gcc -print-file-name=libm.so.6)
allowed='(sqrt|fma|floor|ceil|trunc|round|rint|nearbyint)f?|fe(get|set)env'
work=$(mktemp)
trap 'rm -f "$work"' EXIT
nm -D --defined-only "$libm" | awk '{ sub(/@.*/, "", $3); print $3 }' |
    grep -vxE "$allowed" | sort -u >"$work"
[ "$(wc -l <"$work")" -gt 100 ] || echo "cannot read the symbols of $libm"
[ -r "$1" ] || echo "cannot read $1"
nm -u "$1" | awk 'NF == 2 { print $2 }' | sort -u | comm -12 - "$work"

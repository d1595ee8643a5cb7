#!/bin/sh
# SPDX-License-Identifier: MIT
# Compares FLIP with figures that another implementation has published.
#   tests/conformance_flip.sh BUILD REF
# REF holds ref.png, other pictures, and README.md with a table whose rows begin
# `| NAME.png | mean | weighted median | 1st quartile | 3rd quartile | min | max |`. Each figure of
# ref.png against NAME.png must agree within 1e-4. Ends with `N passed, N failed`.
set -u
build=${1:?usage: conformance_flip.sh BUILD REF}
ref=${2:?usage: conformance_flip.sh BUILD REF: where the reference figures are}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
trap 'exit 130' INT TERM
passed=0 failed=0

grep '^| *[A-Za-z0-9_-]*\.png *|' "$ref/README.md" | tr -d ' ' >"$out/rows"
printf '%-24s %10s %10s\n' pair mean deviation
while IFS='|' read -r _ name mean median first third min max _; do
    if "$build/penumbra" compare "$ref/$name" "$ref/ref.png" --json >"$out/figures" 2>"$out/log" &&
        row=$(jq -r --argjson want "[$mean, $median, $first, $third, $min, $max]" '
            [.flip, .flip_weighted_median, .flip_first_quartile, .flip_third_quartile, .flip_min, .flip_max]
            | . as [$mean] | [., $want] | transpose | map(.[0] - .[1] | fabs) | max as $worst
            | if $worst <= 1e-4 then "ok" else "FAIL" end
            | "\($mean * 1e6 | round / 1e6) \($worst * 1e7 | round / 1e7) \(.)"' "$out/figures" 2>"$out/log"); then
        printf '%-24s %10s %10s %s\n' "$name" $row
    else
        row=FAIL
        printf '%-24s FAIL\n' "$name"
        sed 's/^/    /' "$out/log"
    fi
    [ "${row##* }" = ok ] && passed=$((passed + 1)) || failed=$((failed + 1))
done <"$out/rows"

[ $((passed + failed)) -gt 0 ] || echo "no table of figures in $ref/README.md"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]

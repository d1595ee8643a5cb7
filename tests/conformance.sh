#!/bin/sh
# SPDX-License-Identifier: MIT
# Renders scenes that another implementation of the shading model has rendered, and compares the pictures.
#   tests/conformance.sh BUILD REF
# REF has pairs NAME.json, NAME.png; tests/conformance/compare_pair.c states how equal a pair must be. Ends
# with `N passed, N failed`.
set -u
build=${1:?usage: conformance.sh BUILD REF}
ref=${2:?usage: conformance.sh BUILD REF: where the reference pairs are}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
trap 'exit 130' INT TERM
passed=0 failed=0

printf '%-36s %8s %9s %6s\n' pair 'agree %' rmse odd
for scene in "$ref"/*.json; do
    name=$(basename "$scene" .json)
    [ -e "$ref/$name.png" ] || continue
    if "$build/penumbra" render "$scene" -o "$out/$name.png" >"$out/log" 2>&1 &&
        row=$("$build/tests/conformance/compare_pair" "$ref/$name.png" "$out/$name.png" 2>"$out/log"); then
        verdict=ok
        passed=$((passed + 1))
    else
        verdict=FAIL
        failed=$((failed + 1))
    fi
    printf '%-36s %s %s\n' "$name" "${row:-}" "$verdict"
    [ "$verdict" = ok ] || sed 's/^/    /' "$out/log"
    row=
done

[ $((passed + failed)) -gt 0 ] || echo "no pairs NAME.json, NAME.png in $ref"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]

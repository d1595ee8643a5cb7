#!/bin/sh
# SPDX-License-Identifier: MIT
# scenes/teapot.json is the output of scenes/teapot.py, and has the intended size.
. "$(dirname "$0")/../cmd/lib.sh"
cd "$root" || exit 1
exits "the generator runs" 0 python3 scenes/teapot.py
check "it writes the scene that is kept" cmp "$work/stdout" scenes/teapot.json
count() {
    jq "[.. | objects | select(.type == \"$1\")] | length" scenes/teapot.json
}
check "the scene has a thousand triangles or more" test "$(count triangle)" -ge 1000
check "and four hundred spheres or more" test "$(count sphere)" -ge 400
exits "the scene is right" 0 "$penumbra" validate scenes/teapot.json --json
expect "and nothing in it is odd" "$(jq -c .warnings "$work/stdout")" '[]'
finish

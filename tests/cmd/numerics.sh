#!/bin/sh
# SPDX-License-Identifier: MIT
# Scenes that once broke a promise, and the values that closed forms, limits or an independent oracle give.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
corpus=$root/tests/io/corpus/good

# pixel NAME X,Y: its linear colour in three digits
pixel() {
    "$penumbra" render "$corpus/numerics-$1.json" --pixel "$2" -q |
        awk '$1 == "linear" { printf "%.3f %.3f %.3f\n", $2, $3, $4 }'
}

# Of equal solids that overlap, the later in the document tells the index, wherever they are moved
expect "of equal spheres the later" "$(pixel equal-spheres 8,7)" "0.529 0.485 0.462"
expect "of equal spheres the later, off the origin" "$(pixel equal-spheres-moved 8,7)" "0.481 0.481 0.481"
# A column of two parts has no line where they meet
expect "a column is solid at its joint" "$(pixel column-joint 10,10)" "1.000 0.000 0.000"
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# The disassembly of the kernels, function by function, against the markers of effects: a kernel has the
# markers of its effects and no others.
#   tests/effects/disassembly.sh BUILD [INSTRUCTION-SET…]
# reads the pixel kernels, and the block kernels of these instruction sets (each takes a minute; none by
# default). Prints a row for each kernel, with the markers that it lacks or must not have; exit 1 if there are
# any. A kernel is its function and the functions that it calls in its object. The line table gives the source
# of an instruction, so the build needs -g, as in `make`.
set -eu
build=${1:-build}
[ $# -eq 0 ] || shift
cd "$(dirname "$0")/../.."
markers=${MARKERS:-tests/effects/markers.txt}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The kernels and their effects, as the list has them: "identifier effect effect …".
cat >"$work/masks.c" <<'EOF'
#include <stdio.h>
#include "shade/internal/kernel_list.h"
#define ROW(identifier, name, mask) {#identifier, mask},
static const struct { const char *name; unsigned mask; } kernel[] = {PEN_KERNEL_LIST(ROW)};
int main(void)
{
    for (int i = 0; i < PEN_KERNEL_COUNT; i++) {
        printf("%s", kernel[i].name);
        for (int bit = 0; bit < PEN_FX_COUNT; bit++)
            if (kernel[i].mask >> bit & 1)
                printf(" %s", pen_effect_name(bit));
        printf("\n");
    }
}
EOF
${CC:-gcc} -std=c11 -D_GNU_SOURCE -Isrc -o "$work/masks" "$work/masks.c" "$build/librender.a" -lm
"$work/masks" >"$work/kernels"

# The markers, each with a number; those of lines with the numbers of the lines.
grep -v '^#' "$markers" | grep . | while read -r object effects kind what; do
    case $kind in
    line)
        file=${what%% *} text=${what#* }
        lines=$(grep -nF -- "$text" "src/$file" | cut -d: -f1 | tr '\n' ' ')
        [ -n "$lines" ] || echo "no line of src/$file contains: $text" >>"$work/bad"
        for line in $lines; do
            echo "$object $effects line src/$file:$line $text"
        done
        ;;
    *) echo "$object $effects $kind $what $what" ;;
    esac
done >"$work/markers"
if [ -s "$work/bad" ]; then
    cat "$work/bad"
    exit 1
fi

# judge KIND PREFIX OBJECT-FILE: the kernels of one object.
judge() {
    objdump -d -l -r --inlines --no-show-raw-insn "$3" | awk -v object="$1" -v prefix="$2" -v kernels="$work/kernels" \
        -v markers="$work/markers" -f tests/effects/disassembly.awk || failed=1
}
failed=0
echo "the pixel kernels"
judge pixel 'pen_sample_ pen_pixel_' "$build/src/shade/pixel_kernels.o"
for isa; do
    echo "the block kernels for $isa"
    judge block block_ "$build/src/shade/kernel_isa_$isa.o"
done
exit "$failed"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Prints the ten slowest steps, and the time of all: slowest.sh SECONDS-BY-THE-CLOCK
# reads lines whose fields 4 to 6 are seconds of processor time, a name, and seconds by the clock.
awk -v clock="$1" '
    { printf "%8.1f s of processor time %5d s by the clock  %s\n", $4, $6, $5 | "sort -rn | head -n 10"; cpu += $4 }
    END {
        close("sort -rn | head -n 10")
        printf "In all %.0f s of processor time, %d s by the clock; above, the ten slowest.\n", cpu, clock
    }'

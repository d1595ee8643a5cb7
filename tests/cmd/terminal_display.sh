#!/bin/sh
# SPDX-License-Identifier: MIT
# What the command line prints on a terminal: a closing line, tables that fit, a display that a key ends.
. "$(dirname "$0")/lib.sh"
python3 -c 'import os; os.openpty()' 2>/dev/null || {
    skip terminal "a pseudo-terminal cannot be opened"
    exit 77
}
display() { # COLUMNS KEYS COMMAND…
    columns=$1 keys=$2
    shift 2
    python3 "$root/tests/cmd/display.py" "$columns" 60 "$keys" "$@"
}
fits() { # NAME COLUMNS: no line of the last output is longer; the text has no escape sequences
    longest=$(sed 's/\x1b\[[0-9]*[A-Z]//g' "$work/stdout" | python3 -c 'import sys, unicodedata
print(max(sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in l.rstrip("\n")) for l in sys.stdin))')
    expect "$1 ($longest)" "$((longest <= $2))" 1
}
small="--set width=16 --set height=12"
cd "$work" || exit 1

# A render's closing line
# shellcheck disable=SC2086
exits "render on a terminal" 0 display 80 "" "$penumbra" render builtin:spheres $small -o out.png
check "ends with a line about the picture" grep -qE 'out\.png 16×12, [0-9.]+ s, [0-9.]+ k? ?rays$' stdout
# shellcheck disable=SC2086
exits "render -q on a terminal" 0 display 80 "" "$penumbra" render builtin:spheres $small -o out.png -q
expect "prints nothing" "$(cat stdout)" ""
# shellcheck disable=SC2086
exits "render --layer on a terminal" 0 display 80 "" "$penumbra" render builtin:spheres $small -o d.png --layer normal
check "has no rays in it" grep -qE 'd\.png 16×12, [0-9.]+ s$' stdout
# shellcheck disable=SC2086
exits "render for a script" 0 "$penumbra" render builtin:spheres $small -o out.png
expect "prints nothing" "$(cat stdout stderr)" ""

# Standard output takes a PNG unless told otherwise
# shellcheck disable=SC2086
"$penumbra" render builtin:spheres $small -o - >piped.png
check "render -o - writes a PNG" cmp piped.png out.png
# shellcheck disable=SC2086
"$penumbra" render builtin:spheres $small -o - --format pfm >piped.pfm
expect "or what --format says" "$(head -c 2 piped.pfm)" PF

# The job called long waits in its first pixel, so that it takes no processor time.
export PENUMBRA_TEST_FAULT=hang@0,0@long
daemon_start
unset PENUMBRA_TEST_FAULT
export PENUMBRA_URL="$url"
# shellcheck disable=SC2086
id=$("$penumbra" submit builtin:spheres $small --name "a name that is longer than eighty columns have space for, grün")
"$penumbra" wait "$id" >log
# shellcheck disable=SC2086
wide=$("$penumbra" submit builtin:spheres $small --name "部屋部屋部屋部屋部屋部屋部屋部屋部屋部屋")
"$penumbra" wait "$wide" >log
"$penumbra" fetch "$id" -o - >fetched.png
check "fetch -o - gets a PNG" cmp fetched.png out.png
# shellcheck disable=SC2086
"$penumbra" submit builtin:spheres $small --kind effects --repeats 1 --wait -q >log
long=$("$penumbra" submit builtin:spheres --set width=3000 --set height=3000 --set samples_per_pixel=64 --name long)

# Tables
exits "list on 80 columns" 0 display 80 "" "$penumbra" list
fits "list fits 80 columns" 80
prints "and has kinds" stdout "  effects    "
prints "ids whole" stdout "$id  render     succeeded  "
exits "list on 120 columns" 0 display 120 "" "$penumbra" list
fits "list fits 120 columns" 120
prints "with the time of creation" stdout "CREATED"
exits "list into a pipe" 0 "$penumbra" list
prints "has whole names" stdout "eighty columns have space for, grün"
running() { "$penumbra" list --json | jq -e ".jobs[] | select(.id == \"$long\" and .state == \"running\")"; }
within running || not_ok "the long job starts" "$("$penumbra" list)"
exits "q ends top" 0 display 80 q "$penumbra" top --interval 60
fits "top fits 80 columns" 80
prints "with ids of running jobs" stdout "$long"
exits "so does Ctrl-C, as a signal" 130 display 80 "$(printf '\003')" "$penumbra" top --interval 60
# A signal that comes while top waits for an answer, and not for a key.
api=$(child api)
kill -STOP "$api"
(sleep $((4 * patience)) && kill -CONT "$api") &
exits "and Ctrl-C during a request" 130 display 80 "$((2 * patience))@$(printf '\003')" "$penumbra" top --interval 60
wait $!
exits "top on 120 columns" 0 display 120 q "$penumbra" top --interval 60
fits "top fits 120 columns" 120
prints "with bars" stdout "["
exits "top --once on 80 columns" 0 display 80 "" "$penumbra" top --once
fits "top --once fits 80 columns" 80
"$penumbra" cancel "$long" >log
kill -KILL "$(child work)"

# Tables of studies, which continue below themselves. A terminal breaks the sentences beside them.
tables_alone() {
    sed -i -n '/^row /,/^$/p' stdout
}
# shellcheck disable=SC2086
exits "effects" 0 "$penumbra" effects builtin:spheres $small --repeats 1
tables_alone
fits "the table of effects fits 80 columns" 80
# shellcheck disable=SC2086
exits "explain" 0 "$penumbra" explain builtin:room
fits "explain fits 80 columns" 80
# shellcheck disable=SC2086
exits "bench" 0 "$penumbra" bench builtin:spheres $small --repeats 1 --warmup 0
tables_alone
fits "the tables of bench fit 80 columns" 80
expect "each part of them begins with the row" "$(grep -c '^row ' stdout) $(grep -c '^  0 ' stdout)" "4 4"
# shellcheck disable=SC2086
exits "accuracy" 0 "$penumbra" accuracy builtin:spheres $small --seeds 1
tables_alone
fits "the table of accuracy fits 80 columns" 80

# Help and suggestions
exits "help COMMAND" 0 "$penumbra" help render
"$penumbra" render --help >wanted
check "is COMMAND --help" cmp stdout wanted
exits "help of an unknown command" 2 "$penumbra" help rendr
prints "names the nearest" stderr 'nearest is "render"'
exits "a setting as an option" 2 "$penumbra" render builtin:spheres --width 3 -o x.png
prints "says how to write it" stderr "--set width=VALUE"
exits "a misspelt setting as an option" 2 "$penumbra" render builtin:spheres --samples-per-pixels 3 -o x.png
prints "says how to write the nearest" stderr "samples_per_pixel is a setting: --set samples_per_pixel=VALUE"
exits "a long option with one dash" 2 "$penumbra" render builtin:spheres -output x.png
prints "names the option" stderr "unknown option -output, nearest is --output"
exits "a misspelt one with one dash" 2 "$penumbra" render builtin:spheres -viev x -o x.png
prints "names the nearest" stderr "nearest is --view"
# shellcheck disable=SC2086
exits "one thread" 0 "$penumbra" bench builtin:spheres $small --threads 1 --repeats 1 --warmup 0
prints "is one thread" stdout "1 thread in the pool"
finish

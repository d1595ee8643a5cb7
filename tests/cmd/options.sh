#!/bin/sh
# SPDX-License-Identifier: MIT
# Command lines of both programs, right and wrong: help, version, exit codes, error messages.
. "$(dirname "$0")/lib.sh"

exits "penumbra without a command is a wrong command line" 2 "$penumbra"
prints "it lists the commands" stderr "submit"
exits "help takes one command" 2 "$penumbra" help list extra
prints "and names both" stderr 'found "list" and "extra"'
exits "penumbra --help" 0 "$penumbra" --help
for command in render validate compare scenes submit wait fetch list stats cancel delete; do
    prints "penumbra --help names $command" stdout "  $command "
done
expect "penumbra --help lists bench among what needs no daemon" \
    "$(sed -n '/^Without a daemon/,/^With a daemon/p' "$work/stdout" | grep -c '^  bench ')" 1
prints "penumbra --help documents exit codes" stdout "7  compared pictures or counts differ"
for command in render validate compare scenes submit wait fetch list stats cancel delete; do
    exits "penumbra $command --help" 0 "$penumbra" $command --help
    prints "penumbra $command --help shows its usage" stdout "Usage: penumbra $command"
    exits "penumbra $command --version" 0 "$penumbra" $command --version
    exits "penumbra $command refuses unknown options" 2 "$penumbra" $command --no-such-option
done
exits "penumbra --version" 0 "$penumbra" --version
expect "penumbra --version is one line" "$(sed 's/[0-9.]*$//' "$work/stdout")" "penumbra "
exits "penumbrad --help" 0 "$build/penumbrad" --help
prints "penumbrad --help shows environment variables" stdout "[PENUMBRA_LISTEN]"
expect "penumbrad --help does not show internal options" "$(grep -c internal "$work/stdout")" 0
exits "penumbrad --version" 0 "$build/penumbrad" --version

exits "an unknown command" 2 "$penumbra" rendr
prints "the error names the nearest command" stderr 'nearest is "render"'
exits "an unknown option" 2 "$penumbra" render x --ouput y
prints "the error names the nearest option" stderr "nearest is --output"
exits "a missing value" 2 "$penumbra" render builtin:spheres -o
prints "the error names the value" stderr "-o: needs a value, OUT"
exits "an option in place of a value" 2 "$penumbra" list --state --json
prints "counts as a missing value" stderr "--state: needs a value"
exits "a wrong number" 2 "$penumbra" render builtin:spheres --threads=-1 -o "$work/x.png"
prints "the error has what was found and what is allowed" stderr 'found "-1", allowed is an integer from 0 to 1024'
exits "a number followed by a letter" 2 "$penumbra" render builtin:spheres --threads 2x -o "$work/x.png"
exits "a wrong choice" 2 "$penumbra" list --state done
prints "the error lists the choices" stderr "queued, running, succeeded, failed or cancelled"
exits "an option given twice" 2 "$penumbra" render builtin:spheres -o a.png -o b.png
prints "the error says so" stderr "given twice"
exits "a flag with a wrong value" 2 "$penumbra" list --json=maybe
exits "too many arguments" 2 "$penumbra" render a b -o "$work/x.png"
prints "the error names the second one" stderr 'unexpected argument "b"'
exits "a missing argument" 2 "$penumbra" validate
exits "an output without a known ending" 2 "$penumbra" render builtin:spheres -o "$work/x.gif"
prints "the error lists the endings" stderr ".png or .pfm"
exits "render without any output" 2 "$penumbra" render builtin:spheres
exits "a wrong pixel" 2 "$penumbra" render builtin:spheres --pixel 1
exits "a pixel outside" 2 "$penumbra" render builtin:spheres --pixel 100000,0
exits "a statistics file of a layer" 2 "$penumbra" render builtin:spheres --layer depth -o "$work/x.png" --stats "$work/x.json"
prints "the error says why" stderr "has no --stats"
exits "a cost without its layer" 2 "$penumbra" render builtin:spheres --cost tests -o "$work/x.png"
exits "a setting of a later version" 3 "$penumbra" render builtin:spheres --set precision=fast -o "$work/x.png"
prints "is known, not supported yet" stderr "known, not supported yet"
exits "a wrong server" 2 "$penumbra" list --server ftp://x
exits "a wrong server in the environment" 2 env PENUMBRA_URL=nonsense:// "$penumbra" list
"$penumbra" --version >/dev/full 2>"$work/stderr"
expect "lost output is an error" $? 8

finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# What the programs say to command lines right and wrong.
. "$(dirname "$0")/lib.sh"

ends "penumbra alone is a wrong call" 2 "$penumbra"
says "penumbra alone shows its commands" stderr "submit"
ends "penumbra --help" 0 "$penumbra" --help
for command in render validate compare scenes submit wait fetch list stats cancel delete; do
    says "penumbra --help names $command" stdout "  $command "
done
says "penumbra --help documents exit codes" stdout "7  the compared pictures differ"
for command in render validate compare scenes submit wait fetch list stats cancel delete; do
    ends "penumbra $command --help" 0 "$penumbra" $command --help
    says "penumbra $command --help shows its usage" stdout "Usage: penumbra $command"
    ends "penumbra $command --version" 0 "$penumbra" $command --version
    ends "penumbra $command refuses unknown options" 2 "$penumbra" $command --no-such-option
done
ends "penumbra --version" 0 "$penumbra" --version
expect "penumbra --version is one line" "$(sed 's/[0-9.]*$//' "$work/stdout")" "penumbra "
ends "penumbrad --help" 0 "$build/penumbrad" --help
says "penumbrad --help shows environment variables" stdout "[PENUMBRA_LISTEN]"
expect "penumbrad --help keeps internals to itself" "$(grep -c internal "$work/stdout")" 0
ends "penumbrad --version" 0 "$build/penumbrad" --version

for word in plan accuracy effects; do
    ends "the later command $word" 3 "$penumbra" "$word" x
    says "is known" stderr "\"$word\" is known, not supported yet"
done
ends "an unknown command" 2 "$penumbra" rendr
says "is answered with the nearest" stderr 'nearest is "render"'
ends "an unknown option" 2 "$penumbra" render x --ouput y
says "is answered with the nearest" stderr "nearest is --output"
ends "a missing value" 2 "$penumbra" render builtin:spheres -o
says "is answered with what is wanted" stderr "-o: needs a value, OUT"
ends "a value that is an option" 2 "$penumbra" list --state --json
says "is a missing value" stderr "--state: needs a value"
ends "a wrong number" 2 "$penumbra" render builtin:spheres --threads=-1 -o "$work/x.png"
says "is answered with what is allowed" stderr 'found "-1", allowed is an integer from 0 to 1024'
ends "a number with a tail" 2 "$penumbra" render builtin:spheres --threads 2x -o "$work/x.png"
ends "a wrong choice" 2 "$penumbra" list --state done
says "is answered with the choices" stderr "queued, running, succeeded, failed or cancelled"
ends "an option given twice" 2 "$penumbra" render builtin:spheres -o a.png -o b.png
says "is said to be" stderr "given twice"
ends "a flag with a wrong value" 2 "$penumbra" list --json=maybe
ends "too many arguments" 2 "$penumbra" render a b -o "$work/x.png"
says "names the one too many" stderr 'unexpected argument "b"'
ends "no argument where one is needed" 2 "$penumbra" validate
ends "an output without a known ending" 2 "$penumbra" render builtin:spheres -o "$work/x.gif"
says "is answered with the endings" stderr ".png or .pfm"
ends "nothing to be made" 2 "$penumbra" render builtin:spheres
ends "a wrong pixel" 2 "$penumbra" render builtin:spheres --pixel 1
ends "a pixel outside" 2 "$penumbra" render builtin:spheres --pixel 100000,0
ends "a layer still to come" 3 "$penumbra" render builtin:spheres --layer depth -o "$work/x.png"
says "is known" stderr "known, not supported yet"
ends "a wrong server" 2 "$penumbra" list --server ftp://x
ends "a wrong server of the environment" 2 env PENUMBRA_URL=nonsense:// "$penumbra" list
"$penumbra" --version >/dev/full 2>"$work/stderr"
expect "output that gets lost is an error" $? 8

finish

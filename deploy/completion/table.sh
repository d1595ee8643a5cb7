#!/bin/sh
# SPDX-License-Identifier: MIT
# Prints what the shells complete, as the programs of a build describe themselves: table.sh BUILD.
# Each line has fields between tabs; an empty field is -.
#   scene    NAME                                  a built-in scene
#   setting  KEY CHOICES                           a render setting, with the values that are supported
#   command  PROGRAM COMMAND ARGUMENTS SUMMARY     COMMAND is - for the program itself
#   option   PROGRAM COMMAND LETTER NAME VALUE CHOICES TIMES HELP
# CHOICES are the allowed words, with | between them; TIMES is * for what may be repeated.
# Which values are allowed is in the error that follows a wrong one.
set -eu
build=$1
tab=$(printf '\t')

# What --help of a command prints: its arguments and summary in one line, then a line for each option.
describe() {
    awk -v OFS='\t' '
    function flush() {
        if (label != "") {
            letter = label ~ /^-., / ? substr(label, 1, 2) : "-"
            sub(/^-., /, "", label)
            value = label ~ / / ? substr(label, index(label, " ") + 1) : "-"
            sub(/ .*/, "", label)
            times = help ~ /may be repeated/ ? "*" : "-"
            sub(/ \[PENUMBRA_[A-Z_]*\]/, "", help)
            print letter, label, value, times, help
        }
        label = ""
    }
    NR == 1 {
        sub(/^Usage: penumbrad? ?/, "")
        sub(/ ?\[options\]$/, "")
        if ($0 ~ /^[a-z]/) sub(/^[a-z]+ ?/, "")
        sub(/ -o OUT$/, "")
        arguments = $0 == "" ? "-" : $0
    }
    NR == 3 { print arguments, $0 }
    /^Exit codes:$/ { exit }
    /^  (-|    --)/ {
        flush()
        sub(/^ +/, "")
        match($0, /   *[^ ]/)
        label = substr($0, 1, RSTART - 1)
        help = substr($0, RSTART + RLENGTH - 1)
        next
    }
    label != "" && NF {
        sub(/^ +/, "")
        help = help " " $0
    }
    END { flush() }'
}

# What values an option takes. The wrong one is reported before anything else happens, and --help
# keeps the command from running where every text is right.
choices() { # OPTION PROGRAM [COMMAND]
    option=$1 program=$2
    shift 2
    found=$("$build/$program" "$@" "$option" '?' --help 2>&1 >/dev/null |
        sed -n 's/.*found "?", allowed is //p' | grep -vE '^(an integer|a number) from ' |
        sed 's/, /|/g; s/ or /|/' || :)
    echo "${found:--}"
}

command() { # PROGRAM [COMMAND]
    name=${2:--}
    "$build/$1" ${2:+"$2"} --help | describe | {
        IFS= read -r line
        printf 'command\t%s\t%s\t%s\n' "$1" "$name" "$line"
        while IFS=$tab read -r letter option value times help; do
            allowed=-
            [ "$value" = - ] || allowed=$(choices "$option" "$@")
            printf 'option\t%s\t%s\t%s\t%s\t%s\t%s\t%s\t%s\n' "$1" "$name" "$letter" "$option" "$value" "$allowed" \
                "$times" "$help"
        done
    }
}

setting() { # ASSIGNMENT: the error that it causes
    "$build/penumbra" render builtin:spheres --pixel 0,0 --set "$1" 2>&1 >/dev/null || :
}

"$build/penumbra" scenes | awk '{ print "scene\t" $1 }'
for key in $(setting '?=0' | sed -n 's/.*the keys here are //p' | tr -d ,); do
    known=$(setting "$key=?" | sed -n 's/.*must be \(one of \)*\(".*"\), found .*/\2/p' | tr -d '",')
    words=
    for word in $known; do
        case $(setting "$key=$word") in
        *'not supported yet'*) ;;
        *) words=$words${words:+|}$word ;;
        esac
    done
    [ -n "$known" ] && [ -z "$words" ] || printf 'setting\t%s\t%s\n' "$key" "${words:--}"
done
for name in $("$build/penumbra" --help | sed -n '/^Exit codes/q; s/^  \([a-z]*\) .*/\1/p'); do
    command penumbra "$name"
done
command penumbrad
command penumbrad backup
command penumbrad check
command penumbrad token

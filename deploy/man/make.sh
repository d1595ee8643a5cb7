#!/bin/sh
# SPDX-License-Identifier: MIT
# Makes a man page from its template: make.sh BUILD VERSION DATE TEMPLATE. Lines that begin with @ call
# for text that has its source elsewhere:
#   @synopsis P         the usage line of program P (penumbra, penumbrad) or of `P COMMAND`
#   @text P             the paragraphs between that line and the options
#   @options P          the options
#   @exit P             the exit codes
#   @commands P         all of these but the exit codes for every command of P
#   @header FILE        the comments and declarations of a header
#   @markdown FILE      a page
set -eu
build=$1 version=$2 date=$3 template=$4
cd "$(dirname "$0")/../.."
here=deploy/man skip=0

help() { # PART PROGRAM [COMMAND]
    part=$1 program=$2
    shift 2
    env -u PENUMBRA_URL "$build/$program" "$@" --help |
        awk -v PART="$part" -v SKIP=$skip -f $here/roff.awk -f $here/help.awk
}

commands() { # PROGRAM
    for command in $(help commands "$1"); do
        echo ".SS $1 $command"
        help synopsis "$1" "$command"
        echo .PP
        help text "$1" "$command"
        skip=1
        help options "$1" "$command"
        skip=0
    done
}

while IFS= read -r line; do
    # shellcheck disable=SC2086
    case $line in
    @commands*) commands ${line#@commands } ;;
    @header*) awk -f $here/roff.awk -f $here/header.awk "${line#@header }" ;;
    @markdown*) awk -f $here/roff.awk -f $here/markdown.awk "${line#@markdown }" ;;
    @*) help ${line#@} ;;
    *) printf '%s\n' "$line" | sed "s/@VERSION@/$version/g; s/@DATE@/$date/g" ;;
    esac
done <"$template"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Prints a C table of whole files: embed.sh [--stem] TABLE FILE...
# The table is an array of struct pen_embedded_file (base/embed.h), ended by a null name. With --stem
# names have no ending.
set -eu
stem=
if [ "$1" = --stem ]; then
    stem=1
    shift
fi
table=$1
shift
echo '#include "base/embed.h"'
n=0
for f in "$@"; do
    echo "static const unsigned char file_$n[] = {"
    od -An -v -tu1 "$f" | sed 's/ *\([0-9][0-9]*\)/\1,/g'
    echo "0};"
    n=$((n + 1))
done
echo "const struct pen_embedded_file ${table}[] = {"
n=0
for f in "$@"; do
    name=$(basename "$f")
    [ -z "$stem" ] || name=${name%.*}
    echo "    {\"$name\", file_$n, sizeof file_$n - 1},"
    n=$((n + 1))
done
echo "    {0, 0, 0},"
echo "};"

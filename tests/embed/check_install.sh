#!/bin/sh
# SPDX-License-Identifier: MIT
# An installed copy, as another program sees it: `make install` into a folder, the example compiled with the
# output of pkg-config, the exports of the shared library, and `make uninstall`.
case $(echo "${1:-build}"/libpenumbra.so.*.*.*) in
*'*')
    echo "skipped: plain-build: a build with sanitizers has no shared library and is not for installing"
    exit 77
    ;;
esac
. "$(dirname "$0")/../cmd/lib.sh"
cd "$(dirname "$0")/../.." || exit 1
unset MAKEFLAGS MFLAGS MAKELEVEL CPATH LIBRARY_PATH
copy=$work/copy
installed=$copy/usr/local
export PKG_CONFIG_SYSROOT_DIR="$copy" PKG_CONFIG_PATH="$installed/lib/pkgconfig"

in_copy() { # TARGET: make install or uninstall
    make --no-print-directory BUILD="$build" DESTDIR="$copy" PREFIX=/usr/local "$1"
}

# Compiles the example and renders with it: a folder for each way, with the program and its picture.
warnings='-Wall -Wextra -Wpedantic -Werror'
try() { # NAME COMPILER-AND-LANGUAGE LINK-OPTIONS [PKG-CONFIG-OPTION]
    flags=$(pkg-config --cflags penumbra) libs=$(pkg-config $4 --libs penumbra)
    mkdir "$work/$1"
    # shellcheck disable=SC2086
    check "compiles: $1" $2 $warnings $flags api/examples/embed.c -o "$work/$1/embed" $3 -x none $libs
    LD_LIBRARY_PATH=$installed/lib check "runs: $1" "$work/$1/embed" spheres "$work/$1/out.png"
    check "renders what penumbra renders: $1" cmp "$work/$1/out.png" "$work/program.png"
    needed=$(readelf -d "$work/$1/embed" | grep -c 'NEEDED.*libpenumbra\.so\.0\]')
    expect "loads the shared library: $1" "$needed" "$([ -n "$4" ] && echo 0 || echo 1)"
}

check "make install" in_copy install
[ "$failures" -eq 0 ] || finish
expect "compiles nothing again" "$(grep -cE '^  (CC|AR|LD|MAN|GEN) ' "$work/output")" 0
check "the program renders" "$installed/bin/penumbra" render builtin:spheres -q -o "$work/program.png"
try c-shared 'gcc -std=c11 -x c' '' ''
try cpp-shared 'g++ -std=c++11 -x c++' '' ''
try c-static 'gcc -std=c11 -x c' -static --static
try cpp-static 'g++ -std=c++11 -x c++' -static --static
LD_LIBRARY_PATH=$installed/lib "$work/c-shared/embed" sphere "$work/none.png" 2>"$work/printed"
expect "an unknown scene ends the example with code 1" $? 1
expect_match "and with the library's words" "$(cat "$work/printed")" '*"sphere", nearest is "spheres"'
expect "the example is short" "$(($(wc -l <api/examples/embed.c) <= 40))" 1

sed -n '/^<!-- embed: /,/^```$/p' include/README.md | sed '1,2d;$d' >"$work/readme.c"
# shellcheck disable=SC2046,SC2086
for language in 'gcc -std=c11 -x c' 'g++ -std=c++11 -x c++'; do
    check "the program of include/README.md compiles: ${language%% *}" $language $warnings $(pkg-config --cflags penumbra) \
        "$work/readme.c" -o "$work/readme" -x none $(pkg-config --libs penumbra)
    LD_LIBRARY_PATH=$installed/lib check "and runs: ${language%% *}" "$work/readme"
    expect_match "and prints a pixel: ${language%% *}" "$(cat "$work/output")" '[0-9]* x [0-9]*, the first pixel is *'
done

library=$installed/lib/libpenumbra.so
gcc -E -P "$installed/include/penumbra.h" | grep -o 'penumbra_[a-z0-9_]*(' | tr -d '(' | sort >"$work/declared"
nm -D --defined-only "$library" | awk '{ print $3 }' | sort >"$work/exported"
expect "penumbra.h declares functions" "$(($(wc -l <"$work/declared") >= 15))" 1
check "the shared library exports what penumbra.h declares" diff "$work/declared" "$work/exported"
nm -g --defined-only "$installed/lib/libpenumbra.a" | awk 'NF == 3 { print $3 }' | sort >"$work/exported"
check "and the archive" diff "$work/declared" "$work/exported"
expect "penumbra.h includes the C library alone" \
    "$(sed -n 's/^ *# *include *//p' include/penumbra.h | sort | tr '\n' ' ')" '<stddef.h> <stdint.h> '
expect "SONAME" "$(readelf -d "$library" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')" libpenumbra.so.0
expect "the SONAME leads to the library" "$(readlink -f "$installed/lib/libpenumbra.so.0")" \
    "$(readlink -f "$library")"
expect "pkg-config knows the version" "penumbra $(pkg-config --modversion penumbra)" \
    "$("$installed/bin/penumbra" --version)"

path() { # NAME: the installed page's path
    echo "$installed/share/man/man${1##*.}/$1"
}
for name in penumbra.1 penumbrad.8 penumbra-scene.5 penumbra.3; do
    expect "$name has its name" "$(sed -n '/^\.SH NAME/{n;s/ .*//;s/\\//g;p}' "$(path $name)")" "${name%.*}"
    expect "$name has nothing left of its template" "$(grep -n '@[A-Za-z_]*@' "$(path $name)")" ""
    if command -v groff >/dev/null; then
        expect "groff finds nothing in $name" "$(groff -man -Tutf8 -Kutf8 -ww -z "$(path $name)" 2>&1)" ""
    else
        skip command-groff "what groff finds in $name"
    fi
    if command -v mandoc >/dev/null; then
        expect "mandoc finds nothing in $name" "$(mandoc -T lint -W warning "$(path $name)")" ""
    else
        skip command-mandoc "what mandoc finds in $name"
    fi
done
plain() { # what a page says, without markup and in one line
    sed 's/\\f[BIR]//g; s/\\-/-/g; s/\\&//; s/\\~/ /g' "$(path "$1")" | tr '\n' ' '
}
for command in $("$build/penumbra" --help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p'); do
    "$build/penumbra" "$command" --help | grep -oE '^  (-., |    )--[a-z-]+' | grep -o -- '--.*' |
        grep -vxE -- '--(help|version)' >"$work/options"
    sed -n "/^\.SS penumbra $command\$/,/^\.S[SH] /p" "$(path penumbra.1)" |
        sed 's/\\-/-/g' | grep -A 1 '^\.TP' | grep -oE -- '--[a-z-]+' >"$work/documented"
    check "penumbra(1) has the options of $command" diff "$work/options" "$work/documented"
done
missing=
page=$(plain penumbra.3)
for function in $(cat "$work/declared"); do
    case $page in *"$function("*) ;; *) missing="$missing $function" ;; esac
done
expect "penumbra(3) has every function" "$missing" ""
missing=
page=$(plain penumbra-scene.5)
for key in $(jq -r '[.. | .properties? // empty | keys[]] | unique[]' api/scene.schema.json); do
    case $page in *"$key"*) ;; *) missing="$missing $key" ;; esac
done
expect "penumbra-scene(5) has every key of the schema" "$missing" ""

for file in bash-completion/completions/penumbra bash-completion/completions/penumbrad \
    zsh/site-functions/_penumbra; do
    check "completion is installed: $file" test -s "$installed/share/$file"
done

check "make uninstall" in_copy uninstall
expect "leaves no file" "$(find "$copy" ! -type d)" ""
finish

#!/bin/sh
# SPDX-License-Identifier: MIT
# Checks the project's rules: layers, headers that compile alone, format, exported symbols and who calls
# them, no libm in the renderer, no absolute epsilon where intersections are decided, references to
# files that exist, words and sentences. Prints every offence; exit 1 if there is any.
set -eu
build=${1:-build}
cd "$(dirname "$0")/.."
jobs=$(nproc)
sh deploy/install-deps.sh --lint
fails=0
bad() {
    echo "lint: $*"
    fails=$((fails + 1))
}
count() { # counts what a command prints, a line an offence
    while IFS= read -r line; do
        bad "$line"
    done <"$1"
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# 1. Layers: each #include against src/LAYERS. A header directly in src/MODULE is public; one in
# a folder below that belongs to the module alone, and to the tests that LAYERS names.
git ls-files 'src/*.[ch]' 'include/*.h' 'tests/*.[ch]' | sort >"$work/files"
awk '
FNR == NR {
    sub(/#.*/, "")
    if ($2 == "<") {
        known[$1] = 1
        for (i = 3; i <= NF; i++) allowed[$1, $i] = 1
    } else if ($1 ~ /:$/) {
        module = $1; sub(/:/, "", module); modules[module] = 1; sees[module, module] = 1
        for (i = 2; i <= NF; i++)
            for (r in modules) if (sees[$i, r]) sees[module, r] = 1
    }
    next
}
FNR == 1 {
    n = split(FILENAME, part, "/")
    module = part[1] == "src" ? part[2] : part[1]
    if (part[1] == "src" && !(module in modules)) print FILENAME ": module \"" module "\" is not in src/LAYERS"
}
/^[ \t]*#[ \t]*include/ {
    target = $0
    sub(/^[^"<]*["<]/, "", target); sub(/[">].*/, "", target)
    depth = split(target, t, "/")
    if ($0 !~ /"/) {
        if ((target in known) && part[1] != "tests" && !allowed[target, module])
            print FILENAME ":" FNR ": module " module " must not use " target
    } else if (!(t[1] in modules)) {
        if (part[1] == "src" && !(target == "penumbra.h" && part[2] == "embed"))
            print FILENAME ":" FNR ": write the path from src/: " target
    } else if (depth > 2 && t[1] != module) {
        if (!allowed[target, FILENAME]) print FILENAME ":" FNR ": private header of module " t[1] ": " target
    } else if (part[1] == "src" && !sees[module, t[1]]) {
        print FILENAME ":" FNR ": module " module " must not see " target
    }
}' src/LAYERS $(cat "$work/files") >"$work/out"
count "$work/out"

# 2. Every header compiles alone, without warnings, with both compilers.
flags="-std=c11 -D_GNU_SOURCE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Isrc -Iinclude"
flags="$flags $(pkg-config --cflags jansson zlib)"
git ls-files 'src/*/*.h' 'include/*.h' | grep -E '^(include|src/[a-z]+)/[a-z0-9_]+\.h$' >"$work/headers"
cat >"$work/alone.sh" <<'EOF'
name=${1#src/}
name=${name#include/}
source=$(mktemp "$work/XXXXXX.c")
printf '#include "%s"\n#include "%s"\nextern int pen_lint;\nint pen_lint;\n' "$name" "$name" >"$source"
for compiler in gcc clang; do
    $compiler $flags -Werror -fsyntax-only "$source" 2>"$source.err" ||
        echo "$1 does not compile alone with $compiler: $(grep -m1 error "$source.err")"
done
EOF
export work flags
xargs -P "$jobs" -n 1 sh "$work/alone.sh" <"$work/headers" | sort >"$work/out"
count "$work/out"

# 3. Format.
git ls-files 'src/*.[ch]' 'include/*.h' 'tests/*.[ch]' | xargs -P "$jobs" -n 40 clang-format --dry-run 2>&1 |
    grep 'warning: code should be clang-formatted' | cut -d: -f1 | sort -u >"$work/out" || :
sed -i 's/$/: not formatted (clang-format -i)/' "$work/out"
count "$work/out"

# 4. Exported symbols begin with pen_, those of module embed also with penumbra_; the renderer calls no libm but sqrt,
# fma and rounding (H104).
make -s all BUILD="$build" >/dev/null
nm -A -g --defined-only "$build"/src/[a-z]*/*.o "$build"/src/[a-z]*/*/*.o "$build"/gen/*.o 2>/dev/null |
    grep -v "^$build/src/cmd/" | sed "s|^$build/||" |
    awk 'NF == 3 && $3 !~ /^pen_/ && !($1 ~ /^src\/embed\// && $3 ~ /^penumbra_/) && $3 !~ /^_?_?(asan|ubsan|odr_asan)/ { print "exported symbol without pen_: " $3 }' |
    sort -u >"$work/out"
count "$work/out"
# libpenumbra exports what penumbra.h declares, no more and no less.
sed -n 's/^PENUMBRA_API.*[ *]\(penumbra_[a-z_]*\)(.*/\1/p' include/penumbra.h | sort >"$work/declared"
for library in "-D $build"/libpenumbra.so.*.*.* "-g $build/libpenumbra.a"; do
    nm --defined-only $library | awk 'NF == 3 { print $3 }' | sort | diff "$work/declared" - |
        sed -n "s|^[<>]|exported and declared symbols differ: $library:|p" >"$work/out"
    count "$work/out"
done
sh deploy/libm.sh "$build/libpenumbra.a" >"$work/out"
sed -i 's/$/: libm symbol in libpenumbra.a/' "$work/out"
count "$work/out"

# One name, one definition: an archive member that defines it again would be left out in silence.
nm -g --defined-only "$build/librender.a" "$build/libservice.a" "$build"/src/cmd/*.o 2>/dev/null |
    awk 'NF == 3 && $3 ~ /^pen_/ { print $3 }' | sort | uniq -d >"$work/out"
sed -i 's/$/: defined more than once/' "$work/out"
count "$work/out"

# 5. No process-ending or printing calls outside src/cmd.
git ls-files 'src/*.c' 'src/*.h' | grep -v '^src/cmd/' |
    xargs -r grep -nE '(^|[^a-z_.>])(exit|_exit|abort|printf|puts|putchar|perror)\(' >"$work/out" || :
sed -i 's/^/exit, abort or printing outside src\/cmd: /' "$work/out"
count "$work/out"

# 6. The top level holds only what belongs there.
git ls-files | cut -d/ -f1 | sort -u |
    grep -vxE 'Makefile|README\.md|LICENSE|src|include|api|scenes|tests|deploy|\..*' >"$work/out" || :
sed -i 's/$/: does not belong in the top level/' "$work/out"
count "$work/out"

# 7. Every source file names its licence.
git ls-files 'src/*.[ch]' 'include/*.h' 'tests/*.[ch]' '*.sh' | xargs -r grep -L 'SPDX-License-Identifier: MIT' >"$work/out" || :
sed -i 's/$/: no SPDX line/' "$work/out"
count "$work/out"

# For awk: `line` is the line without comments; the middle lines of a comment are left out.
code='
FNR == 1 { comment = 0 }
{
    line = $0
    if (comment && !sub(/^.*\*\//, "", line)) next
    comment = 0
    gsub(/\/\*([^*]|\*+[^*\/])*\*+\//, " ", line)
    if (sub(/\/\*.*$/, "", line)) comment = 1
}'

# 8. No absolute epsilon where intersections are decided: no literal between 1e-3 and 1e-15 there, except
# powers of two that scale something (0x1p-22 in 1 + 0x1p-22, 0x1p-40 * size, mul_pd(splat4(0x1p-40), x)).
git ls-files 'src/geom/*.[ch]' 'src/accel/*.[ch]' 'src/shade/*.[ch]' >"$work/files"
awk "$code"'
{
    for (rest = line; match(rest, /(^|[^A-Za-z0-9_.])([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?/);
         rest = substr(rest, RSTART + RLENGTH)) {
        number = substr(rest, RSTART, RLENGTH)
        sub(/^[^0-9.]/, "", number)
        if (number + 0 >= 1e-15 && number + 0 <= 1e-3)
            print FILENAME ":" FNR ": absolute epsilon? " number
    }
    line = tolower(line)
    gsub(/(mul_p[sd]\(|fmadd_p[sd]\([a-z]+, )(_mm[0-9]*_set1_p[sd]|splat4)\(0x[0-9a-f.]+p-[0-9]+/, " ", line)
    gsub(/lanes_splat\(0x[0-9a-f.]+p-[0-9]+\) \* [^0-9]/, " ", line)
    gsub(/(1 [-+] |[^0-9. ] \* )0x[0-9a-f.]+p-[0-9]+/, " ", line)
    gsub(/0x[0-9a-f.]+p-[0-9]+f? \* [^0-9]/, " ", line)
    for (; match(line, /0x[0-9a-f.]+p-[0-9]+/); line = substr(line, RSTART + RLENGTH)) {
        number = substr(line, RSTART, RLENGTH)
        power = number
        sub(/^.*p-/, "", power)
        if (power + 0 >= 10 && power + 0 <= 50)
            print FILENAME ":" FNR ": absolute epsilon? " number
    }
}' $(cat "$work/files") >"$work/out"
count "$work/out"

# 9. A file that a comment or a page names is there: by its path from the top level, from src/, from
# tests/ or from the file that names it, or by its name alone, if a file somewhere has that name.
git ls-files >"$work/all"
git ls-files 'src/*.[ch]' 'include/*.h' 'tests/*.[ch]' '*.md' '*.sh' '*.py' api/openapi.yaml Makefile .ci/run src/LAYERS >"$work/files"
awk '
FILENAME == all {
    there[$0] = 1
    n = split($0, part, "/")
    named[part[n]] = 1
    next
}
FNR == 1 {
    comment = 0
    code = FILENAME ~ /\.[ch]$/
    page = FILENAME ~ /\.md$/
    folder = FILENAME
    if (!sub(/\/[^\/]*$/, "", folder)) folder = "."
}
function normal(path) { # a/../b is b
    gsub(/(^|\/)\.\//, "/", path)
    while (sub(/[^\/]+\/\.\.\//, "", path)) ;
    sub(/^\//, "", path)
    return path
}
function offence(name) {
    if (name ~ /^(build|usr|etc|proc|var|lib|sys|tmp)\// || name ~ /(MODULE|FOLDER|NAME|BUILD)/) return
    if (name ~ /^[^\/]*\.(json|yaml|txt|xml|in)$/) return # made by an example
    if (name in there || ("src/" name) in there || ("tests/" name) in there) return
    if (normal(folder "/" name) in there || (name !~ /\// && (name in named || name in other))) return
    print FILENAME ":" FNR ": no such file: " name
}
{
    text = $0
    if (code) { # comments alone
        text = ""
        for (rest = $0; rest != "";) {
            if (comment) {
                end = index(rest, "*/")
                text = text " " (end ? substr(rest, 1, end - 1) : rest)
                rest = end ? substr(rest, end + 2) : ""
                comment = !end
            } else {
                start = index(rest, "/*")
                rest = start ? substr(rest, start + 2) : ""
                comment = start > 0
            }
        }
    } else if (!page) { # scripts, make, YAML: from # on
        start = match($0, /(^|[ \t])#/)
        text = start ? substr($0, start) : FILENAME ~ /yaml$/ ? $0 : ""
    }
    gsub(/https?:[^ )>]*/, " ", text)
    if (page) gsub(/\]\([^)]*\)/, " ", text) # links are judged below
    gsub(/[A-Za-z0-9_.*{}<>$-]*[*{}<>$][A-Za-z0-9_.\/*{}<>$-]*/, " ", text) # patterns and variables
    while (match(text, /[A-Za-z0-9_][A-Za-z0-9_.\/-]*\.(c|h|md|sh|py|json|yaml|txt|xml|in)($|[^A-Za-z0-9_\/-])/)) {
        name = substr(text, RSTART, RLENGTH)
        before = RSTART > 1 ? substr(text, RSTART - 1, 1) : ""
        text = substr(text, RSTART + RLENGTH)
        sub(/[^A-Za-z0-9_]+$/, "", name)
        if (before !~ /[\/.…-]/) offence(name)
    }
    if (page) {
        for (text = $0; match(text, /\]\([^)#]+/); text = substr(text, RSTART + RLENGTH)) {
            name = substr(text, RSTART + 2, RLENGTH - 2)
            path = normal(folder "/" name)
            sub(/\/$/, "", path)
            if (name !~ /^https?:/ && !(path in there) && system("test -d " path) != 0)
                print FILENAME ":" FNR ": no such file: " name
        }
    }
}
BEGIN {
    all = ARGV[1]
    split("png.h math.h sqlite3.h jansson.h zlib.h expat.h zstd.h sodium.h pthread.h sysexits.h report.md table.md", list, " ")
    for (i in list) other[list[i]] = 1
}' "$work/all" $(cat "$work/files") >"$work/out"
count "$work/out"

# 10. An exported function is called by another file of the programs, or src/LAYERS names it as a test
# door, and then a test does call it. Rule 4 has made sure that each name has one definition.
git ls-files 'src/cmd/*.c' | sed "s|^|$build/|; s|c\$|o|" >"$work/programs" # no leftovers of files that were renamed
nm -A "$build/librender.a" "$build/libservice.a" $(cat "$work/programs") 2>/dev/null |
    awk 'NF < 2 { next }
    $(NF - 1) == "U" { called[$NF] = 1 }
    $(NF - 1) == "T" && $NF ~ /^pen_/ { defined[$NF] = 1 }
    END { for (name in defined) if (!(name in called)) print name }' | sort >"$work/uncalled"
sed -n 's/^\(pen_[a-z0-9_]*\)() < tests$/\1/p' src/LAYERS | sort >"$work/doors"
comm -23 "$work/uncalled" "$work/doors" |
    sed 's/$/: no other file of the programs calls it: make it static, or list it in src\/LAYERS as a test door/' >"$work/out"
comm -13 "$work/uncalled" "$work/doors" |
    sed 's/$/: src\/LAYERS lists it as a test door, but the programs call it, or it is gone/' >>"$work/out"
while read -r door; do
    git grep -qw "$door" -- tests || echo "$door: src/LAYERS lists it as a test door, but no test calls it"
done <"$work/doors" >>"$work/out"
count "$work/out"

# 11. Words that are no parts of identifiers, because the field has others: fan (disk packet), gate
# (candidate), tint (transmissive occluder), obituary (death report), twofold (double-double), crossing
# (intersection), fate (visibility), suspect (quarantined), tidy (purge).
git ls-files 'src/*.[ch]' 'include/*.h' >"$work/files"
awk "$code"'
{
    gsub(/"([^"\\]|\\.)*"/, "", line)
    for (; match(line, /[A-Za-z_][A-Za-z0-9_]*/); line = substr(line, RSTART + RLENGTH)) {
        name = substr(line, RSTART, RLENGTH)
        if (("_" tolower(name) "_") ~ /_(fans?|gates?|tints?|obituary|obituaries|twofolds?|crossings?|fates?|suspects?|tidy)_/)
            print FILENAME ":" FNR ": not a word of the field: " name
    }
}' $(cat "$work/files") >"$work/out"
count "$work/out"

# 12. The English of pages and header comments.
git ls-files '*.md' 'src/*.h' 'include/*.h' 'tests/*.h' | xargs python3 deploy/prose.py >"$work/out" || :
count "$work/out"

if [ "$fails" -gt 0 ]; then
    echo "lint: $fails offences"
    exit 1
fi
echo "lint: clean"

# SPDX-License-Identifier: MIT
# Turns include/penumbra.h into man source. The first comment after the licence is the description;
# a comment `---- TITLE ----` begins a section; every other comment describes the declaration
# that follows it.

# Begins a paragraph, unless one has just begun.
function begin() {
    if (!begun) print ".PP"
    begun = 1
}

function flush(    i, line, code) {
    if (!text_count) return
    code = 0
    for (i = 1; i <= text_count; i++) {
        line = text[i]
        if (line ~ /^    /) {
            if (!code) {
                begin()
                print ".in +4n\n.EX"
            }
            code = 1
            begun = 0
            print roff(substr(line, 5))
            continue
        }
        if (code) print ".EE\n.in"
        if (line == "") begin()
        else paragraph(line, i)
        code = 0
    }
    if (code) print ".EE\n.in"
    text_count = 0
}

# One line of prose. Labels such as "Fails:" begin a paragraph.
function paragraph(line, i,    before, word) {
    begun = 0
    while (match(line, /(^|[ ])(Owns|Fails|Threads|Errors|Pictures|Binary compatibility|The process around it): ?/)) {
        before = substr(line, 1, RSTART - 1)
        if (before != "") print roff(before)
        word = substr(line, RSTART, RLENGTH)
        gsub(/^ | $/, "", word)
        line = substr(line, RSTART + RLENGTH)
        if (before != "" || (i > 1 && text[i - 1] != "")) print ".br"
        print ".I " (word ~ / / ? "\"" word "\"" : word)
    }
    gsub(/`/, "", line)
    if (line != "") print roff(line)
}

function declaration(    i, line) {
    begin()
    print ".EX"
    for (i = 1; i <= decl_count; i++) {
        line = decl[i]
        sub(/^PENUMBRA_API /, "", line)
        if (i > 1 && decl[1] ~ /^PENUMBRA_API/) sub(/^ +/, "        ", line)
        line = roff(line)
        print (decl[1] ~ /^PENUMBRA_API/ ? "\\fB" line "\\fR" : line)
    }
    print ".EE"
    begun = 0
    if (text_count) {
        print ".RS 4"
        flush()
        print ".RE"
    }
    decl_count = 0
}

BEGIN { begun = 1 }
/SPDX|^#|^extern|^}$/ { next }
/^\/\* ---- / {
    gsub(/^\/\* -+ | -+ \*\/$/, "")
    print ".SS " $0
    begun = 1
    next
}
!decl_count && (comment || /^\/\*/) {
    comment = 1
    last = sub(/ *\*\/$/, "")
    sub(/^(\/\*| \*) ?/, "")
    text[++text_count] = $0
    if (last) {
        comment = 0
        if (!described++) flush()
    }
    next
}
/^struct [a-z_]*; / {
    name = $1 " " $2
    sub(/;.*/, ";", name)
    sub(/^[^*]*\* /, "")
    sub(/ \*\/$/, "")
    print ".TP\n.B " name "\n" roff($0)
    next
}
decl_count || NF {
    if (!NF) next
    decl[++decl_count] = $0
    if ($0 ~ /^};|\);$/ && $0 !~ /^ .*\(\*/) declaration()
}

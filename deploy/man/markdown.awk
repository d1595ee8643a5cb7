# SPDX-License-Identifier: MIT
# Turns the Markdown of this project's pages into man source: headings, paragraphs, lists, `code`, **bold**
# and *emphasis*, fenced code, and tables, of which each row becomes a tagged paragraph.

function inline(line,    out, at, piece) {
    gsub(/\\\|/, "|", line)
    line = roff(line)
    out = ""
    while (match(line, /`[^`]*`|\*\*|\*[a-z]+\*/)) {
        piece = substr(line, RSTART, RLENGTH)
        out = out substr(line, 1, RSTART - 1)
        if (piece == "**") {
            bold = !bold
            out = out (bold ? "\\fI" : "\\fR")
        } else if (piece ~ /^\*/) {
            out = out "\\fI" substr(piece, 2, length(piece) - 2) "\\fR"
        } else {
            out = out "\\fB" substr(piece, 2, length(piece) - 2) (bold ? "\\fI" : "\\fR")
        }
        line = substr(line, RSTART + RLENGTH)
    }
    return out line
}

# The cells of a table's row: the bars between them are those without a backslash.
function cells(line, into,    n) {
    gsub(/\\\|/, "\001", line)
    sub(/^\| */, "", line)
    sub(/ *\|$/, "", line)
    n = split(line, into, / *\| */)
    for (i = 1; i <= n; i++) gsub(/\001/, "|", into[i])
    return n
}

function row(line,    n, i, cell) {
    n = cells(line, cell)
    print ".TP\n" inline(cell[1])
    for (i = 2; i < n; i++) {
        if (cell[i] ~ /^(required|exactly)/) print inline(toupper(substr(cell[i], 1, 1)) substr(cell[i], 2)) "."
        else print inline(toupper(substr(head[i], 1, 1)) substr(head[i], 2) ": " cell[i]) "."
    }
    if (n > 2 && cell[n] ~ /^[a-z]/) cell[n] = toupper(substr(cell[n], 1, 1)) substr(cell[n], 2)
    print inline(cell[n])
}

BEGIN { fresh = 1 } # behind a heading, where a paragraph has begun
/^```/ {
    fenced = !fenced
    print fenced ? ".PP\n.in +2n\n.EX" : ".EE\n.in"
    next
}
fenced { print roff($0); next }
/^# / { next }
/^## / { sub(/^## /, ""); print ".SH " toupper($0); table = 0; fresh = 1; next }
/^### / { sub(/^### /, ""); print ".SS " $0; table = 0; fresh = 1; next }
/^\|/ {
    if (!table) {
        table = 1
        fresh = 0
        split("", head)
        cells($0, head)
    } else if ($0 !~ /^\|-/) row($0)
    next
}
/^$/ { table = 0; gap = 1; next }
/^- / { print ".IP \\(bu 2\n" inline(substr($0, 3)); gap = fresh = 0; next }
{
    sub(/^  /, "") # within an item
    if (gap && !fresh) print ".PP"
    gap = fresh = 0
    print inline($0)
}

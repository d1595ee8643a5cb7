# SPDX-License-Identifier: MIT
# Turns what `PROGRAM --help` or `PROGRAM COMMAND --help` prints into man source. PART selects:
#   synopsis   the usage line
#   text       what stands between the usage line and the options
#   options    the options, a tagged paragraph each
#   exit       the exit codes, likewise
#   commands   the names of the commands, a word each, for the script that calls this one
# SKIP=1 leaves out --help and --version.

# Prose, in which `words` between backticks, also across lines, become bold.
function prose(line,    out) {
    line = roff(line)
    while (match(line, /`/)) {
        bold = !bold
        out = out substr(line, 1, RSTART - 1) (bold ? "\\fB" : "\\fR")
        line = substr(line, RSTART + 1)
    }
    return out line
}

function label(text,    words, n, i, out) {
    n = split(text, words, " ")
    for (i = 1; i <= n; i++) {
        if (words[i] !~ /^-/) out = out (i > 1 ? " " : "") "\\fI" roff(words[i]) "\\fR"
        else if (words[i] ~ /,$/) out = out (i > 1 ? " " : "") "\\fB" roff(substr(words[i], 1, length(words[i]) - 1)) "\\fR,"
        else out = out (i > 1 ? " " : "") "\\fB" roff(words[i]) "\\fR"
    }
    return out
}

function usage(text,    words, n, i, out, sep, word) {
    n = split(text, words, " ")
    out = ".B"
    for (i = 1; i <= n && words[i] !~ /[^a-z]/; i++) out = out " " words[i]
    if (i <= n) {
        out = out "\n.RI"
        for (sep = " "; i <= n; i++) {
            word = words[i]
            if (word ~ /^-/) out = out sep "\\fB" roff(word) "\\fR"
            else if (word == "[options]") out = out sep "[\\fIoptions\\fR]"
            else out = out sep "\\fI" roff(word) "\\fR"
            sep = "\\~"
        }
    }
    return out
}

/^Usage: / {
    sub(/^Usage: /, "")
    if (PART == "synopsis") print usage($0)
    section = "text"
    next
}
/^Options:$/ { section = "options"; next }
/^Exit codes:$/ { section = "exit"; next }
/^With(out)? .*:$/ { section = "commands"; next }
section != PART { next }
section == "text" {
    if ($0 == "") gap = printed
    else {
        if (gap) print ".PP"
        gap = 0
        printed = 1
        print prose($0)
    }
}
section == "commands" && /^  [a-z]/ { print $1 }
section == "options" && /^  (-|    --)/ {
    line = substr($0, 3)
    sub(/^ */, "", line)
    skipping = SKIP && line ~ /--(help|version) /
    if (skipping) next
    end = match(line, /  +[^ ]/)
    print ".TP"
    print label(end ? substr(line, 1, end - 1) : line)
    if (end) print prose(substr(line, RSTART + RLENGTH - 1))
    next
}
section == "options" && NF && !skipping { sub(/^ +/, ""); print prose($0) }
section == "exit" && NF {
    code = $1
    sub(/^ *[0-9]+ +/, "")
    print ".TP\n.B " code "\n" roff($0)
}

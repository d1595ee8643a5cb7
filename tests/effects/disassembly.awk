# SPDX-License-Identifier: MIT
# Judges the kernels of one object, whose disassembly (objdump -d -l -r) is the input: see
# disassembly.sh. Variables: object (block or pixel), prefix (of the functions of a kernel),
# kernels, markers (files).

# seen[f, m]: function f has an instruction of marker m. calls[f, g]: f refers to function g.
BEGIN {
    while ((getline line < markers) > 0) {
        split(line, part, " ")
        if (part[1] != object && part[1] != "both")
            continue
        label = part[3] == "line" ? substr(line, index(line, part[4])) : part[3] " " part[4]
        # Lines with the same text are one marker.
        id = part[2] " " (part[3] == "line" ? part[4] : label)
        if (part[3] == "line") {
            sub(/:[0-9]+/, "", id)
            text = label
            sub(/^[^ ]* /, "", text)
            id = id " " text
        }
        if (!(id in effects_of)) {
            order[++count] = id
            effects_of[id] = part[2]
        }
        by[part[3], part[4]] = by[part[3], part[4]] SUBSEP id
    }
    while ((getline line < kernels) > 0) {
        n = split(line, part, " ")
        kernel[++kernel_count] = part[1]
        for (i = 2; i <= n; i++)
            has[part[1], part[i]] = 1
    }
}

function mark(kind, what,    list, n, k) {
    if (!((kind, what) in by))
        return
    n = split(by[kind, what], list, SUBSEP)
    for (k = 2; k <= n; k++)
        seen[here, list[k]] = 1
}

function refer(name) {
    sub(/[+-]0x[0-9a-f]+$/, "", name)
    if (name == here)
        return
    calls[here] = calls[here] " " name
    mark("symbol", name)
}

# A reference to a function, unless the next line says that its place is still to be filled in.
function refer_pending() {
    if (pending != "")
        refer(pending)
    pending = ""
}

# The instruction's source: a line, and the lines from which it was inlined.
function place(what) {
    sub(/^.*\/src\//, "src/", what)
    places[depth++] = what
}

/^[0-9a-f]+ <.*>:$/ {
    refer_pending()
    here = $2
    gsub(/[<>:]/, "", here)
    found[here] = 1
    source = ""
    depth = 0
    next
}
/^[A-Za-z_][A-Za-z0-9_.]*\(\):$/ {
    refer_pending()
    source = $1
    sub(/\(\):$/, "", source)
    depth = 0
    next
}
/^inlined by / {
    refer_pending()
    if (!chain)
        depth = 1
    chain = 1
    caller = $4
    gsub(/[()]/, "", caller)
    callers[depth] = caller
    place($3)
    next
}
/^[^ \t].*:[0-9]+( \(discriminator [0-9]+\))?$/ {
    refer_pending()
    depth = 0
    place($1)
    chain = 1
    next
}
# A relocation: "2f73: R_X86_64_PLT32 pen_ray_make-0x4".
/R_X86_64_/ {
    pending = ""
    refer($3)
    next
}
/^ +[0-9a-f]+:\t/ {
    refer_pending()
    instructions[here]++
    chain = 0
    mark("fn", source)
    for (i = 0; i < depth; i++) {
        mark("line", places[i])
        if (i > 0)
            mark("fn", callers[i])
    }
    if ($0 ~ /(call|jmp|j[a-z]+) +[0-9a-f]+ <[^>]*>/) {
        pending = $0
        sub(/^.*</, "", pending)
        sub(/>.*$/, "", pending)
    }
}

# Collects the functions that a kernel consists of, in its own object.
function reach(name,    list, n, i) {
    if (!(name in found) || (name in reached))
        return
    reached[name] = 1
    n = split(calls[name], list, " ")
    for (i = 1; i <= n; i++)
        reach(list[i])
    reach(name ".cold")
}

# Whether a kernel with these effects shows the marker.
function wanted(k, effects,    part, n, i) {
    if (effects ~ /\//) {
        n = split(effects, part, "/")
        for (i = 1; i <= n; i++)
            if ((k, part[i]) in has)
                return 1
        return 0
    }
    if (effects ~ /\+/) {
        n = split(effects, part, "+")
        for (i = 1; i <= n; i++)
            if (!((k, part[i]) in has))
                return 0
        return 1
    }
    return (k, effects) in has
}

END {
    refer_pending()
    roots = split(prefix, root, " ")
    for (i = 1; i <= kernel_count; i++) {
        k = kernel[i]
        split("", reached)
        for (r = 1; r <= roots; r++) {
            if (!((root[r] k) in found)) {
                print "no function " root[r] k
                failed = 1
            }
            reach(root[r] k)
        }
        size = shown = 0
        for (f in reached)
            size += instructions[f]
        for (m = 1; m <= count; m++) {
            id = order[m]
            is = 0
            for (f in reached)
                if ((f, id) in seen)
                    is = 1
            shown += is
            want = wanted(k, effects_of[id])
            if (is != want) {
                printf "  %s %s: %s\n", k, want ? "lacks" : "has", id
                failed = 1
            }
        }
        printf "  %-28s %6d instructions, %2d of %2d markers\n", k, size, shown, count
    }
    # The last kernel has all effects, and each shows by a marker.
    for (key in has) {
        split(key, part, SUBSEP)
        if (part[1] != kernel[kernel_count])
            continue
        shows = 0
        for (m = 1; m <= count; m++)
            if (("/" effects_of[order[m]] "/") ~ ("/" part[2] "/"))
                shows = 1
        if (!shows) {
            print "no marker for " part[2]
            failed = 1
        }
    }
    if (kernel_count == 0 || count == 0) {
        print "no kernels, or no markers"
        failed = 1
    }
    exit failed
}

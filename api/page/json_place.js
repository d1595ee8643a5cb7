/* SPDX-License-Identifier: MIT */
/* Finds the place of a JSON Pointer (RFC 6901) in a text. */

/* Returns {start, end}, the offsets of the value that the pointer names. If the text lacks it, those of its
 * nearest parent. Returns null if the text is not valid JSON. For a pointer to a key of an object, start is
 * that of the key. */
export function findPointer(text, pointer) {
    const path = pointer.split("/").slice(1).map((part) => part.replace(/~1/g, "/").replace(/~0/g, "~"));
    let at = 0;
    let best = null;

    const space = () => {
        while (/\s/.test(text[at] || ""))
            at++;
    };
    const string = () => {
        const start = at;
        for (at++; text[at] !== '"'; at++) {
            if (text[at] === undefined)
                throw new SyntaxError();
            if (text[at] === "\\")
                at++;
        }
        at++;
        return JSON.parse(text.slice(start, at));
    };
    /* Reads members or elements. depth: how much of the path leads here, -1 if it does not. */
    const list = (end, depth, key) => {
        at++;
        space();
        for (let i = 0; text[at] !== end; i++) {
            const start = at;
            const name = key(i);
            const on = depth >= 0 && depth < path.length && name === path[depth];
            value(on ? depth + 1 : -1, start);
            space();
            if (text[at] === ",")
                at++;
            else if (text[at] !== end)
                throw new SyntaxError();
            space();
        }
        at++;
    };
    const member = () => {
        const name = string();
        space();
        at++; // the colon
        space();
        return name;
    };
    const value = (depth, start) => {
        space();
        const known = best;
        if (text[at] === "{")
            list("}", depth, member);
        else if (text[at] === "[")
            list("]", depth, (i) => String(i));
        else if (text[at] === '"')
            string();
        else
            at += /^[^\s,\]}]+/.exec(text.slice(at, at + 64))[0].length;
        if (depth >= 0 && best === known)
            best = {start, end: at};
    };
    try {
        space();
        value(0, at);
    } catch {
        return null;
    }
    return best;
}

/* The offset of a line and column, both from 1; columns count code points. */
export function findLine(text, line, column) {
    let start = 0;
    for (let i = 1; i < line; i++) {
        const next = text.indexOf("\n", start);
        if (next < 0)
            break;
        start = next + 1;
    }
    const end = text.indexOf("\n", start);
    const before = Array.from(text.slice(start, end < 0 ? undefined : end)).slice(0, (column || 1) - 1).join("");
    return {start: start + before.length, end: end < 0 ? text.length : end};
}

export const lineOf = (text, offset) => text.slice(0, offset).split("\n").length;

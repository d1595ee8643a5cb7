/* SPDX-License-Identifier: MIT */
/* The editor of a scene's text: paste, drop, line numbers, and marks at lines with errors. `problems` is the
 * box of the error sentences. */

import {button, el, put} from "./dom.js";
import {bytes} from "./format.js";
import {findLine, findPointer, lineOf} from "./json_place.js";

const SHOWN = 1 << 20; // characters; a longer text is kept, but not shown
const KEPT = "penumbra-scene";

/* Calls changed() after each change of the text. */
export function makeEditor(changed) {
    let hidden = null; // the text, if it is too long to be shown
    let marks = new Map(); // line → sentences
    const numbers = el("div", {class: "numbers", "aria-hidden": "true"});
    const area = el("textarea", {
        id: "scene", spellcheck: "false", autocapitalize: "off", wrap: "off", "aria-describedby": "problems",
        placeholder: 'Paste a scene in JSON or XML, or drop a file here.\n\nA scene in JSON begins with {"format": "penumbra-scene/1", …}',
    });
    const large = el("p", {class: "large", hidden: true});
    const problems = el("div", {id: "problems", role: "status"});

    const drawNumbers = () => {
        const lines = area.value.split("\n").length;
        put(numbers, Array.from({length: lines}, (_, i) =>
            el("span", marks.has(i + 1) ? {class: "wrong", title: marks.get(i + 1).join("\n")} : null, String(i + 1))));
        numbers.scrollTop = area.scrollTop;
    };
    const edited = () => {
        marks = new Map();
        drawNumbers();
        try {
            sessionStorage.setItem(KEPT, area.value);
        } catch {
            // no space: reloading the page then loses the text
        }
        changed();
    };
    const setText = (text) => {
        hidden = text.length > SHOWN ? text : null;
        area.value = hidden ? "" : text;
        area.hidden = numbers.hidden = !!hidden;
        large.hidden = !hidden;
        put(large, `The scene has ${bytes(text.length)}. It is too long to be shown. `,
            button("Use another scene", () => setText("")));
        edited();
    };
    const select = (start, end) => {
        area.focus();
        area.setSelectionRange(start, end);
        area.scrollTop = (lineOf(area.value, start) - 3) * parseFloat(getComputedStyle(area).lineHeight);
    };

    area.addEventListener("input", edited);
    area.addEventListener("scroll", () => { numbers.scrollTop = area.scrollTop; });
    const open = el("input", {type: "file", accept: ".json,.xml", id: "scene-file"});
    const load = async (file) => { if (file) setText(await file.text()); };
    open.addEventListener("change", () => load(open.files[0]));
    const box = el("div", {class: "editor"},
        el("div", {class: "row"},
            el("label", {for: "scene"}, "Scene, JSON or XML"),
            el("label", {for: "scene-file", class: "file"}, "Open a file: ", open)),
        el("div", {class: "text"}, numbers, area), large);
    box.addEventListener("dragover", (event) => event.preventDefault());
    box.addEventListener("drop", (event) => {
        const file = event.dataTransfer.files[0];
        if (!file)
            return;
        event.preventDefault();
        load(file);
    });
    area.value = sessionStorage.getItem(KEPT) || "";
    drawNumbers();

    const placeOf = (entry) => {
        if (entry.line)
            return findLine(area.value, entry.line, entry.column);
        return entry.pointer == null ? null : findPointer(area.value, entry.pointer);
    };
    const item = (entry, kind) => {
        const found = placeOf(entry);
        if (!found)
            return el("li", {class: kind}, `${entry.pointer ? `${entry.pointer}: ` : ""}${entry.detail}`);
        const line = lineOf(area.value, found.start);
        if (kind === "error")
            marks.set(line, [...(marks.get(line) || []), entry.detail]);
        return el("li", {class: kind}, button(`line ${line}`, () => select(found.start, found.end)), ` ${entry.detail}`);
    };
    return {
        box,
        problems,
        text: () => hidden ?? area.value,
        setText,
        /* Shows lists of {pointer | line, column, detail} below the text and at its lines. */
        show(errors, warnings, sentence) {
            marks = new Map();
            put(problems,
                sentence && el("p", {class: errors.length ? "error" : "good"}, sentence),
                errors.length + warnings.length > 0 &&
                    el("ul", null, errors.map((entry) => item(entry, "error")), warnings.map((entry) => item(entry, "warning"))));
            drawNumbers();
        },
    };
}

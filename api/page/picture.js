/* SPDX-License-Identifier: MIT */
/* Shows a picture with zoom, and the values of a pixel. */

import {button, el, put} from "./dom.js";
import {call} from "./api.js";
import {bytes, number} from "./format.js";

const ZOOMS = [0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32];
const HEAD = 64; // bytes that hold the head of a PFM file

/* Reads a PFM file: three lines of text, then rows of floats, the bottom row first. */
export function parsePfm(buffer) {
    const head = new TextDecoder("latin1").decode(buffer.slice(0, HEAD));
    const [, kind, width, height, scale] = /^(PF|Pf)\s(\d+)\s(\d+)\s(\S+)\s/.exec(head);
    const channels = kind === "PF" ? 3 : 1;
    const start = /^\S+\s\S+\s\S+\s\S+\s/.exec(head)[0].length;
    const view = new DataView(buffer, start);
    const little = Number(scale) < 0;
    return {
        width: Number(width),
        height: Number(height),
        at(x, y) {
            const first = ((height - 1 - y) * width + x) * channels;
            return Array.from({length: channels}, (_, c) => view.getFloat32((first + c) * 4, little));
        },
    };
}

/* Returns {box, show(address, exactPath)}. exactPath names the same picture as PFM; it may be null. */
export function makePicture(label, signal) {
    const image = el("img", {alt: label, draggable: "false"});
    const mark = el("div", {class: "mark", hidden: true});
    const inner = el("div", {class: "inner"}, image, mark);
    const view = el("div", {class: "view", tabindex: "0", role: "group",
        "aria-label": `${label}. Arrow keys choose a pixel; plus and minus zoom; 0 fits.`}, inner);
    const values = el("output", {class: "values", "aria-live": "polite"}, "Point at a pixel to read its values.");
    let scale = 0; // 0: as wide as the view
    let exact = null; // the floats
    let exactPath = null;
    let pixels = null; // the canvas with the 8-bit values
    let chosen = null;

    const factor = () => scale || Math.min(1, box.clientWidth / (image.naturalWidth || 1));
    const layOut = () => {
        inner.style.width = `${image.naturalWidth * factor()}px`;
        image.classList.toggle("sharp", factor() > 1);
        moveMark();
    };
    const moveMark = () => {
        mark.hidden = !chosen || factor() < 2;
        if (mark.hidden)
            return;
        mark.style.left = `${chosen.x * factor()}px`;
        mark.style.top = `${chosen.y * factor()}px`;
        mark.style.width = mark.style.height = `${factor()}px`;
    };
    const zoom = (step) => {
        const now = factor();
        const wider = ZOOMS.filter((z) => (step > 0 ? z > now * 1.01 : z < now * 0.99));
        const next = step > 0 ? wider[0] : wider[wider.length - 1];
        if (!next)
            return;
        const x = (view.scrollLeft + view.clientWidth / 2) / now;
        const y = (view.scrollTop + view.clientHeight / 2) / now;
        scale = next;
        layOut();
        view.scrollTo(x * next - view.clientWidth / 2, y * next - view.clientHeight / 2);
    };
    const fit = () => {
        scale = 0;
        layOut();
    };
    const context = () => {
        if (!pixels) {
            pixels = el("canvas", {width: image.naturalWidth, height: image.naturalHeight});
            pixels.getContext("2d", {willReadFrequently: true}).drawImage(image, 0, 0);
        }
        return pixels.getContext("2d");
    };
    const tell = (x, y) => {
        if (!image.naturalWidth)
            return;
        chosen = {x: Math.max(0, Math.min(image.naturalWidth - 1, x)), y: Math.max(0, Math.min(image.naturalHeight - 1, y))};
        const [r, g, b] = context().getImageData(chosen.x, chosen.y, 1, 1).data;
        const floats = exact ? `; exactly ${exact.at(chosen.x, chosen.y).map(number).join(", ")}` : "";
        put(values, `x ${chosen.x}, y ${chosen.y}: ${r}, ${g}, ${b} of 255${floats}`);
        moveMark();
    };
    view.addEventListener("pointermove", (event) => {
        const box = image.getBoundingClientRect();
        tell(Math.floor((event.clientX - box.left) / factor()), Math.floor((event.clientY - box.top) / factor()));
    });
    view.addEventListener("keydown", (event) => {
        const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
        const actions = {"+": () => zoom(1), "=": () => zoom(1), "-": () => zoom(-1), 0: fit};
        const step = steps[event.key];
        if (step) {
            const {x, y} = chosen || {x: 0, y: 0};
            const size = event.shiftKey ? 10 : 1;
            tell(x + step[0] * size, y + step[1] * size);
            if (!mark.hidden)
                mark.scrollIntoView({block: "nearest", inline: "nearest"});
        } else if (actions[event.key] && !event.ctrlKey && !event.metaKey) {
            actions[event.key]();
        } else {
            return;
        }
        event.preventDefault();
    });
    const exactButton = button("Exact values", async () => {
        exactButton.disabled = true;
        const path = exactPath;
        const response = await call(path, {signal});
        const loaded = parsePfm(await response.arrayBuffer());
        if (path !== exactPath)
            return;
        exact = loaded;
        tell(chosen?.x ?? 0, chosen?.y ?? 0);
    });
    image.addEventListener("load", () => {
        pixels = null;
        layOut();
    });
    window.addEventListener("resize", layOut, {signal});
    const box = el("div", {class: "picture"}, view,
        el("div", {class: "row"},
            button("−", () => zoom(-1), {"aria-label": "Smaller"}), button("Fit", fit), button("1:1", () => { scale = 1; layOut(); }),
            button("+", () => zoom(1), {"aria-label": "Larger"}), exactButton, values));
    return {
        box,
        show(address, path) {
            image.src = address;
            exact = null;
            exactPath = path;
            exactButton.hidden = !path;
            exactButton.disabled = false;
        },
        /* Shows the size of the floats before they are loaded. */
        size: (width, height) => { exactButton.title = `Loads the picture as floats, ${bytes(width * height * 12)}`; },
    };
}

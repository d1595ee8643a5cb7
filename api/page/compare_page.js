/* SPDX-License-Identifier: MIT */
/* The pictures of two jobs under a slider, their metrics, and the map of their difference (FLIP). */

import {address, get} from "./api.js";
import {el, field, problemBox, put, table} from "./dom.js";
import {number, title} from "./format.js";

const NAMES = {
    rmse: "RMSE", relative_mse: "Relative MSE", psnr: "PSNR, dB", ssim: "SSIM", flip: "FLIP", max_error: "Largest error",
    max_difference: "Largest difference", different_pixels: "Different pixels",
};

function slider(left, right, names) {
    const under = el("img", {alt: `Picture of ${names[1]}`, src: right});
    const over = el("img", {alt: `Picture of ${names[0]}`, src: left});
    const line = el("div", {class: "line"});
    const control = field(`Left of the line: ${names[0]}. Right: ${names[1]}.`, "input", {type: "range", min: "0", max: "100", value: "50"});
    const move = () => {
        over.style.clipPath = `inset(0 ${100 - control.input.value}% 0 0)`;
        line.style.left = `${control.input.value}%`;
    };
    control.input.addEventListener("input", move);
    const stack = el("div", {class: "stack"}, under, over, line);
    stack.addEventListener("pointermove", (event) => {
        if (event.pointerType === "mouse" && event.buttons === 0)
            return;
        const box = stack.getBoundingClientRect();
        control.input.value = String((100 * (event.clientX - box.left)) / box.width);
        move();
    });
    move();
    return el("div", {class: "slider"}, stack, control.box);
}

export async function show(main, query, signal, [a, b]) {
    document.title = "Compare – Penumbra";
    put(main, el("h1", null, "Compare"), el("p", {role: "status"}, "Loading both pictures …"));
    try {
        const [measures, first, second, left, right, map] = await Promise.all([
            get(`v1/jobs/${a}/compare?with=${b}`, signal), get(`v1/jobs/${a}`, signal), get(`v1/jobs/${b}`, signal),
            address(`v1/jobs/${a}/image`, signal), address(`v1/jobs/${b}/image`, signal),
            address(`v1/jobs/${a}/compare?with=${b}&format=png`, signal)]);
        const names = [title(first), title(second)];
        const rows = Object.entries(measures).filter(([, value]) => typeof value !== "object")
            .map(([name, value]) => [NAMES[name] || name.replaceAll("_", " "), number(value)]);
        put(main, el("h1", null, "Compare"),
            el("p", null, el("a", {href: `#/job/${a}`}, names[0]), " and ", el("a", {href: `#/job/${b}`}, names[1])),
            slider(left, right, names),
            el("figure", null, el("img", {class: "map", src: map, alt: "Map of the differences that people see"}),
                el("figcaption", null, "FLIP map: how strongly a viewer who flips between both pictures sees a difference. Black is none. A mean of 0.02 is hardly seen.")),
            table("Measures", null, rows));
    } catch (error) {
        if (signal.aborted)
            return;
        put(main, el("h1", null, "Compare"), problemBox(error.errors ? error : {message: String(error), errors: []}),
            el("p", null, el("a", {href: "#/jobs?state=succeeded"}, "Choose two renders of the same size")));
    }
}

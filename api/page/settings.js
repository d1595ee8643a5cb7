/* SPDX-License-Identifier: MIT */
/* The form of a job's settings. An empty field keeps the scene's own value. */

import {el, field} from "./dom.js";

const KINDS = [
    ["render", "Render a picture"],
    ["accuracy", "Measure what accuracy costs in time"],
    ["effects", "Measure what each effect costs"],
    ["benchmark", "Benchmark: time several settings"],
];
const LAYERS = ["depth", "normal", "albedo", "samples", "cost"];
const MATRIX = '{"accelerator": ["none", "auto"], "threads": [1, 0]}';

class WrongField extends Error {
    constructor(input, message) {
        super(message);
        this.errors = [];
        input.focus();
    }
}

function parsed(input, what) {
    if (!input.value.trim())
        return {};
    try {
        return JSON.parse(input.value);
    } catch (error) {
        throw new WrongField(input, `${what} is not JSON: ${error.message}. Write for example {"max_depth": 5}.`);
    }
}

/* Calls changed() after each change. */
export function makeSettings(changed) {
    const fields = {};
    const add = (name, label, control, attributes, options) => {
        fields[name] = field(label, control, attributes, options);
        return fields[name].box;
    };
    const whole = (placeholder) => ({type: "number", min: "1", step: "1", inputmode: "numeric", placeholder});
    const some = (placeholder) => ({type: "number", min: "0", step: "any", inputmode: "decimal", placeholder});
    const layers = LAYERS.map((name) => ({name, input: el("input", {type: "checkbox", id: `layer-${name}`})}));
    const only = (kind, ...boxes) => el("div", {class: "only", "data-kind": kind}, boxes);
    const box = el("form", {class: "settings", "aria-label": "Settings"},
        add("kind", "What to do", "select", null, KINDS),
        el("div", {class: "pair"},
            add("width", "Width, pixels", "input", whole("the scene's")),
            add("height", "Height, pixels", "input", whole("the scene's"))),
        only("render",
            add("samples_per_pixel", "Samples per pixel", "input", whole("the scene's")),
            add("target_error", "Or as many as this error takes (0.01: good)", "input", some("no target")),
            add("budget_seconds", "Or the best picture in so many seconds", "input", some("no limit")),
            el("fieldset", null, el("legend", null, "Layers beside the picture"),
                layers.map(({name, input}) => el("label", {class: "check", for: input.id}, input, name)))),
        only("accuracy",
            add("target", "Find the cheapest setting with a FLIP error below", "input", some("0.02")),
            add("study_seconds", "Time for the study, seconds", "input", some("60"))),
        only("benchmark",
            add("matrix", "Settings to combine, as JSON", "input", {type: "text", value: MATRIX, spellcheck: "false"}),
            add("repeats", "Timed runs of each", "input", whole("3"))),
        el("details", null, el("summary", null, "More"),
            add("name", "Name of the job", "input", {type: "text", maxlength: "200"}),
            add("views", "Views, separated by spaces", "input", {type: "text", placeholder: "all"}),
            add("priority", "Priority, −100 to 100", "input", {type: "number", min: "-100", max: "100", step: "1", placeholder: "0"}),
            add("render", "Other render settings, as JSON", "input", {type: "text", spellcheck: "false", placeholder: '{"light_samples": 16}'})));
    const value = (name) => fields[name].input.value.trim();
    const adjust = () => {
        for (const part of box.querySelectorAll(".only"))
            part.hidden = part.dataset.kind !== value("kind");
    };
    box.addEventListener("submit", (event) => event.preventDefault());
    box.addEventListener("input", () => {
        adjust();
        changed();
    });
    adjust();

    const numbers = (target, names) => {
        for (const name of names) {
            if (!fields[name].input.validity.valid)
                throw new WrongField(fields[name].input, `${fields[name].box.textContent}: ${fields[name].input.validationMessage}`);
            if (value(name))
                target[name] = Number(value(name));
        }
    };
    /* The keys of a job except its scene. Throws an Error whose message names the field. */
    const job = () => {
        const kind = value("kind");
        const result = {kind, render: parsed(fields.render.input, "The field of other settings")};
        numbers(result.render, ["width", "height"]);
        numbers(result, ["priority"]);
        if (value("name"))
            result.name = value("name");
        if (value("views"))
            result.views = value("views").split(/[\s,]+/);
        if (kind === "render") {
            numbers(result.render, ["samples_per_pixel", "target_error"]);
            numbers(result, ["budget_seconds"]);
            const chosen = layers.filter(({input}) => input.checked).map(({name}) => name);
            if (chosen.length)
                result.layers = ["beauty", ...chosen];
        } else if (kind === "accuracy") {
            if (value("target"))
                result.target = {metric: "flip", value: Number(value("target"))};
            if (value("study_seconds"))
                result.budget_seconds = Number(value("study_seconds"));
        } else if (kind === "benchmark") {
            result.matrix = parsed(fields.matrix.input, "The field of settings to combine");
            numbers(result, ["repeats"]);
        }
        return result;
    };
    return {box, job};
}

/* SPDX-License-Identifier: MIT */
/* The page of a new picture: the built-in scenes, the editor, the settings, the explanation, submit. */

import {get, post, call, randomKey, Problem, sleep} from "./api.js";
import {button, el, problemBox, put} from "./dom.js";
import {makeEditor} from "./editor.js";
import {count, time} from "./format.js";
import {makeSettings} from "./settings.js";

const PAUSE_MS = 500; // after the last change, before the daemon is asked

/* The body of a job. The scene's text stays as it is, on its own lines, so that errors keep their places. */
export function jobText(scene, job) {
    const rest = Object.entries(job).map(([key, value]) => `,\n${JSON.stringify(key)}:${JSON.stringify(value)}`);
    const text = /^\s*</.test(scene) ? JSON.stringify(scene) : scene;
    return `{"scene":\n${text}\n${rest.join("")}}`;
}

/* The name in a scene, for lists of jobs; undefined without a name. */
function sceneName(scene) {
    try {
        const name = /^\s*</.test(scene)
            ? new DOMParser().parseFromString(scene, "application/xml").documentElement.getAttribute("name")
            : JSON.parse(scene).name;
        return name ? Array.from(String(name)).slice(0, 200).join("") : undefined;
    } catch {
        return undefined; // the daemon says what is wrong
    }
}

/* Converts places in a job to places in its scene. For errors of other keys, the sentence has the pointer. */
function inScene(error, xml) {
    if (error.line)
        return xml ? error : {...error, line: error.line - 1};
    if (error.pointer === "/scene" || error.pointer?.startsWith("/scene/"))
        return {...error, pointer: error.pointer.slice("/scene".length)};
    return {detail: error.pointer ? `Setting ${error.pointer.slice(1).replaceAll("/", ".")}: ${error.detail}` : error.detail};
}

function explanationBox(explanation, kind) {
    const names = (list) => list.map((effect) => effect.name.replaceAll("_", " ")).join(", ") || "no effects";
    const {expected, low, high} = explanation.time_ms;
    const subject = kind === "render" ? "It takes" : "One picture takes";
    return [
        el("p", {class: "good"}, `This scene calls for ${names(explanation.effects)}. ${subject} about ${time(expected)} here (${time(low)} to ${time(high)}), and traces ${count(explanation.rays.total.expected)} rays.`),
        el("details", null, el("summary", null, "Why, and what is left out"),
            el("ul", null, explanation.effects.map((effect) =>
                el("li", null, el("b", null, effect.name.replaceAll("_", " ")), ` – ${effect.because}`))),
            el("p", null, "No rays, branches or memory for:"),
            el("ul", null, explanation.absent.map((effect) =>
                el("li", null, el("b", null, effect.name.replaceAll("_", " ")), ` – ${effect.because}`)))),
    ];
}

function gallery(editor, signal) {
    const list = el("ul", {class: "gallery"});
    get("v1/scenes", signal).then(({scenes}) => put(list, scenes.map((scene) =>
        el("li", null, button([
            el("img", {src: `page/scene-${scene.name}.png`, alt: "", width: "120", height: "120", loading: "lazy"}),
            el("b", null, scene.name), el("span", null, scene.title),
        ], async () => {
            const response = await call(scene.href.replace(/^\//, ""), {signal});
            editor.setText(await response.text());
        }, {"aria-label": `${scene.name}: ${scene.title}`}))))).catch(() => {});
    return el("section", {"aria-labelledby": "gallery-title"},
        el("h2", {id: "gallery-title"}, "Begin with a scene"), list);
}

export function show(main, query, signal) {
    document.title = "New picture – Penumbra";
    let checks = new AbortController();
    const explanation = el("div", {class: "explanation", role: "status"});
    const submitProblem = el("div");

    const check = async (abort) => {
        const scene = editor.text();
        if (!scene.trim()) {
            editor.show([], [], null);
            return;
        }
        const xml = /^\s*</.test(scene);
        const job = settings.job();
        try {
            const answer = await (await post("v1/validate", jobText(scene, job), abort)).json();
            editor.show([], answer.warnings.map((warning) => inScene(warning, xml)), "The scene is valid.");
        } catch (problem) {
            if (!(problem instanceof Problem))
                throw problem;
            const errors = problem.errors.length ? problem.errors : [{detail: problem.message}];
            editor.show(errors.map((error) => inScene(error, xml)), [], errors.length === 1 ? "One error:" : `${errors.length} errors:`);
            return;
        }
        put(explanation, "Counting what the scene calls for …");
        const asked = {render: job.render, ...(job.views?.length ? {views: job.views.slice(0, 1)} : {})};
        const response = await post("v1/explain", jobText(scene, asked), abort);
        if (response.status === 200)
            put(explanation, explanationBox(await response.json(), job.kind));
        else
            put(explanation, "The estimate takes longer than 10 seconds; the job can be submitted nevertheless.");
    };
    const changed = async () => {
        checks.abort();
        checks = new AbortController();
        const abort = AbortSignal.any([signal, checks.signal]);
        put(explanation);
        try {
            await sleep(PAUSE_MS, abort);
            await check(abort);
        } catch (error) {
            if (!abort.aborted)
                put(explanation, problemBox(error.errors ? error : new Problem(0, {detail: String(error)})));
        }
    };
    const editor = makeEditor(changed);
    const settings = makeSettings(changed);
    const submit = async () => {
        put(submitProblem);
        go.disabled = true;
        try {
            const job = settings.job();
            job.name ||= sceneName(editor.text());
            const body = jobText(editor.text(), job);
            const response = await post("v1/jobs", body, signal, {"Idempotency-Key": randomKey()});
            checks.abort();
            location.hash = `#/job/${(await response.json()).id}`;
        } catch (error) {
            if (!signal.aborted)
                put(submitProblem, problemBox(error.errors ? error : new Problem(0, {detail: String(error)})));
        } finally {
            go.disabled = false;
        }
    };
    const go = button("Submit", submit, {class: "primary", id: "submit"});
    put(main, el("h1", null, "New picture"), gallery(editor, signal),
        el("section", {class: "work", "aria-label": "Scene and settings"}, editor.box, settings.box),
        el("div", {class: "verdict"}, el("div", null, editor.problems, explanation, submitProblem), go));
    const wanted = query.get("scene");
    if (wanted)
        call(`v1/jobs/${wanted}/scene`, {signal}).then((response) => response.text()).then(editor.setText).catch(() => {});
    else
        changed();
}

/* SPDX-License-Identifier: MIT */
/* The list of jobs: thumbnails, chips of states with counts, paging, and the choice of two jobs to compare.
 * The address contains the filters. */

import {address, get, sleep} from "./api.js";
import {button, el, field, put} from "./dom.js";
import {date, percent, time, title} from "./format.js";

const PAGE = 20;
const REFRESH_MS = 2000;
const STATES = ["queued", "running", "succeeded", "failed", "cancelled"];

export const stateBadge = (state) => el("span", {class: `state ${state}`}, state);

const hash = (query, change) => {
    const next = new URLSearchParams(query);
    for (const [name, value] of Object.entries(change))
        value ? next.set(name, value) : next.delete(name);
    return `#/jobs${next.size ? `?${next}` : ""}`;
};

function chips(query, counts) {
    const chip = (state, text) => el("a", {
        class: "chip", href: hash(query, {state, cursor: ""}), "aria-current": (query.get("state") || "") === state ? "true" : null,
    }, counts && state ? `${text} ${counts[state] ?? 0}` : text);
    return el("nav", {class: "chips", "aria-label": "States"}, chip("", "all"), STATES.map((state) => chip(state, state)));
}

function when(job) {
    if (job.state === "running")
        return `${percent(job.progress.fraction)}${job.progress.eta_seconds != null ? `, ${time(job.progress.eta_seconds * 1000)} left` : ""}`;
    if (job.started_at && job.finished_at)
        return time(new Date(job.finished_at) - new Date(job.started_at));
    return "";
}

export function show(main, query, signal) {
    document.title = "Jobs – Penumbra";
    const thumbnails = new Map(); // id → promise of an address
    const chosen = new Set();
    const top = el("div");
    const list = el("ul", {class: "jobs"});
    const paging = el("div", {class: "row"});
    const compare = button("Compare", () => { location.hash = `#/compare/${[...chosen].join("/")}`; }, {disabled: true});
    const hint = el("span", null, "Choose two finished renders to compare them.");
    const name = field("Name", "input", {type: "search", value: query.get("name") || ""});
    const kind = field("Kind", "select", null,
        [["", "all kinds"], ["render", "renders"], ["benchmark", "benchmarks"], ["accuracy", "accuracy studies"], ["effects", "bills of effects"]]);
    kind.input.value = query.get("kind") || "";
    kind.input.addEventListener("change", () => { location.hash = hash(query, {kind: kind.input.value, cursor: ""}); });
    name.input.addEventListener("change", () => { location.hash = hash(query, {name: name.input.value, cursor: ""}); });

    const thumbnail = (job) => {
        if (job.state !== "succeeded" || job.kind !== "render")
            return el("span", {class: "thumb"});
        const image = el("img", {class: "thumb", alt: "", width: "64", height: "64"});
        if (!thumbnails.has(job.id))
            thumbnails.set(job.id, address(`v1/jobs/${job.id}/image?max_edge=128`, signal));
        thumbnails.get(job.id).then((url) => { image.src = url; }, () => {});
        return image;
    };
    const choose = (job) => {
        if (job.state !== "succeeded" || job.kind !== "render")
            return el("span", {class: "choose"});
        const box = el("input", {type: "checkbox", class: "choose", "aria-label": `Compare ${title(job)}`});
        box.checked = chosen.has(job.id);
        box.addEventListener("change", () => {
            box.checked ? chosen.add(job.id) : chosen.delete(job.id);
            compare.disabled = chosen.size !== 2;
            put(hint, chosen.size === 2 ? "" : "Choose two finished renders to compare them.");
        });
        return box;
    };
    const row = (job) => el("li", null, choose(job),
        el("a", {href: `#/job/${job.id}`}, thumbnail(job),
            el("span", {class: "what"}, el("b", null, title(job)),
                el("span", null, `${job.kind}, ${job.render.width}×${job.render.height}, ${date(job.created_at)}`))),
        el("span", {class: "when"}, stateBadge(job.state), el("span", null, when(job))));

    let shown = "";
    const refresh = async () => {
        const asked = new URLSearchParams(query);
        asked.set("limit", String(PAGE));
        const answer = await get(`v1/jobs?${asked}`, signal);
        const key = JSON.stringify([answer.jobs.map((job) => [job.id, job.revision, job.progress]), answer.counts, answer.next]);
        if (key === shown)
            return; // so that nothing moves under a pointer or a screen reader
        shown = key;
        const focused = list.contains(document.activeElement) && document.activeElement.closest("li");
        const at = focused ? [...list.children].indexOf(focused) : -1;
        const link = focused && document.activeElement.matches("a");
        put(top, chips(query, answer.counts));
        put(list, answer.jobs.map(row));
        if (at >= 0)
            list.children[at]?.querySelector(link ? "a" : "input")?.focus();
        put(paging,
            query.get("cursor") && el("a", {class: "button", href: hash(query, {cursor: ""})}, "Newest"),
            answer.next && el("a", {class: "button", href: hash(query, {cursor: answer.next})}, "Older"),
            answer.jobs.length === 0 && el("p", null, "There are no such jobs."));
    };
    put(main, el("h1", null, "Jobs"), top,
        el("div", {class: "row filters"}, kind.box, name.box), list, paging,
        el("div", {class: "row"}, compare, hint));
    (async () => {
        for (;;) {
            if (!document.hidden)
                await refresh();
            await sleep(REFRESH_MS, signal);
        }
    })().catch((error) => { if (!signal.aborted) put(list, el("li", {role: "alert"}, error.message)); });
}

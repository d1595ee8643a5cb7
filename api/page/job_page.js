/* SPDX-License-Identifier: MIT */
/* The page of one job: progress, the picture as it arrives, layers, statistics, report. */

import {address, call, download, get, jobEvents, post, sleep} from "./api.js";
import {button, el, field, problemBox, put, table} from "./dom.js";
import {bytes, count, date, number, percent, time, title} from "./format.js";
import {stateBadge} from "./jobs_page.js";
import {makePicture} from "./picture.js";

const PREVIEW_MS = 400; // between two previews, at least
const RATE_MS = 1000;

const ended = (job) => ["succeeded", "failed", "cancelled"].includes(job.state);
const failed = (error) => problemBox(error.errors ? error : {message: String(error), errors: []});

function progressBox(job, rate) {
    const {fraction, eta_seconds: left, done, total} = job.progress;
    const facts = [];
    if (job.state === "queued")
        facts.push(job.queue_position ? `number ${job.queue_position} in the queue` : "waits for a worker");
    facts.push(`${percent(fraction)}, ${count(done)} of ${count(total)} ${job.kind === "render" ? "pixels" : "runs"}`);
    if (left != null)
        facts.push(`${time(left * 1000)} left`);
    if (rate != null)
        facts.push(`${count(rate)} rays per second`);
    return [el("progress", {max: "1", value: String(fraction), "aria-label": "Progress"}), el("p", null, facts.join(", "))];
}

/* Shows the rays per second of the committed work, until the signal aborts. */
async function watchRate(id, signal, tell) {
    for (;;) {
        const stats = await get(`v1/jobs/${id}/stats?so_far=true`, signal);
        if (stats.rays.total > 0)
            tell(stats.mrays_per_second * 1e6);
        await sleep(RATE_MS, signal);
    }
}

function statisticsBox(stats) {
    const ms = Object.entries(stats.timing).map(([name, value]) => [name.replace(/_ms$/, "").replaceAll("_", " "), time(value)]);
    const rays = Object.entries(stats.rays).map(([name, value]) => [name, count(value)]);
    const more = [
        ["rays per second", count(stats.mrays_per_second * 1e6)], ["threads", number(stats.threads)], ["kernel", stats.kernel],
        ["accelerator", stats.accelerator.choice || stats.accelerator.kind || "–"], ["memory, peak", bytes(stats.memory.peak_bytes)],
        ["processor", stats.host.cpu || "–"],
    ];
    if (stats.estimated_error != null)
        more.push(["estimated error", number(stats.estimated_error)]);
    const wrong = ["dropped_samples", "truncated_paths", "unmatched_exits", "float_resets"].filter((name) => stats[name] > 0)
        .map((name) => [name.replaceAll("_", " "), count(stats[name])]);
    return el("section", {class: "statistics", "aria-label": "Statistics"}, el("h2", null, "Statistics"),
        stats.precision?.warning && el("p", {class: "warning"}, stats.precision.warning),
        el("div", {class: "columns"}, table("Time", null, ms), table("Rays", null, rays), table("Render", null, [...more, ...wrong])));
}

async function reportBox(job, signal) {
    const path = `v1/jobs/${job.id}/report`;
    const url = await address(path, signal, "text/html");
    const save = (text, ending, type) => button(text, () => download(path, `report-${job.id.slice(-8)}.${ending}`, type));
    return el("section", {"aria-label": "Report"}, el("h2", null, "Report"),
        el("div", {class: "row"}, el("a", {class: "button", href: url, target: "_blank"}, "Open alone"), el("span", null, "Save"), save("HTML", "html", "text/html"),
            save("JSON", "json", "application/json"), save("CSV", "csv", "text/csv"), save("Markdown", "md", "text/markdown")),
        el("iframe", {class: "report", src: url, title: `Report of ${title(job)}`, sandbox: "allow-scripts"}));
}

export async function show(main, query, signal, [id]) {
    document.title = "Job – Penumbra";
    const head = el("div");
    const progress = el("div", {class: "progress"});
    const problem = el("div");
    const controls = el("div", {class: "row"});
    const picture = makePicture("The picture", signal);
    const below = el("div");
    const running = new AbortController();
    const live = AbortSignal.any([signal, running.signal]);
    put(main, head, problem, progress, controls, picture.box, below);
    picture.box.hidden = true;

    let job = await get(`v1/jobs/${id}`, signal).catch((error) => {
        if (!signal.aborted)
            put(main, el("h1", null, "Job"), failed(error));
    });
    if (!job)
        return;
    let rate = null;
    const act = async (method, path, after) => {
        try {
            const response = method === "POST" ? await post(path, "", signal) : await call(path, {method, signal});
            after?.(response);
        } catch (error) {
            if (!signal.aborted)
                put(problem, failed(error));
        }
    };
    const drawHead = () => {
        document.title = `${title(job)} – Penumbra`;
        put(head, el("h1", null, title(job), " ", stateBadge(job.state)),
            el("p", null, `${job.kind}, ${job.render.width}×${job.render.height}, submitted ${date(job.created_at)}`),
            el("div", {class: "row"},
                !ended(job) && button("Cancel", () => act("POST", `v1/jobs/${id}/cancel`), {id: "cancel"}),
                el("a", {class: "button", href: `#/?scene=${id}`}, "Use this scene again"),
                ended(job) && button("Remove", () => act("DELETE", `v1/jobs/${id}`, () => { location.hash = "#/jobs"; }))));
        put(progress, !ended(job) && progressBox(job, rate));
        if (job.error)
            put(problem, problemBox({message: job.error.detail || job.error.title, errors: job.error.errors || []}));
    };
    drawHead();

    let shown = null; // the address of the preview in view
    const preview = async () => {
        const one = new AbortController();
        const url = await address(`v1/jobs/${id}/preview?view=${job.views[0]}`, AbortSignal.any([live, one.signal]));
        picture.box.hidden = false;
        picture.show(url, null);
        shown?.abort();
        shown = one;
    };
    let dirty = false;
    const drawPreviews = async () => {
        for (;;) {
            const begun = performance.now();
            if (dirty) {
                dirty = false;
                await preview();
            }
            await sleep(Math.max(PREVIEW_MS, performance.now() - begun), live);
        }
    };
    const quietly = (promise) => promise.catch((error) => {
        if (!signal.aborted && !running.signal.aborted)
            put(problem, failed(error));
    });
    if (!ended(job)) {
        if (job.kind === "render")
            quietly(drawPreviews());
        quietly(watchRate(id, live, (value) => {
            rate = value;
            drawHead();
        }));
    }
    try {
        for await (const event of jobEvents(id, signal)) {
            if (event.type === "tile") {
                dirty = true;
            } else {
                job = event.data;
                drawHead();
            }
            if (ended(job))
                break;
        }
        job = await get(`v1/jobs/${id}`, signal);
        running.abort();
        drawHead();
        if (job.state !== "succeeded")
            return;
        if (job.kind === "render") {
            showResults();
            put(below, statisticsBox(await get(`v1/jobs/${id}/stats`, signal)));
        } else if (job.kind !== "explain") {
            put(below, await reportBox(job, signal));
        }
    } catch (error) {
        running.abort();
        if (!signal.aborted)
            put(problem, failed(error));
    }

    function showResults() {
        const view = field("View", "select", null, job.views.map((name) => [name, name]));
        const layer = field("Layer", "select", null, job.layers.map((name) => [name, name]));
        const path = (format) => `v1/jobs/${id}/image?view=${view.input.value}&layer=${layer.input.value}${format ? `&format=${format}` : ""}`;
        const update = async () => {
            try {
                picture.show(await address(path(""), signal), path("pfm"));
                picture.box.hidden = false;
            } catch (error) {
                if (!signal.aborted)
                    put(problem, failed(error));
            }
        };
        const save = (text, format, ending) => button(text, () =>
            download(path(format), `${(job.name || "picture").replace(/[^\w.-]+/g, "-")}-${view.input.value}.${ending}`));
        view.input.addEventListener("change", update);
        layer.input.addEventListener("change", update);
        picture.size(job.render.width, job.render.height);
        put(controls, job.views.length > 1 && view.box, job.layers.length > 1 && layer.box,
            el("span", null, "Save"), save("PNG", "png", "png"), save("16-bit PNG", "png16", "png"), save("PFM", "pfm", "pfm"),
            button("Statistics", () => download(`v1/jobs/${id}/stats`, `stats-${id.slice(-8)}.json`)));
        update();
    }
}

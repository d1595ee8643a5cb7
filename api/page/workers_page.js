/* SPDX-License-Identifier: MIT */
/* The workers of this daemon, and the jobs that they hold. */

import {get, sleep} from "./api.js";
import {el, put, table} from "./dom.js";
import {count, date} from "./format.js";

const REFRESH_MS = 2000;

const holding = (worker) => (worker.batches.length === 0 ? "idle" : worker.batches.map((batch) =>
    el("div", null, el("a", {href: `#/job/${batch.job}`}, `${batch.kind} …${batch.job.slice(-8)}`),
        `, ${count(batch.pixels)} ${batch.kind === "render" || batch.kind === "assemble" ? "pixels" : "runs"}`)));

export function show(main, query, signal) {
    document.title = "Workers – Penumbra";
    const box = el("div", {role: "status"});
    put(main, el("h1", null, "Workers"), box);
    (async () => {
        for (;;) {
            const {workers} = await get("v1/workers", signal);
            put(box, workers.length === 0 ? el("p", null, "No worker runs. Jobs wait until one is started.")
                : table("Workers", ["Worker", "Threads", "Runs since", "Last seen", "Holds"], workers.map((worker) =>
                    [`${worker.host}, ${worker.pid}`, String(worker.threads), date(worker.started_at), date(worker.last_seen_at), holding(worker)])));
            await sleep(REFRESH_MS, signal);
        }
    })().catch((error) => { if (!signal.aborted) put(box, el("p", {role: "alert"}, error.message)); });
}

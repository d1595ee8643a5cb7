/* SPDX-License-Identifier: MIT */
/* Calls the daemon. All calls use fetch, so that the token can be sent with them. A call that changes nothing
 * is repeated while the daemon cannot be reached, until its signal aborts it. */

const RETRY_MS = 1000;
const KEY = "penumbra-token";
let wake = [];

/* A refusal: an RFC 9457 document. */
export class Problem extends Error {
    constructor(status, body) {
        super(body.detail || body.title || `The daemon answered with status ${status}.`);
        this.status = status;
        this.errors = body.errors || [];
    }
}

const listeners = [];
/* Calls listener(state, detail) with "up", "down" (detail: a sentence) or "token" (detail: why a token is
 * needed). */
export const onState = (listener) => listeners.push(listener);
const tell = (state, detail) => listeners.forEach((listener) => listener(state, detail));

export function setToken(token) {
    sessionStorage.setItem(KEY, token);
    wake.forEach((resume) => resume());
    wake = [];
}
const untilToken = () => new Promise((resolve) => wake.push(resolve));

export const sleep = (ms, signal) => new Promise((resolve, reject) => {
    const abort = () => {
        clearTimeout(timer);
        reject(signal.reason);
    };
    const timer = setTimeout(() => {
        signal?.removeEventListener("abort", abort);
        resolve();
    }, ms);
    if (signal?.aborted)
        abort();
    signal?.addEventListener("abort", abort, {once: true});
});

function headers(extra) {
    const token = sessionStorage.getItem(KEY);
    return {...extra, ...(token ? {Authorization: `Bearer ${token}`} : {})};
}

async function problemOf(response) {
    let body = {};
    try {
        body = await response.json();
    } catch {
        // a page of a proxy: only the status is known
    }
    return new Problem(response.status, body);
}

/* Sends a request, and repeats it where that is safe. options: method, headers, body, signal. */
export async function call(path, options = {}) {
    const safe = !options.method || options.method === "GET" || options.headers?.["Idempotency-Key"];
    for (;;) {
        options.signal?.throwIfAborted();
        let response;
        try {
            response = await fetch(path, {...options, headers: headers(options.headers)});
        } catch (error) {
            options.signal?.throwIfAborted();
            tell("down", "The daemon does not answer. This page tries again every second.");
            if (!safe)
                throw new Problem(0, {detail: "The daemon does not answer."});
            await sleep(RETRY_MS, options.signal);
            continue;
        }
        if (response.ok || response.status === 304) {
            tell("up");
            return response;
        }
        const problem = await problemOf(response);
        if (response.status === 401) {
            tell("token", sessionStorage.getItem(KEY) ? problem.message : "");
            await untilToken();
        } else if (response.status === 503 && safe) {
            tell("down", `${problem.message} This page tries again.`);
            await sleep(RETRY_MS, options.signal);
        } else {
            tell("up");
            throw problem;
        }
    }
}

export async function get(path, signal) {
    return (await call(path, {signal, headers: {Accept: "application/json"}})).json();
}

/* Sends text, or an object as JSON. The first character shows whether a text is XML, as in the daemon. */
export async function post(path, body, signal, extra) {
    const text = typeof body === "string" ? body : JSON.stringify(body);
    const type = /^\s*</.test(text) ? "application/xml" : "application/json";
    return call(path, {method: "POST", body: text, signal, headers: {"Content-Type": type, ...extra}});
}

/* An address for <img> and <iframe>. It is freed when the signal aborts. */
export async function address(path, signal, accept) {
    const response = await call(path, {signal, headers: accept ? {Accept: accept} : {}});
    const url = URL.createObjectURL(await response.blob());
    if (signal.aborted)
        URL.revokeObjectURL(url);
    signal.addEventListener("abort", () => URL.revokeObjectURL(url), {once: true});
    return url;
}

/* Saves the answer of a path as a file. */
export async function download(path, name, accept) {
    const url = URL.createObjectURL(await (await call(path, {headers: accept ? {Accept: accept} : {}})).blob());
    const link = document.createElement("a");
    link.href = url;
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 60e3);
}

/* A random key for Idempotency-Key. crypto.randomUUID is missing on plain http. */
export const randomKey = () =>
    Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");

function parseEvent(block) {
    const event = {type: "message", data: "", id: null};
    for (const line of block.split("\n")) {
        const [, name, value] = /^([a-z]+): ?(.*)$/.exec(line) || [];
        if (name === "event")
            event.type = value;
        else if (name === "data")
            event.data += value;
        else if (name === "id")
            event.id = value;
    }
    return event.data ? event : null;
}

async function* streamEvents(response) {
    const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
    let text = "";
    for (;;) {
        const {value, done} = await reader.read();
        if (done)
            return;
        text += value;
        const blocks = text.split("\n\n");
        text = blocks.pop();
        for (const block of blocks) {
            const event = parseEvent(block);
            if (event)
                yield event;
        }
    }
}

/* Yields the events of a job until it has ended: {type, data}, with data parsed. A stream that breaks is
 * resumed at its place. */
export async function* jobEvents(id, signal) {
    let last = null;
    for (;;) {
        const extra = last ? {"Last-Event-ID": last} : {};
        const response = await call(`v1/jobs/${id}/events`, {signal, headers: extra});
        if (response.status === 204)
            return;
        try {
            for await (const event of streamEvents(response)) {
                last = event.id ?? last;
                yield {type: event.type, data: JSON.parse(event.data)};
            }
        } catch (error) {
            signal.throwIfAborted();
            if (!(error instanceof TypeError))
                throw error;
        }
        await sleep(RETRY_MS / 4, signal);
    }
}

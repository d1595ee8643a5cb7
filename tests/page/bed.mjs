// SPDX-License-Identifier: MIT
// What the tests of the page stand on: a daemon of their own, a browser, and checks.
import {spawn} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {createRequire} from "node:module";
import {tmpdir} from "node:os";
import {join} from "node:path";

const require = createRequire(join(process.env.PEN_MODULES, "x.js"));
const {chromium} = require("playwright-core");
const axePath = require.resolve("axe-core/axe.min.js");

export const build = process.env.PEN_BUILD;
export const folder = mkdtempSync(join(tmpdir(), "penumbra-page-"));
process.on("exit", () => rmSync(folder, {recursive: true, force: true}));

export function check(truth, what) {
    if (!truth)
        throw new Error(what);
}
export function same(found, wanted, what) {
    check(found === wanted, `${what}: found ${JSON.stringify(found)}, not ${JSON.stringify(wanted)}`);
}

// Starts a daemon on a port (0: any). Returns {base, port, stop()}.
export async function startDaemon({options = [], port = 0, store = "store.db"} = {}) {
    const child = spawn(join(build, "penumbrad"),
        ["--listen", `127.0.0.1:${port}`, "--store", join(folder, store), ...options], {stdio: ["ignore", "pipe", "ignore"]});
    const exited = new Promise((resolve) => child.once("exit", resolve));
    process.once("exit", () => child.kill("SIGKILL"));
    const line = await new Promise((resolve, reject) => {
        child.stdout.once("data", (data) => resolve(String(data)));
        exited.then(() => reject(new Error("the daemon did not start")));
    });
    const base = /http\S+/.exec(line)[0];
    return {
        base,
        port: Number(new URL(base).port),
        async stop() {
            child.kill("SIGTERM");
            await exited;
        },
    };
}

// Submits a job: a text or an object.
export const submit = async (base, body, headers = {}) => {
    const text = typeof body === "string" ? body : JSON.stringify(body);
    const answer = await fetch(`${base}/v1/jobs`, {method: "POST", body: text, headers: {"Content-Type": "application/json", ...headers}});
    const job = await answer.json();
    check(answer.status === 202, `submit: ${JSON.stringify(job)}`);
    return job;
};

// Submits a job and waits for its end. Returns the job.
export async function renderJob(base, body, headers = {}) {
    let job = await submit(base, body, headers);
    while (!["succeeded", "failed", "cancelled"].includes(job.state))
        job = await (await fetch(`${base}/v1/jobs/${job.id}?wait=60`, {headers})).json();
    return job;
}

// Waits until a function of the page is true. (waitForFunction calls eval, which the policy forbids.)
export async function until(page, truth, argument) {
    for (const end = Date.now() + 30000; !(await page.evaluate(truth, argument));) {
        check(Date.now() < end, `waited for ${truth}; the page says: ${await page.textContent("body")}`);
        await new Promise((resolve) => setTimeout(resolve, 50));
    }
}

// A browser's page that counts what must never happen: errors of scripts, violations of a policy, the
// script of a name.
export async function openPage(browser, options = {}) {
    const context = await browser.newContext({viewport: {width: 1280, height: 900}, ...options});
    const page = await context.newPage();
    const faults = [];
    page.on("pageerror", (error) => faults.push(`script: ${error.message}`));
    page.on("console", (message) => {
        if (/Content.Security.Policy|pwned/.test(message.text()))
            faults.push(message.text());
    });
    page.faults = faults;
    page.setDefaultTimeout(30000);
    return page;
}

export const launch = () => chromium.launch({executablePath: process.env.CHROMIUM || "/usr/bin/chromium", args: ["--no-sandbox"]});

// Serious findings of axe in a page or frame, as sentences.
export async function accessibilityFaults(frame) {
    if (!(await frame.evaluate(() => "axe" in window)))
        await frame.evaluate((await import("node:fs")).readFileSync(axePath, "utf8"));
    const {violations} = await frame.evaluate(() => window.axe.run(document, {iframes: false}));
    return violations.filter(({impact}) => impact === "serious" || impact === "critical")
        .map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html).slice(0, 3).join(" ")}`);
}

export const overflow = (frame) => frame.evaluate(() => document.scrollingElement.scrollWidth - document.scrollingElement.clientWidth);

// SPDX-License-Identifier: MIT
// A report of each kind, as a file that stands alone and in the page.
import {execFileSync} from "node:child_process";
import {mkdirSync, readFileSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {accessibilityFaults, build, check, folder, openPage, overflow, renderJob, same, until} from "./bed.mjs";

const EVIL = "<img src=x onerror=\"console.log('pwned')\">";
const small = {width: 64, height: 48};
const penumbra = (...words) => execFileSync(join(build, "penumbra"), words, {stdio: ["ignore", "pipe", "pipe"], cwd: folder});

// builtin:soft-shadow with a name that would be markup, if anything took it for that.
function evilScene() {
    const scene = JSON.parse(readFileSync(new URL("../../scenes/soft-shadow.json", import.meta.url), "utf8"));
    scene.name = EVIL;
    scene.render = {...scene.render, ...small, light_samples: 4};
    writeFileSync(join(folder, "evil.json"), JSON.stringify(scene));
    return scene;
}

// What each kind of report must show, by itself and at every width.
async function checkReport(bed, file, figures) {
    for (const options of [{viewport: {width: 1280, height: 900}}, {viewport: {width: 400, height: 800}, colorScheme: "dark"}, {javaScriptEnabled: false}]) {
        const page = await openPage(bed.browser, options);
        await page.goto(`file://${join(folder, file)}`);
        check((await page.locator("table").first().locator("tr").count()) > 1, "a table of plain HTML");
        if (options.javaScriptEnabled !== false) {
            await page.waitForSelector(".chart svg");
            const texts = await page.locator(".chart svg text").allTextContents();
            check(texts.length >= 4, `a chart has ticks and units: ${texts.join(" ")}`);
            check((await page.locator(".chart figcaption, .chart caption").count()) > 0, "a chart has a caption");
            same((await accessibilityFaults(page)).join("\n"), "", "axe");
            same(await overflow(page), 0, `pixels beyond the width ${options.viewport.width}`);
        }
        for (const figure of figures)
            check((await page.textContent("body")).includes(figure), `the report names ${figure}`);
        same(await page.locator("img[src=x]").count(), 0, "elements made from a name");
        same(page.faults.join("\n"), "", "faults in the browser");
        await page.context().close();
    }
}

async function checkInPage(bed, body) {
    const job = await renderJob(bed.daemon.base, {...body, name: EVIL});
    same(job.state, "succeeded", JSON.stringify(job.error));
    const page = await openPage(bed.browser);
    await page.goto(`${bed.daemon.base}/#/job/${job.id}`);
    const frame = page.frameLocator("iframe.report");
    await frame.locator(".chart svg").first().waitFor();
    const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", {name: "HTML", exact: true}).click()]);
    check(file.suggestedFilename().endsWith(".html"), "the report is saved as HTML");
    same(await page.locator("img[src=x]").count(), 0, "elements made from a name");
    same(page.faults.join("\n"), "", "faults in the browser");
    await page.context().close();
}

export default {
    async "a benchmark's report"(bed) {
        const scene = evilScene();
        penumbra("bench", "evil.json", "-m", "threads=1,2", "--repeats", "3", "-q", "-o", "bench.html");
        await checkReport(bed, "bench.html", ["threads", "ms"]);
        await checkInPage(bed, {scene, kind: "benchmark", matrix: {accelerator: ["none", "auto"]}, repeats: 3});
    },

    async "an accuracy study's report"(bed) {
        const scene = evilScene();
        penumbra("accuracy", "evil.json", "--ladder", "light_samples=1,4,16", "-q", "-o", "accuracy.html");
        await checkReport(bed, "accuracy.html", ["light_samples 16", "FLIP"]);
        await checkInPage(bed, {scene, kind: "accuracy", ladder: {light_samples: [1, 4]}, seeds: 2});
    },

    async "a bill of effects"(bed) {
        const scene = evilScene();
        penumbra("effects", "evil.json", "--repeats", "3", "-q", "-o", "effects.html");
        await checkReport(bed, "effects.html", ["soft_shadows"]);
        await checkInPage(bed, {scene, kind: "effects", repeats: 2});
    },

    async "a history"(bed) {
        evilScene();
        mkdirSync(join(folder, "reports"), {recursive: true});
        for (let i = 0; i < 6; i++)
            penumbra("bench", "evil.json", "-m", "threads=1,2", "--repeats", "1", "-q", "-o", `reports/${i}.json`);
        penumbra("bench", "--history", "reports", "-o", "history.html");
        await checkReport(bed, "history.html", ["threads"]);
    },
};

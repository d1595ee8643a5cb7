// SPDX-License-Identifier: MIT
// Makes the pictures of the built-in scenes that the page shows (api/page/scene-NAME.png), and the
// screenshots of the page and of README's study in scenes/gallery: `make page-pictures`.
import {existsSync, writeFileSync} from "node:fs";
import {build, launch, openPage, renderJob, startDaemon, submit, until} from "./bed.mjs";

const top = new URL("../../", import.meta.url).pathname;
const daemon = await startDaemon();
const {scenes} = await (await fetch(`${daemon.base}/v1/scenes`)).json();
for (const {name} of scenes) {
    const job = await renderJob(daemon.base, {scene: `builtin:${name}`, name});
    const picture = await fetch(`${daemon.base}/v1/jobs/${job.id}/image?max_edge=160`);
    writeFileSync(`${top}api/page/scene-${name}.png`, Buffer.from(await picture.arrayBuffer()));
}
if (process.argv[2] === "thumbnails")
    process.exit(); // the programs need them before the page can be shown

const browser = await launch();
const page = await openPage(browser, {viewport: {width: 1100, height: 800}});

const {id} = await submit(daemon.base, {scene: "builtin:room", name: "room", render: {samples_per_pixel: 16}});
await page.goto(`${daemon.base}/#/job/${id}`);
await until(page, () => Number(document.querySelector("progress")?.value) > 0.4);
await page.screenshot({path: `${top}scenes/gallery/page.png`});
await fetch(`${daemon.base}/v1/jobs/${id}/cancel`, {method: "POST"});

const study = `${build}/readme/study.html`;
if (existsSync(study)) {
    await page.goto(`file://${study}`);
    await page.locator(".chart").first().screenshot({path: `${top}scenes/gallery/accuracy.png`});
} else {
    console.log(`no ${study}: tests/bench/readme.sh makes it; accuracy.png stays as it is`);
}

await browser.close();
await daemon.stop();

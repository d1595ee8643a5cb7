// SPDX-License-Identifier: MIT
// Makes the pictures of the built-in scenes that the page shows (api/page/scene-NAME.png), and the
// screenshots of the page and of a report in scenes/gallery: `make page-pictures`.
import {writeFileSync} from "node:fs";
import {launch, openPage, renderJob, startDaemon, submit, until} from "./bed.mjs";

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
const shoot = (name, options) => page.screenshot({path: `${top}scenes/gallery/${name}.png`, ...options});

const {id} = await submit(daemon.base, {scene: "builtin:room", name: "room", render: {samples_per_pixel: 16}});
await page.goto(`${daemon.base}/#/job/${id}`);
await until(page, () => Number(document.querySelector("progress")?.value) > 0.4);
await shoot("page");
await fetch(`${daemon.base}/v1/jobs/${id}/cancel`, {method: "POST"});

await browser.close();
await daemon.stop();

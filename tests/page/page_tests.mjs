// SPDX-License-Identifier: MIT
// The page at /: what people do there, in a browser.
import {execFileSync} from "node:child_process";
import {join} from "node:path";
import {accessibilityFaults, build, check, folder, openPage, overflow, renderJob, same, startDaemon, submit, until} from "./bed.mjs";

const EVIL = "<img src=x onerror=\"console.log('pwned')\">";
const scene = (name, red) => JSON.stringify({
    format: "penumbra-scene/1", name, background: [red, 0.5, 0.25],
    camera: {position: [0, 0, 9], look_at: [0, 0, 0]}, render: {width: 64, height: 48},
}, null, 1);
const slow = JSON.stringify({scene: "builtin:room-soft", name: "slow", render: {width: 600, height: 840, light_samples: 256}});

const noFaults = (page) => same(page.faults.join("\n"), "", "faults in the browser");
const lines = (page) => page.locator("#problems li").allTextContents();

async function paste(bed, page, text) {
    await page.goto(`${bed.daemon.base}/`);
    await page.fill("#scene", text);
}

async function picturePixel(page, x, y) {
    return page.locator(".view img").evaluate((image, [px, py]) => {
        const canvas = document.createElement("canvas");
        canvas.width = image.naturalWidth;
        canvas.height = image.naturalHeight;
        canvas.getContext("2d").drawImage(image, 0, 0);
        return [canvas.width, canvas.height, ...canvas.getContext("2d").getImageData(px, py, 1, 1).data].join(" ");
    }, [x, y]);
}

async function twoPictures(bed) {
    const one = await renderJob(bed.daemon.base, {scene: JSON.parse(scene("one", 1)), name: EVIL});
    const other = await renderJob(bed.daemon.base, {scene: JSON.parse(scene("other", 0.2))});
    return [one.id, other.id];
}

export default {
    async "a pasted scene becomes a picture"(bed) {
        const page = await openPage(bed.browser);
        await paste(bed, page, scene("mine", 1));
        await page.waitForSelector(".explanation .good");
        check((await page.textContent(".explanation")).includes("no effects"), "the explanation names the effects");
        await page.click("#submit");
        await page.waitForSelector(".state.succeeded");
        await page.waitForSelector(".statistics table");
        same(await picturePixel(page, 5, 5), "64 48 255 188 137 255", "size and pixel"); // sRGB of 1, 0.5, 0.25
        check((await page.textContent("h1")).startsWith("mine"), "the job has the scene's name");
        noFaults(page);
        await page.context().close();
    },

    async "a scene in XML is rendered with settings"(bed) {
        const page = await openPage(bed.browser);
        await paste(bed, page, "<scene name='x' background-color='0 255 0'><camera position='0 0 9' look-at='0 0 0'/></scene>");
        await page.getByLabel("Width, pixels").fill("20");
        await page.getByLabel("Height, pixels").fill("10");
        await page.waitForSelector(".explanation .good");
        await page.click("#submit");
        await page.waitForSelector(".statistics table");
        same(await picturePixel(page, 3, 3), "20 10 0 255 0 255", "size and pixel");
        noFaults(page);
        await page.context().close();
    },

    async "a wrong scene shows line and message"(bed) {
        const page = await openPage(bed.browser);
        await paste(bed, page, '{"format": "penumbra-scene/1",\n "camera": {"position": [0,0,9], "look_at": [0,0,0]},\n "objects": [\n  {"type": "sphere", "center": [0,0,0], "radios": 1}]}');
        await page.waitForSelector("#problems li.error");
        same((await lines(page))[0], 'line 4 unknown key "radios"; did you mean "radius"?', "a wrong key");
        same(await page.locator(".numbers .wrong").textContent(), "4", "the marked line");
        await page.click("#problems li button >> nth=0");
        same(await page.locator("#scene").evaluate((area) => area.value.slice(area.selectionStart, area.selectionEnd)), '"radios": 1', "what is selected");
        await page.fill("#scene", '{"format": "penumbra-scene/1",\n "camera": {,}}');
        await until(page, () => /line 2 .*key in double quotes/.test(document.querySelector("#problems").textContent));
        await page.fill("#scene", "<scene>\n\n <camra/>\n</scene>");
        await until(page, () => /line 3 .*camra.*camera/.test(document.querySelector("#problems").textContent));
        await page.fill("#scene", scene("x", 1));
        await page.click("summary");
        await page.getByLabel("Other render settings, as JSON").fill('{"light_sample": 4}');
        await until(page, () => /Setting render.light_sample: .*light_samples/.test(document.querySelector("#problems").textContent));
        noFaults(page);
        await page.context().close();
    },

    async "a dropped file is read, and a built-in scene is loaded"(bed) {
        const page = await openPage(bed.browser);
        await page.goto(`${bed.daemon.base}/`);
        await page.setInputFiles("#scene-file", {name: "a.json", mimeType: "application/json", buffer: Buffer.from(scene("file", 1))});
        await until(page, () => document.querySelector("#scene").value.includes('"file"'));
        const data = await page.evaluateHandle((text) => {
            const transfer = new DataTransfer();
            transfer.items.add(new File([text], "b.json"));
            return transfer;
        }, scene("dropped", 1));
        await page.dispatchEvent(".editor", "drop", {dataTransfer: data});
        await until(page, () => document.querySelector("#scene").value.includes('"dropped"'));
        await page.getByRole("button", {name: /^glass:/}).click();
        await until(page, () => /refraction/.test(document.querySelector(".explanation").textContent));
        noFaults(page);
        await page.context().close();
    },

    async "a picture arrives tile by tile, and is cancelled"(bed) {
        const page = await openPage(bed.browser);
        const {id} = await submit(bed.daemon.base, slow);
        await page.goto(`${bed.daemon.base}/#/job/${id}`);
        await until(page, () => document.querySelector(".view img")?.naturalWidth === 600);
        same(await page.locator("h1 .state").textContent(), "running", "the state while the picture grows");
        await until(page, () => / left.*rays per second/.test(document.querySelector(".progress").textContent));
        await page.click("#cancel");
        await page.waitForSelector(".state.cancelled");
        noFaults(page);
        await page.context().close();
    },

    async "pixels have values, by pointer and keyboard"(bed) {
        const page = await openPage(bed.browser);
        const [id] = await twoPictures(bed);
        await page.goto(`${bed.daemon.base}/#/job/${id}`);
        await page.waitForSelector(".statistics table");
        await page.focus(".view");
        await page.keyboard.press("ArrowRight");
        await page.keyboard.press("ArrowDown");
        same(await page.textContent(".values"), "x 1, y 1: 255, 188, 137 of 255", "after two arrow keys");
        await page.getByRole("button", {name: "Exact values"}).click();
        await until(page, () => /exactly 1, 0.5, 0.25/.test(document.querySelector(".values").textContent));
        await page.keyboard.press("Tab"); // the keyboard leaves the picture
        await page.getByRole("button", {name: "Larger"}).click();
        check((await page.locator(".inner").evaluate((inner) => inner.clientWidth)) === 128, "twice as large");
        noFaults(page);
        await page.context().close();
    },

    async "layers, statistics and files of a job"(bed) {
        const page = await openPage(bed.browser);
        const job = await renderJob(bed.daemon.base, {scene: "builtin:spheres", layers: ["beauty", "depth"], render: {width: 64, height: 48}});
        await page.goto(`${bed.daemon.base}/#/job/${job.id}`);
        await page.waitForSelector(".statistics table");
        check((await page.textContent(".statistics")).includes("hard+glass+mirror"), "the kernel is named");
        const before = await page.getAttribute(".view img", "src");
        await page.getByLabel("Layer").selectOption("depth");
        await until(page, (src) => document.querySelector(".view img").src !== src, before);
        const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", {name: "PFM", exact: true}).click()]);
        same(file.suggestedFilename(), "picture-main.pfm", "the file's name");
        noFaults(page);
        await page.context().close();
    },

    async "the list has chips, thumbnails and pages"(bed) {
        const page = await openPage(bed.browser);
        await twoPictures(bed);
        for (let i = 0; i < 25; i++)
            await renderJob(bed.daemon.base, {scene: JSON.parse(scene("many", 0)), name: "many", render: {width: 8, height: 8}});
        await page.goto(`${bed.daemon.base}/#/jobs`);
        await until(page, () => [...document.querySelectorAll("img.thumb")].filter((image) => image.naturalWidth > 0).length === 20);
        const total = Number(/\d+/.exec(await page.textContent(".chip:has-text('succeeded')"))[0]);
        check(total >= 27, `the chip counts ${total}`);
        await page.click("text=Older");
        await until(page, () => document.querySelectorAll(".jobs li").length >= 7 && /cursor=/.test(location.hash));
        await page.click(".chip:has-text('succeeded')");
        await until(page, () => /state=succeeded/.test(location.hash) && !/cursor/.test(location.hash));
        await page.getByLabel("Name").fill("many");
        await page.getByLabel("Name").press("Enter");
        await until(page, () => /name=many/.test(location.hash) && [...document.querySelectorAll(".jobs b")].every((name) => name.textContent === "many"));
        noFaults(page);
        await page.context().close();
    },

    async "two pictures are compared with slider and map"(bed) {
        const page = await openPage(bed.browser);
        await twoPictures(bed);
        await page.goto(`${bed.daemon.base}/#/jobs`);
        await page.locator(".jobs input").nth(0).check();
        await page.locator(".jobs input").nth(1).check();
        await page.getByRole("button", {name: "Compare", exact: true}).click();
        await until(page, () => document.querySelector(".map")?.naturalWidth === 64);
        await page.locator("input[type=range]").fill("25");
        same(await page.locator(".stack img >> nth=1").evaluate((image) => image.style.clipPath), "inset(0px 75% 0px 0px)", "the slider's clip");
        check(/FLIP/.test(await page.textContent("table")), "the measures");
        const other = await renderJob(bed.daemon.base, {scene: "builtin:spheres", render: {width: 10, height: 10}});
        await page.goto(`${bed.daemon.base}/#/compare/${other.id}/${(await twoPictures(bed))[0]}`);
        await until(page, () => /10.*64/.test(document.querySelector(".problem")?.textContent));
        noFaults(page);
        await page.context().close();
    },

    async "every view fits 400 px and passes axe, light and dark"(bed) {
        const ids = await twoPictures(bed);
        for (const options of [{viewport: {width: 400, height: 800}, colorScheme: "light"}, {colorScheme: "dark"}, {colorScheme: "light"}]) {
            const page = await openPage(bed.browser, options);
            const views = [["", ".explanation .good"], ["#/jobs", ".jobs li"], [`#/job/${ids[0]}`, ".statistics table"], [`#/compare/${ids.join("/")}`, ".map"], ["#/workers", "table"]];
            await paste(bed, page, scene(EVIL, 1));
            for (const [path, ready] of views) {
                await page.goto(`${bed.daemon.base}/${path}`);
                await page.waitForSelector(ready);
                same(await overflow(page), 0, `pixels beyond the width, ${path}, ${JSON.stringify(options)}`);
                same((await accessibilityFaults(page)).join("\n"), "", `axe, ${path}, ${JSON.stringify(options)}`);
            }
            noFaults(page);
            await page.context().close();
        }
    },

    async "a name is text everywhere"(bed) {
        const page = await openPage(bed.browser);
        await paste(bed, page, scene(EVIL, 1));
        await page.waitForSelector(".explanation .good");
        await page.click("#submit");
        await page.waitForSelector(".statistics table");
        check((await page.textContent("h1")).startsWith(EVIL), "the name is shown");
        const id = new URL(page.url()).hash.split("/")[2];
        await page.goto(`${bed.daemon.base}/#/jobs`);
        await until(page, (name) => [...document.querySelectorAll(".jobs b")].some((b) => b.textContent === name), EVIL);
        await page.goto(`${bed.daemon.base}/#/compare/${id}/${id}`);
        await page.waitForSelector(".map");
        await page.goto(`${bed.daemon.base}/#/job/${encodeURIComponent(EVIL)}`);
        await page.waitForSelector(".problem");
        same(await page.locator("img[src=x]").count(), 0, "elements made from a name");
        noFaults(page);
        await page.context().close();
    },

    async "the page goes on after a restart of the daemon"(bed) {
        const page = await openPage(bed.browser);
        const list = await openPage(bed.browser);
        const {id} = await submit(bed.daemon.base, {scene: "builtin:room-soft", render: {width: 500, height: 700, light_samples: 64}});
        await page.goto(`${bed.daemon.base}/#/job/${id}`);
        await page.waitForSelector(".state.running");
        await list.goto(`${bed.daemon.base}/#/jobs`);
        await list.waitForSelector(".jobs li");
        const {port} = bed.daemon;
        await bed.daemon.stop();
        await list.waitForSelector("#connection:not([hidden])");
        bed.daemon = await startDaemon({port});
        await page.waitForSelector(".state.succeeded", {timeout: 60000});
        await page.waitForSelector(".statistics table");
        await list.waitForSelector("#connection[hidden]", {state: "attached"});
        await renderJob(bed.daemon.base, {scene: JSON.parse(scene("after", 1)), name: "after the restart"});
        await until(list, () => document.querySelector(".jobs b").textContent === "after the restart");
        noFaults(page);
        noFaults(list);
        await page.context().close();
        await list.context().close();
    },

    async "a daemon with tokens asks for one, and keeps it for the session"(bed) {
        const file = join(folder, "tokens");
        const token = execFileSync(join(build, "penumbrad"), ["token", "add", "page", "--scope", "submit", "--tokens", file], {stdio: ["ignore", "pipe", "ignore"]}).toString().trim();
        const own = await startDaemon({options: ["--tokens", file], store: "tokens.db"});
        const page = await openPage(bed.browser);
        await page.goto(`${own.base}/#/jobs`);
        await page.waitForSelector("#token:not([hidden])");
        await page.fill("#token-field", "pen_wrong");
        await page.keyboard.press("Enter");
        await until(page, () => document.querySelector("#token-problem").textContent.length > 0);
        await page.fill("#token-field", token);
        await page.keyboard.press("Enter");
        await until(page, () => /no such jobs/.test(document.querySelector("main").textContent));
        await page.goto(`${own.base}/#/`);
        await page.fill("#scene", scene("with a token", 1));
        await page.waitForSelector(".explanation .good");
        await page.click("#submit");
        await page.waitForSelector(".statistics table");
        await page.reload();
        await page.waitForSelector(".statistics table");
        check((await page.locator("#token").isHidden()), "the token is kept");
        noFaults(page);
        await page.context().close();
        await own.stop();
    },
};

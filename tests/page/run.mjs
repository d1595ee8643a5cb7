// SPDX-License-Identifier: MIT
// Runs the tests of the page, a line each, and ends with `N passed, N failed`.
import {launch, startDaemon} from "./bed.mjs";
import pageTests from "./page_tests.mjs";
import reportTests from "./report_tests.mjs";

const parts = process.argv.slice(2);
const tests = Object.entries({...pageTests, ...reportTests})
    .filter(([name]) => parts.length === 0 || parts.some((part) => name.includes(part)));
const browser = await launch();
const bed = {browser, daemon: await startDaemon()};
let failed = 0;
for (const [name, test] of tests) {
    const begun = Date.now();
    try {
        await test(bed);
        console.log(`ok ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
        failed++;
        console.log(`FAILED ${name}: ${error.stack}`);
    }
}
await browser.close();
await bed.daemon.stop();
console.log(`${tests.length - failed} passed, ${failed} failed`);
process.exitCode = failed > 0 || tests.length === 0 ? 1 : 0;

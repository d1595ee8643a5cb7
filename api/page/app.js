/* SPDX-License-Identifier: MIT */
/* Shows the page that the address names after #. When the address changes, the view ends, and with it all
 * calls that it waits for. */

import {onState, setToken} from "./api.js";
import {put} from "./dom.js";
import * as comparePage from "./compare_page.js";
import * as jobPage from "./job_page.js";
import * as jobsPage from "./jobs_page.js";
import * as newPage from "./new_page.js";
import * as workersPage from "./workers_page.js";

const PAGES = {"": newPage, jobs: jobsPage, job: jobPage, compare: comparePage, workers: workersPage};
const main = document.getElementById("main");
const connection = document.getElementById("connection");
const token = document.getElementById("token");
let current = new AbortController();

function navigate() {
    current.abort(new DOMException("another page is shown", "AbortError"));
    current = new AbortController();
    const [path, query] = location.hash.replace(/^#\/?/, "").split("?");
    const [name, ...parts] = path.split("/");
    for (const link of document.querySelectorAll("nav a"))
        link.getAttribute("href") === `#/${name}` ? link.setAttribute("aria-current", "page") : link.removeAttribute("aria-current");
    put(main);
    (PAGES[name] || newPage).show(main, new URLSearchParams(query), current.signal, parts);
}

onState((state, detail) => {
    if (state === "token") {
        token.hidden = false;
        put(document.getElementById("token-problem"), detail);
        token.elements[0].focus();
        return;
    }
    connection.hidden = state === "up";
    put(connection, detail || "");
});
token.addEventListener("submit", (event) => {
    event.preventDefault();
    token.hidden = true;
    setToken(document.getElementById("token-field").value.trim());
});
window.addEventListener("hashchange", () => {
    navigate();
    main.focus({preventScroll: true});
    window.scrollTo(0, 0);
});
navigate();

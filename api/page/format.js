/* SPDX-License-Identifier: MIT */
/* Numbers for readers. */

const digits = (value, count) => value.toLocaleString("en", {maximumSignificantDigits: count});

export function time(ms) {
    if (ms == null)
        return "–";
    if (ms < 1000)
        return `${digits(ms, 3)} ms`;
    if (ms < 120e3)
        return `${digits(ms / 1000, 3)} s`;
    const minutes = Math.round(ms / 60e3);
    return minutes < 120 ? `${minutes} min` : `${digits(minutes / 60, 3)} h`;
}

function scaled(value, base, names) {
    let i = 0;
    while (value >= base && i < names.length - 1) {
        value /= base;
        i++;
    }
    return `${digits(value, 3)}${names[i]}`;
}

export const count = (value) => (value == null ? "–" : scaled(value, 1000, ["", " thousand", " million", " billion", " trillion"]));
export const bytes = (value) => (value == null ? "–" : scaled(value, 1024, [" B", " KiB", " MiB", " GiB", " TiB"]));
export const percent = (share) => `${Math.floor(share * 100)} %`;
export const number = (value) => (typeof value === "number" ? digits(value, 5) : String(value));

export const date = (text) => (text ? new Date(text).toLocaleString() : "–");

/* The title of a job: its name, or the last characters of its id, which differ most. */
export const title = (job) => job.name || `${job.kind} …${job.id.slice(-8)}`;

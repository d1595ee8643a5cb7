/* SPDX-License-Identifier: MIT */
/* Makes elements. All text becomes text nodes, never markup. So no name or message of a scene can become part
 * of the page. */

/* el("button", {class: "small", onclick: f}, "Text", child, …). Left out are attributes that are null or
 * false, and children that are null. */
export function el(tag, attributes, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) {
        if (name.startsWith("on"))
            element.addEventListener(name.slice(2), value);
        else if (value != null && value !== false)
            element.setAttribute(name, value === true ? "" : value);
    }
    put(element, ...children);
    return element;
}

/* Replaces the children of an element. */
export function put(element, ...children) {
    element.replaceChildren(...children.flat(9).filter((child) => child != null && child !== false));
    return element;
}

/* Makes a table: heads are texts, rows are lists of texts or elements. The first cell of a row is its head.
 */
export function table(caption, heads, rows) {
    return el("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": caption},
        el("table", null,
            el("caption", null, caption),
            heads && el("thead", null, el("tr", null, heads.map((head) => el("th", {scope: "col"}, head)))),
            el("tbody", null, rows.map(([first, ...rest]) =>
                el("tr", null, el("th", {scope: "row"}, first), rest.map((cell) => el("td", null, cell)))))));
}

/* Makes a labelled form field. Attributes go to the control. The kind "select" takes options as [value,
 * text]. */
let fields = 0;
export function field(label, control, attributes, options) {
    const id = `field-${++fields}`;
    const input = el(control, {id, ...attributes},
        (options || []).map(([value, text]) => el("option", {value}, text)));
    return {box: el("div", {class: "field"}, el("label", {for: id}, label), input), input};
}

export function button(text, onclick, attributes) {
    return el("button", {type: "button", onclick, ...attributes}, text);
}

/* Shows why a call was refused: its sentence and its list of places. */
export function problemBox(problem) {
    return el("div", {class: "problem", role: "alert"},
        el("p", null, problem.message),
        problem.errors.length > 0 && el("ul", null, problem.errors.map((error) =>
            el("li", null, `${place(error)}${error.detail}`))));
}

export function place(error) {
    if (error.line)
        return `line ${error.line}${error.column ? `, column ${error.column}` : ""}: `;
    return error.pointer ? `${error.pointer}: ` : "";
}

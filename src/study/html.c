/* SPDX-License-Identifier: MIT */
/* Escapes the five characters that have a meaning in HTML. */
#include "study/internal/html.h"

void pen_html_escape(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        switch (*text) {
        case '<':
            pen_buf_puts(out, "&lt;");
            break;
        case '>':
            pen_buf_puts(out, "&gt;");
            break;
        case '&':
            pen_buf_puts(out, "&amp;");
            break;
        case '"':
            pen_buf_puts(out, "&quot;");
            break;
        case '\'':
            pen_buf_puts(out, "&#39;");
            break;
        default:
            pen_buf_add(out, text, 1);
        }
    }
}

void pen_html_escape_buf(struct pen_buf *text, struct pen_buf *out)
{
    pen_html_escape(text->data ? (const char *)text->data : "", out);
    out->failed |= text->failed;
    pen_buf_release(text);
}

/* SPDX-License-Identifier: MIT */
/* Values and errors as text for io/message.h. */
#include <stdio.h>

#include "base/utf8.h"
#include "io/error/text.h"
#include "io/message.h"

void pen_value_describe(const json_t *value, char *out, size_t bytes)
{
    struct pen_text text = pen_text_value(value);
    pen_utf8_copy(out, bytes, text.text);
}

void pen_status_describe(const struct pen_status *st, const char *file, char *out, size_t bytes)
{
    char text[PEN_AT_BYTES + PEN_MSG_BYTES + 4096];
    const char *colon = file && file[0] ? ": " : "";
    const char *name = file ? file : "";
    if (st->line > 0)
        snprintf(text, sizeof text, "%s%s%d:%d: %s", name, file && file[0] ? ":" : "", st->line,
                 st->column, st->msg);
    else if (st->at[0])
        snprintf(text, sizeof text, "%s%sat %s: %s", name, colon, st->at, st->msg);
    else
        snprintf(text, sizeof text, "%s%s%s", name, colon, st->msg);
    pen_utf8_show(out, bytes, text);
}

/* SPDX-License-Identifier: MIT */
#include "cmd/option_values.h"

#include <stdlib.h>
#include <string.h>

#include "base/buf.h"

/* Writes the value in the form that pen_option_set reads. Writes nothing if there is no value. */
static void write_value(const struct pen_option *option, const void *values, struct pen_buf *out)
{
    const void *field = (const char *)values + option->offset;
    const struct pen_option_list *list = field;
    const char *text;
    switch (option->kind) {
    case PEN_OPTION_FLAG:
        pen_buf_puts(out, *(const bool *)field ? "true" : "");
        break;
    case PEN_OPTION_INT:
        pen_buf_printf(out, "%d", *(const int *)field);
        break;
    case PEN_OPTION_NUMBER:
        pen_buf_printf(out, "%.17g", *(const double *)field);
        break;
    case PEN_OPTION_LIST:
        for (int i = 0; i < list->count; i++)
            pen_buf_printf(out, "%s%s", i > 0 ? " " : "", list->item[i]);
        break;
    case PEN_OPTION_TEXT:
    case PEN_OPTION_CHOICE:
        text = *(const char *const *)field;
        pen_buf_puts(out, text ? text : "");
        break;
    }
}

static bool export(const struct pen_option *option, const void *values)
{
    struct pen_buf text = {0};
    write_value(option, values, &text);
    const bool ok = !text.failed && (text.bytes > 0 ? setenv(option->env, (char *)text.data, 1)
                                                    : unsetenv(option->env)) == 0;
    pen_buf_release(&text);
    return ok;
}

bool pen_options_to_env(const struct pen_command *command, const void *values)
{
    for (const struct pen_option *option = command->options; option->name; option++) {
        if (option->env && !export(option, values))
            return false;
    }
    return true;
}

bool pen_option_same(const struct pen_option *option, const void *a, const void *b)
{
    struct pen_buf one = {0}, other = {0};
    write_value(option, a, &one);
    write_value(option, b, &other);
    const bool same = one.failed || other.failed ||
                      (one.bytes == other.bytes &&
                       (one.bytes == 0 || memcmp(one.data, other.data, one.bytes) == 0));
    pen_buf_release(&one);
    pen_buf_release(&other);
    return same;
}

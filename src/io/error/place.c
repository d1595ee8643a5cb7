/* SPDX-License-Identifier: MIT */
#include "io/error/place.h"

#include <stdio.h>

#include "io/error/text.h"

static size_t append_place(const struct pen_place *at, const char *prefix, char *out, size_t bytes)
{
    if (!at->up)
        return pen_text_append(out, bytes, 0, prefix, false);
    size_t used = append_place(at->up, prefix, out, bytes);
    used = pen_text_append(out, bytes, used, "/", false);
    if (at->key)
        return pen_text_append(out, bytes, used, at->key, true);
    char digits[24];
    snprintf(digits, sizeof digits, "%zu", at->index);
    return pen_text_append(out, bytes, used, digits, false);
}

void pen_place_pointer(const struct pen_place *at, const char *prefix, char *out, size_t bytes)
{
    append_place(at, prefix, out, bytes);
}

/* SPDX-License-Identifier: MIT */
/* Reading models from texts and bytes in tests. */
#ifndef TESTS_SUPPORT_MODELS_H
#define TESTS_SUPPORT_MODELS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/model.h"
#include "support/suite.h"

/* What reading gave. The MTL file "m.mtl" has the text `mtl`; NULL: there is none. */
struct model {
    struct pen_model m;
    struct pen_errors notes;
    struct pen_status st;
    bool ok;
    const char *mtl;
    uint32_t max_triangles;
    char asked[300]; /* the last name of a file that was asked for */
};

static inline bool model_fetch(void *self, const char *name, struct pen_buf *out,
                               struct pen_status *st)
{
    struct model *r = self;
    snprintf(r->asked, sizeof r->asked, "%s", name);
    if (!r->mtl || strcmp(name, "m.mtl") != 0)
        return pen_fail(st, PEN_NOT_FOUND, "No such file");
    return pen_buf_puts(out, r->mtl) || pen_fail(st, PEN_NO_MEMORY, "No memory");
}

/* Reads a copy of exactly these bytes, so that a read behind their end is found. The result of the
 * read before is released. */
static inline bool model_read(struct model *r, enum pen_model_kind kind, const void *data,
                              size_t bytes)
{
    char *copy = malloc(bytes > 0 ? bytes : 1);
    if (!copy)
        return r->ok = pen_fail(&r->st, PEN_NO_MEMORY, "No memory");
    memcpy(copy, data, bytes);
    pen_model_release(&r->m);
    r->notes = (struct pen_errors){0};
    r->st = (struct pen_status){0};
    const struct pen_model_file file = {copy, bytes, kind, r->max_triangles, model_fetch, r};
    r->ok = pen_model_read(&file, &r->m, &r->notes, &r->st);
    free(copy);
    return r->ok;
}

static inline bool model_text(struct model *r, enum pen_model_kind kind, const char *text)
{
    return model_read(r, kind, text, strlen(text));
}

/* A text that is refused at a line with a message that contains `message`. */
struct model_refusal {
    const char *text;
    enum pen_code code;
    int line;
    const char *message;
};

static inline void model_check_refusals(enum pen_model_kind kind, const struct model_refusal *list,
                                        size_t count)
{
    struct model r = {.mtl = NULL};
    for (size_t i = 0; i < count; i++) {
        ck_assert_msg(!model_text(&r, kind, list[i].text), "read: %s", list[i].text);
        ck_assert_msg(r.st.code == list[i].code && r.st.line == list[i].line &&
                          strstr(r.st.msg, list[i].message),
                      "%s\ngave code %d, line %d: %s", list[i].text, r.st.code, r.st.line,
                      r.st.msg);
        ck_assert(!r.m.vertex && !r.m.corner);
    }
}

/* Whether a note contains the text. */
static inline bool model_noted(const struct model *r, const char *text)
{
    for (size_t i = 0; i < r->notes.count; i++)
        if (strstr(r->notes.item[i].msg, text))
            return true;
    return false;
}

static inline void model_check_corners(const struct model *r, const uint32_t (*corner)[3],
                                       uint32_t count)
{
    ck_assert_msg(r->ok, "%s", r->st.msg);
    ck_assert_uint_eq(r->m.triangle_count, count);
    ck_assert_mem_eq(r->m.corner, corner, count * sizeof *corner);
}

#endif

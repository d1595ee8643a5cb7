/* SPDX-License-Identifier: MIT */
/* Problem documents (RFC 9457). The type is urn:penumbra:problem:NAME with the name of the code; it
 * is an identifier, not an address. For invalid input `errors` lists the places: each a JSON
 * Pointer into the document that was sent, or line and column of its text. */
#include "jobs/internal/problems.h"

#include <stdio.h>
#include <string.h>

#include "jobs/internal/jobs.h"

/* Whether the error is about the document that was sent. */
static bool is_about_input(const struct pen_status *st)
{
    return st->line > 0 || st->at[0] || st->code == PEN_INVALID || st->code == PEN_UNSUPPORTED;
}

json_t *pen_problem_place(const struct pen_status *st)
{
    if (st->line > 0)
        return json_pack("{s:i, s:i, s:s}", "line", st->line, "column", st->column, "detail",
                         st->msg);
    return json_pack("{s:s, s:s}", "pointer", st->at, "detail", st->msg);
}

static json_t *problem(enum pen_code code, const char *detail)
{
    char type[64];
    snprintf(type, sizeof type, "urn:penumbra:problem:%s", pen_code_name(code));
    return json_pack("{s:s, s:s, s:i, s:s}", "type", type, "title", pen_code_title(code), "status",
                     pen_code_http(code), "detail", detail);
}

json_t *pen_problem(const struct pen_status *st)
{
    json_t *document = problem(st->code, st->msg);
    if (!is_about_input(st))
        return document;
    return pen_json_with(document, "errors", json_pack("[o]", pen_problem_place(st)));
}

json_t *pen_problem_list(const struct pen_errors *errors)
{
    static const struct pen_status none = {.code = PEN_INTERNAL, .msg = "an error without a cause"};
    if (errors->count == 0)
        return pen_problem(&none);
    if (errors->count == 1)
        return pen_problem(&errors->item[0]);
    char detail[PEN_MSG_BYTES + 64];
    snprintf(detail, sizeof detail, "%zu errors, the first %zu are listed", errors->total,
             errors->count);
    if (errors->total == errors->count)
        snprintf(detail, sizeof detail, "%zu errors", errors->total);
    json_t *document = problem(errors->item[0].code, detail);
    json_t *list = json_array();
    for (size_t i = 0; i < errors->count; i++)
        json_array_append_new(list, pen_problem_place(&errors->item[i]));
    return pen_json_with(document, "errors", pen_json_all(list, errors->count));
}

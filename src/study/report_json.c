/* SPDX-License-Identifier: MIT */
#include "study/internal/report_json.h"

#include <inttypes.h>
#include <string.h>

#include "base/clock.h"
#include "io/json_build.h"

json_t *pen_joined_json(json_t *object, json_t *more)
{
    const bool ok = object && more && json_object_update(object, more) == 0;
    json_decref(more);
    if (ok)
        return object;
    json_decref(object);
    return NULL;
}

json_t *pen_lines_json(struct pen_buf *lines)
{
    json_t *list = lines->failed ? NULL : json_array();
    const char *line = lines->data ? (const char *)lines->data : "";
    size_t count = 0;
    for (; *line; line += strcspn(line, "\n") + 1, count++)
        json_array_append_new(list, json_stringn(line, strcspn(line, "\n")));
    pen_buf_release(lines);
    return pen_json_all(list, count);
}

json_t *pen_report_hash_json(uint64_t hash)
{
    return json_sprintf("%016" PRIx64, hash);
}

json_t *pen_report_time_json(int64_t wall_ms)
{
    char text[25];
    pen_clock_format(wall_ms, text);
    return json_string(text);
}

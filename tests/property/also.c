/* SPDX-License-Identifier: MIT */
/* Rows that other programs judged, for the report; matrix.sh and mutants.sh write them. */
#include <jansson.h>
#include <stdio.h>

#include "property/report.h"

static const char *text(const json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    return value ? value : "";
}

static uint64_t count(const json_t *object, const char *key)
{
    return (uint64_t)json_integer_value(json_object_get(object, key));
}

static void add(struct report *report, struct row *row, const json_t *from)
{
    struct report_row *to = &report->row[report->rows++];
    *row = (struct row){.id = text(from, "id"),
                        .name = text(from, "name"),
                        .what = text(from, "what"),
                        .oracle = text(from, "oracle")};
    *to = (struct report_row){.row = row, .ran = true};
    to->result.tried = count(from, "cases");
    to->result.failures = count(from, "failures");
    to->result.cpu_s = json_number_value(json_object_get(from, "seconds"));
    if (to->result.failures == 0)
        return;
    struct row_kept *kept = &to->result.kept[to->result.kept_count++];
    snprintf(kept->why, sizeof kept->why, "%s", text(from, "why"));
}

bool report_also(struct report *report, const char *path)
{
    static struct row row[ROWS_MAX];
    json_error_t error;
    json_t *file = json_load_file(path, 0, &error), *rows = json_object_get(file, "rows");
    /* The file's strings live as long as the program. */
    for (size_t i = 0; i < json_array_size(rows) && report->rows < ROWS_MAX; i++)
        add(report, &row[report->rows], json_array_get(rows, i));
    return file != NULL;
}

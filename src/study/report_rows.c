/* SPDX-License-Identifier: MIT */
/* Reads the rows of a report, for comparisons and histories. */
#include "study/internal/report_rows.h"

#include <stddef.h>

#include "report/values.h"

const char *const pen_bench_host_members[] = {"cpu",       "isa",      "cores",  "id",
                                              "microcode", "governor", "kernel", NULL};

bool pen_bench_settings_agree(const json_t *a, const json_t *b)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)a, key, value)
    {
        const json_t *other = json_object_get(b, key);
        if (other && !json_equal(value, other))
            return false;
    }
    return true;
}

json_t *pen_bench_all_settings(const json_t *report, const json_t *row)
{
    json_t *all = json_object();
    if (json_is_object(json_object_get(report, "render")))
        json_object_update(all, json_object_get(report, "render"));
    if (json_is_object(json_object_get(row, "settings")))
        json_object_update(all, json_object_get(row, "settings"));
    return all;
}

struct pen_confidence pen_bench_row_times(const json_t *row, double alpha)
{
    double values[PEN_PAIRS_MAX];
    int count = 0;
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(row, "runs_ms"), i, run)
    {
        if (json_number_value(run) > 0 && count < PEN_PAIRS_MAX)
            values[count++] = json_number_value(run);
    }
    const size_t spoiled = json_array_size(json_object_get(row, "spoiled_runs"));
    if (count == 0)
        return (struct pen_confidence){0};
    return pen_median_interval(values, count, spoiled < PEN_PAIRS_MAX ? (int)spoiled : count,
                               alpha);
}

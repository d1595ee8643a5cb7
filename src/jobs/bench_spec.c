/* SPDX-License-Identifier: MIT */
/* Reads a benchmark spec, and makes the rows of its matrix. The reader of `render` objects reads
 * each value of the matrix, so both allow the same values. */
#include "jobs/bench_spec.h"

#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "io/json_build.h"
#include "io/settings_json.h"
#include "jobs/internal/members.h"

static const char matrix_at[] = "/matrix";

/* Of the median ratio, of all runs, of a verdict. */
static const double default_interval = 0.02, default_budget_s = 60, default_least_effect = 0.02;

/* Checks the matrix and counts its rows. */
static bool check_matrix(struct pen_bench_spec *spec, struct pen_errors *errors)
{
    if (!pen_setting_lists_check(spec->matrix, "matrix", errors))
        return false;
    const double rows = pen_setting_lists_product(spec->matrix);
    if (rows > PEN_BENCH_ROWS_MAX) {
        pen_request_fail(errors, PEN_INVALID, "", "matrix",
                         "makes %.0f rows, at most %d are allowed", rows, (int)PEN_BENCH_ROWS_MAX);
        return false;
    }
    spec->row_count = (int)rows;
    return true;
}

static bool make_rows(struct pen_bench_spec *spec, const struct pen_settings *base,
                      struct pen_errors *errors)
{
    struct pen_errors none = {0};
    spec->rows = calloc((size_t)spec->row_count, sizeof *spec->rows);
    bool ok = spec->rows != NULL;
    for (int i = 0; ok && i < spec->row_count; i++) {
        json_t *varied = pen_setting_lists_combination(spec->matrix, i);
        spec->rows[i] = (struct pen_bench_row){.settings = *base, .varied = varied};
        ok = varied && pen_settings_read(varied, "", &spec->rows[i].settings, &none);
    }
    if (!ok)
        pen_request_fail(errors, PEN_NO_MEMORY, "", NULL, "no memory for %d rows", spec->row_count);
    return ok;
}

static bool check_baseline(const struct pen_bench_spec *spec, const json_t *baseline,
                           struct pen_errors *errors)
{
    const char *key;
    json_t *value;
    bool ok = true;
    json_object_foreach((json_t *)(uintptr_t)baseline, key, value)
    {
        const json_t *list = json_object_get(spec->matrix, key);
        if (list && pen_setting_listed(list, value))
            continue;
        pen_request_fail(errors, PEN_INVALID, "/baseline", key,
                         list ? "must be one of the matrix's values, found %s"
                              : "must be a key of the matrix, which lacks it; found %s",
                         pen_found(value).text);
        ok = false;
    }
    return ok;
}

static bool row_has(const struct pen_bench_row *row, const json_t *wanted)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)wanted, key, value)
    {
        if (!pen_value_equal(json_object_get(row->varied, key), value))
            return false;
    }
    return true;
}

/* Finds the first row that has all the values that the baseline names. */
static bool read_baseline(struct pen_bench_spec *spec, const json_t *baseline,
                          struct pen_errors *errors)
{
    if (!baseline || json_is_null(baseline))
        return true;
    if (!json_is_object(baseline)) {
        pen_request_fail(errors, PEN_INVALID, "", "baseline",
                         "must be an object with values of the matrix, found %s",
                         pen_found(baseline).text);
        return false;
    }
    if (!check_baseline(spec, baseline, errors))
        return false;
    while (!row_has(&spec->rows[spec->baseline], baseline))
        spec->baseline++;
    return true;
}

bool pen_repeats_read(const json_t *members, int *repeats, struct pen_errors *errors)
{
    *repeats = 3;
    return pen_integer_read(members, "", "repeats", 1, PEN_BENCH_REPEATS_MAX, repeats, errors);
}

/* Returns true if the members ask to run until an interval or a budget is reached. */
static bool asks_interval(const json_t *members)
{
    return json_object_get(members, "interval") || json_object_get(members, "budget_seconds");
}

/* Reads how often rows are run, and by what the times are judged. */
static bool read_method(const json_t *members, struct pen_bench_spec *spec,
                        struct pen_errors *errors)
{
    bool ok = pen_repeats_read(members, &spec->repeats, errors);
    ok &= pen_integer_read(members, "", "warmup", 0, PEN_BENCH_WARMUP_MAX, &spec->warmup, errors);
    ok &= pen_integer_read(members, "", "order_seed", 0, INT_MAX, &spec->order_seed, errors);
    ok &= pen_number_read(members, "", "least_effect", 0, 1, "from 0 to 1", &spec->least_effect,
                          errors);
    if (!asks_interval(members))
        return ok;
    spec->interval = default_interval;
    ok &= pen_number_read(members, "", "interval", PEN_ABOVE_0, 1, "above 0 and at most 1",
                          &spec->interval, errors);
    ok &= pen_number_read(members, "", "budget_seconds", PEN_ABOVE_0, PEN_BENCH_BUDGET_MAX_S,
                          "above 0 and at most 86400", &spec->budget_s, errors);
    if (!json_object_get(members, "repeats"))
        return ok;
    pen_request_fail(errors, PEN_INVALID, "", "repeats",
                     "must not be there beside interval or budget_seconds, which end the repeats");
    return false;
}

/* Returns a seed that differs each time. */
static int clock_seed(void)
{
    return (int)((uint64_t)pen_clock_ns() * UINT64_C(0x9e3779b97f4a7c15) >> 33);
}

bool pen_bench_spec_read(const json_t *members, const struct pen_settings *base,
                         struct pen_bench_spec *spec, struct pen_errors *errors)
{
    json_t *matrix = json_object_get(members, "matrix");
    *spec = (struct pen_bench_spec){.warmup = 1,
                                    .budget_s = default_budget_s,
                                    .least_effect = default_least_effect,
                                    .order_seed = clock_seed()};
    spec->matrix = matrix ? json_incref(matrix) : json_object();
    if (!spec->matrix) {
        pen_request_fail(errors, PEN_NO_MEMORY, "", NULL, "no memory for a matrix");
        return false;
    }
    const bool ok = read_method(members, spec, errors);
    if (!check_matrix(spec, errors) || !make_rows(spec, base, errors))
        return false;
    return read_baseline(spec, json_object_get(members, "baseline"), errors) && ok;
}

void pen_bench_spec_release(struct pen_bench_spec *spec)
{
    for (int i = 0; spec->rows && i < spec->row_count; i++)
        json_decref((json_t *)(uintptr_t)spec->rows[i].varied);
    free(spec->rows);
    json_decref(spec->matrix);
    *spec = (struct pen_bench_spec){0};
}

struct pen_bench pen_bench_of_spec(const struct pen_bench_spec *spec)
{
    return (struct pen_bench){.rows = spec->rows,
                              .row_count = spec->row_count,
                              .baseline = spec->baseline,
                              .repeats = spec->repeats,
                              .warmup = spec->warmup,
                              .interval = spec->interval,
                              .budget_ms = spec->budget_s * 1000,
                              .least_effect = spec->least_effect,
                              .order_seed = (uint64_t)spec->order_seed};
}

json_t *pen_bench_spec_members(const struct pen_bench_spec *spec, json_t *object)
{
    object = pen_json_with(object, "warmup", json_integer(spec->warmup));
    object = pen_json_with(object, "least_effect", json_real(spec->least_effect));
    object = pen_json_with(object, "order_seed", json_integer(spec->order_seed));
    object = pen_json_with(object, "baseline",
                           json_copy((json_t *)(uintptr_t)spec->rows[spec->baseline].varied));
    if (!(spec->interval > 0))
        return pen_json_with(object, "repeats", json_integer(spec->repeats));
    object = pen_json_with(object, "interval", json_real(spec->interval));
    return pen_json_with(object, "budget_seconds", json_real(spec->budget_s));
}

/* Returns the primary and shadow rays of all runs: the timed runs, the runs of the baseline's twin,
 * and one more run of each row, which counts tests. If a budget ends the repeats, only the first
 * repeat counts, because the budget bounds the others. Forking paths do not count here, because
 * pen_limits_check checks each run separately. */
static double work_of(const struct pen_bench_spec *spec, const struct pen_scene_desc *desc,
                      int views)
{
    const struct pen_bench bench = pen_bench_of_spec(spec);
    const int passes = spec->warmup + (spec->interval > 0 ? 1 : spec->repeats);
    double work = 0;
    for (int i = 0; i < spec->row_count; i++) {
        const struct pen_settings *s = &spec->rows[i].settings;
        const int twins = i == spec->baseline && pen_bench_has_twin(&bench);
        work +=
            (double)s->width * s->height * pen_work_per_pixel(desc, s) * (passes * (1 + twins) + 1);
    }
    return work * views;
}

bool pen_bench_spec_check(const struct pen_bench_spec *spec, const struct pen_limits *limits,
                          const struct pen_scene_desc *desc, int views, struct pen_status *st)
{
    struct pen_bench bench = pen_bench_of_spec(spec);
    bench.view_count = views;
    for (int i = 0; i < spec->row_count; i++) {
        if (!pen_limits_check(limits, desc, &spec->rows[i].settings, (uint32_t)views, matrix_at,
                              st))
            return false;
    }
    double work = work_of(spec, desc, views), kept = pen_bench_reference_pixels(&bench);
    if (work > limits->work)
        return pen_fail_at(st, PEN_TOO_LARGE, matrix_at,
                           "all runs of %d rows together take up to %.3g primary and shadow rays, "
                           "at most %.3g are allowed",
                           spec->row_count, work, limits->work);
    if (!pen_limits_check_time(limits, work, matrix_at, st))
        return false;
    if (kept > (double)limits->pixels_per_view)
        return pen_fail_at(st, PEN_TOO_LARGE, matrix_at,
                           "the pictures to be compared have %.0f pixels together, at most %llu "
                           "are allowed",
                           kept, (unsigned long long)limits->pixels_per_view);
    return true;
}

/* Returns the settings without those that the matrix varies. */
static json_t *shared_settings(const struct pen_bench_spec *spec, const struct pen_settings *base)
{
    json_t *render = pen_settings_json(base);
    const char *key;
    json_t *list;
    json_object_foreach(spec->matrix, key, list)
    {
        json_object_del(render, key);
    }
    return render;
}

json_t *pen_bench_spec_head(const struct pen_bench_spec *spec, const struct pen_bench *bench,
                            const struct pen_settings *base)
{
    const char *name = bench->frame.desc->name;
    json_t *views = json_array();
    for (int i = 0; i < bench->view_count; i++)
        json_array_append_new(views, json_string(bench->frame.desc->views[bench->views[i]].name));
    return json_pack("{s:s, s:s, s:o, s:I, s:O, s:o}", "kind", "benchmark", "scene",
                     name ? name : "", "views", pen_json_all(views, (size_t)bench->view_count),
                     "primitives", (json_int_t)bench->frame.desc->primitive_count, "matrix",
                     spec->matrix, "render", shared_settings(spec, base));
}

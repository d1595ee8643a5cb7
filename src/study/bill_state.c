/* SPDX-License-Identifier: MIT */
/* A bill's state as JSON, and the rows' pictures, so that another process goes on where this one
 * ended. */
#include "study/internal/bill_state.h"

#include <string.h>

#include "base/cpu.h"
#include "io/json_build.h"
#include "study/internal/kept_state.h"

enum { VERSION = 2, TIMES = 3 };

_Static_assert((int)PEN_FX_COUNT + 1 <= (int)PEN_STUDY_PICTURES_MAX, "a place for each row");

/* How often a row has run after `done` runs, without the run to warm up; -1: not even that. */
static int repeats_of(const struct pen_bill *bill, int row)
{
    return bill->done / bill->rows - (row >= bill->done % bill->rows);
}

/* The time of each run, its share of the processors, and 1 if it is spoiled. */
static json_t *runs_json(const struct pen_bill_row *row, int count)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) {
        const double values[TIMES] = {row->runs[i].ms, row->runs[i].used, row->runs[i].spoiled};
        json_array_append_new(list, pen_kept_numbers(values, TIMES));
    }
    return pen_json_all(list, (size_t)count);
}

static json_t *rows_json(const struct pen_bill *bill)
{
    json_t *list = json_array();
    for (int i = 0; i < bill->rows; i++) {
        const struct pen_bill_row *row = &bill->row[i];
        const int repeats = repeats_of(bill, i);
        json_array_append_new(
            list, json_pack("{s:s, s:o, s:o, s:o}", "kernel", row->kernel ? row->kernel : "",
                            "hash", pen_kept_hash(row->hash), "rays", pen_kept_rays(&row->rays),
                            "runs", runs_json(row, repeats > 0 ? repeats : 0)));
    }
    return pen_json_all(list, (size_t)bill->rows);
}

static json_t *state_json(const void *study)
{
    const struct pen_bill *bill = study;
    return json_pack("{s:i, s:O, s:i, s:i, s:i, s:o}", "version", VERSION, "host", bill->host,
                     "pool_threads", pen_thread_pool_size(bill->task->pool), "repeats",
                     bill->task->repeats, "done", bill->done, "rows", rows_json(bill));
}

/* The picture of a row that has run. */
static struct pen_study_picture picture_of(const struct pen_bill *bill, int row)
{
    return repeats_of(bill, row) < 0
               ? (struct pen_study_picture){0}
               : (struct pen_study_picture){bill->row[row].rgb, bill->row[row].hash};
}

bool pen_bill_between(const struct pen_bill *bill, struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    struct pen_unfinished unfinished = {.done = bill->done,
                                        .study = bill,
                                        .state = state_json,
                                        .width = task->settings->width,
                                        .height = task->settings->height,
                                        .picture_count = bill->rows};
    for (int i = 0; i < bill->rows; i++)
        unfinished.picture[i] = picture_of(bill, i);
    return !task->between || task->between(task->user, &unfinished) ||
           pen_fail(st, PEN_UNAVAILABLE, "interrupted after %d of %d renders", bill->done,
                    bill->rows * (task->repeats + 1));
}

/* This program's name of a kernel; NULL: it has none of that name. */
static const char *kernel_name(const char *name)
{
    const struct pen_kernel *kernel;
    for (int i = 0; name && (kernel = pen_kernel_at(i, pen_cpu_isa())); i++)
        if (strcmp(kernel->name, name) == 0)
            return kernel->name;
    return NULL;
}

/* Reads a row that has run. */
static bool read_row(struct pen_bill *bill, int number, const json_t *kept)
{
    struct pen_bill_row *row = &bill->row[number];
    const json_t *runs = json_object_get(kept, "runs");
    const int repeats = repeats_of(bill, number);
    row->kernel = kernel_name(json_string_value(json_object_get(kept, "kernel")));
    if (!row->kernel || !json_is_array(runs) || json_array_size(runs) != (size_t)repeats ||
        !pen_kept_read_hash(json_object_get(kept, "hash"), &row->hash) ||
        !pen_kept_read_rays(json_object_get(kept, "rays"), &row->rays))
        return false;
    for (int i = 0; i < repeats; i++) {
        const json_t *values = json_array_get(runs, (size_t)i);
        if (!pen_kept_is_numbers(values, TIMES, false))
            return false;
        row->runs[i] = (struct pen_run_time){.ms = pen_kept_number(values, 0),
                                             .used = pen_kept_number(values, 1),
                                             .spoiled = pen_kept_number(values, 2) != 0};
    }
    return true;
}

static bool read_rows(struct pen_bill *bill, const struct pen_kept_study *kept)
{
    const struct pen_settings *s = bill->task->settings;
    const json_t *rows = json_object_get(kept->state, "rows");
    if (json_array_size(rows) != (size_t)bill->rows)
        return false;
    for (int i = 0; i < bill->rows && repeats_of(bill, i) >= 0; i++) {
        if (!read_row(bill, i, json_array_get(rows, (size_t)i)) ||
            !kept->picture(kept->user, i, bill->row[i].hash, s->width, s->height, bill->row[i].rgb))
            return false;
    }
    return true;
}

bool pen_bill_state_read(struct pen_bill *bill, const struct pen_kept_study *kept)
{
    const int repeats = bill->task->repeats;
    bill->done = pen_kept_whole(kept->state, "done", bill->rows * (repeats + 1));
    if (pen_kept_whole(kept->state, "version", VERSION) == VERSION && bill->done > 0 &&
        pen_kept_whole(kept->state, "repeats", repeats) == repeats &&
        pen_kept_is_of_host(kept->state, bill->host, bill->task->pool) && read_rows(bill, kept))
        return true;
    bill->done = 0;
    return false;
}

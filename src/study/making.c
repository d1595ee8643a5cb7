/* SPDX-License-Identifier: MIT */
#include "study/internal/making.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "io/json_build.h"
#include "shade/kernel.h"
#include "study/host.h"

enum { VERSION = 3, COUNT_MAX = 1 << 30 };
static const double elapsed_max_ms = 1e12;

bool pen_making_begin(struct pen_making *making, struct pen_status *st)
{
    const struct pen_study_frame *frame = making->frame;
    making->begun_ns = pen_clock_ns();
    making->began_ms = pen_clock_wall_ms();
    making->host = frame->between || frame->kept ? pen_host_json() : json_null();
    return making->host || pen_fail(st, PEN_NO_MEMORY, "no memory for a study");
}

void pen_making_end(struct pen_making *making)
{
    json_decref(making->host);
    making->host = NULL;
}

double pen_making_spent_ms(const struct pen_making *making)
{
    return (double)(pen_clock_ns() - making->begun_ns) * 1e-6;
}

bool pen_making_check(const struct pen_making *making, struct pen_status *st)
{
    const atomic_bool *cancel = making->frame->cancel;
    return !cancel || !atomic_load_explicit(cancel, memory_order_relaxed) ||
           pen_fail(st, PEN_CANCELLED, "cancelled after %d of %d runs", making->done,
                    making->total);
}

static void report_progress(const struct pen_making *making)
{
    const struct pen_study_frame *frame = making->frame;
    const int done = making->done < making->total ? making->done : making->total;
    if (frame->progress)
        frame->progress(frame->user, done, making->total);
}

void pen_making_count(struct pen_making *making)
{
    making->done++;
    report_progress(making);
}

static json_t *member_json(const struct pen_kept_member *member, const void *record)
{
    const void *at = (const char *)record + member->offset;
    switch (member->type) {
    case PEN_KEPT_INT:
        return json_integer(*(const int *)at);
    case PEN_KEPT_BOOL:
        return json_boolean(*(const bool *)at);
    case PEN_KEPT_NUMBER:
        return isfinite(*(const double *)at) ? json_real(*(const double *)at) : json_null();
    case PEN_KEPT_SAME:
    case PEN_KEPT_COUNT:
        return json_integer((json_int_t) * (const uint64_t *)at);
    case PEN_KEPT_KERNEL:
        return json_string(*(const char *const *)at ? *(const char *const *)at : "");
    case PEN_KEPT_LIST:
        return json_copy(*(json_t *const *)at);
    }
    return NULL;
}

/* Adds the members of a record to an object. */
static json_t *with_record(json_t *object, const struct pen_kept_member *member, const void *record)
{
    for (; member && member->name; member++)
        object = pen_json_with(object, member->name, member_json(member, record));
    return object;
}

static json_t *row_json(const struct pen_making *making, int row)
{
    const struct pen_kept_shape *shape = making->shape;
    const int count = shape->runs(making->study, row);
    json_t *runs = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(
            runs, with_record(json_object(), shape->run, shape->run_at(making->study, row, i)));
    json_t *json = with_record(json_object(), shape->row, shape->row_at(making->study, row));
    return pen_json_with(json, "runs", pen_json_all(runs, count > 0 ? (size_t)count : 0));
}

static json_t *state_json(const void *study)
{
    const struct pen_making *making = study;
    const struct pen_kept_shape *shape = making->shape;
    json_t *rows = json_array();
    for (int i = 0; i < making->rows; i++)
        json_array_append_new(rows, row_json(making, i));
    json_t *json = json_pack("{s:i, s:s, s:O, s:i, s:f, s:I, s:i, s:i}", "version", (int)VERSION,
                             "kind", shape->kind, "host", making->host, "pool_threads",
                             pen_thread_pool_size(making->frame->pool), "elapsed_ms",
                             pen_making_spent_ms(making), "began_ms", (json_int_t)making->began_ms,
                             "breaks", making->breaks, "done", making->done);
    json = with_record(json, shape->study, making->study);
    json = with_record(json, shape->results, making->results);
    return pen_json_with(json, "rows", pen_json_all(rows, (size_t)making->rows));
}

static struct pen_study_picture picture_at(const struct pen_making *making, int place)
{
    return making->shape->picture(making->study, place);
}

bool pen_making_between(struct pen_making *making, struct pen_status *st)
{
    const struct pen_study_frame *frame = making->frame;
    struct pen_unfinished unfinished = {.done = making->done,
                                        .study = making,
                                        .state = state_json,
                                        .width = making->width,
                                        .height = making->height,
                                        .picture_count = making->pictures};
    for (int i = 0; i < making->pictures; i++)
        unfinished.picture[i] = picture_at(making, i);
    return !frame->between || frame->between(frame->user, &unfinished) ||
           pen_fail(st, PEN_UNAVAILABLE, "interrupted after %d of %d runs", making->done,
                    making->total);
}

static bool read_int(const json_t *value, int *out)
{
    const json_int_t number = json_integer_value(value);
    if (!json_is_integer(value) || number < 0 || number > COUNT_MAX)
        return false;
    *out = (int)number;
    return true;
}

/* The kernel of this program with this name; NULL: there is none. */
static const char *kernel_name(const char *name)
{
    const struct pen_kernel *kernel;
    for (int i = 0; name && (kernel = pen_kernel_at(i, pen_cpu_isa())); i++)
        if (strcmp(kernel->name, name) == 0)
            return kernel->name;
    return NULL;
}

static bool read_member(const struct pen_kept_member *member, void *record, const json_t *value)
{
    void *at = (char *)record + member->offset;
    switch (member->type) {
    case PEN_KEPT_SAME:
        return json_is_integer(value) && (uint64_t)json_integer_value(value) == *(uint64_t *)at;
    case PEN_KEPT_INT:
        return read_int(value, at);
    case PEN_KEPT_BOOL:
        *(bool *)at = json_is_true(value);
        return json_is_boolean(value);
    case PEN_KEPT_NUMBER:
        *(double *)at = json_is_null(value) ? HUGE_VAL : json_number_value(value);
        return json_is_null(value) || json_is_number(value);
    case PEN_KEPT_COUNT:
        *(uint64_t *)at = (uint64_t)json_integer_value(value);
        return json_is_integer(value);
    case PEN_KEPT_KERNEL:
        *(const char **)at = kernel_name(json_string_value(value));
        return json_is_string(value) && (*(const char **)at || !*json_string_value(value));
    case PEN_KEPT_LIST:
        return json_is_array(value) &&
               json_array_extend(*(json_t **)at, (json_t *)(uintptr_t)value) == 0;
    }
    return false;
}

static bool read_record(const struct pen_kept_member *member, void *record, const json_t *json)
{
    for (; member && member->name; member++)
        if (!read_member(member, record, json_object_get(json, member->name)))
            return false;
    return true;
}

/* Sets the members of a record to zero. */
static void clear_record(const struct pen_kept_member *member, void *record)
{
    static const size_t bytes[] = {
        [PEN_KEPT_INT] = sizeof(int),       [PEN_KEPT_BOOL] = sizeof(bool),
        [PEN_KEPT_NUMBER] = sizeof(double), [PEN_KEPT_COUNT] = sizeof(uint64_t),
        [PEN_KEPT_KERNEL] = sizeof(char *), [PEN_KEPT_LIST] = 0};
    for (; member && member->name; member++) {
        void *at = (char *)record + member->offset;
        if (member->type == PEN_KEPT_LIST)
            json_array_clear(*(json_t **)at);
        memset(at, 0, bytes[member->type]);
    }
}

static bool read_row(struct pen_making *making, int row, const json_t *json)
{
    const struct pen_kept_shape *shape = making->shape;
    const json_t *runs = json_object_get(json, "runs");
    const size_t count = json_array_size(runs);
    if (!read_record(shape->row, shape->row_at(making->study, row), json) || !json_is_array(runs) ||
        count > COUNT_MAX || !shape->take_runs(making->study, row, (int)count))
        return false;
    for (size_t i = 0; i < count; i++)
        if (!read_record(shape->run, shape->run_at(making->study, row, (int)i),
                         json_array_get(runs, i)))
            return false;
    return true;
}

static bool read_rows(struct pen_making *making, const json_t *list)
{
    bool ok = json_array_size(list) == (size_t)making->rows;
    for (int i = 0; ok && i < making->rows; i++)
        ok = read_row(making, i, json_array_get(list, (size_t)i));
    return ok && (!making->shape->rows_fit || making->shape->rows_fit(making->study));
}

static bool read_pictures(const struct pen_making *making)
{
    const struct pen_kept_study *kept = making->frame->kept;
    for (int i = 0; i < making->pictures; i++) {
        const struct pen_study_picture picture = picture_at(making, i);
        float *rgb = (float *)(uintptr_t)picture.rgb; /* memory of this study */
        if (rgb && !kept->picture(kept->user, i, picture.hash, making->width, making->height, rgb))
            return false;
    }
    return true;
}

static bool read_state(struct pen_making *making, const json_t *json)
{
    const struct pen_kept_shape *shape = making->shape;
    const char *kind = json_string_value(json_object_get(json, "kind"));
    const double elapsed_ms = json_number_value(json_object_get(json, "elapsed_ms"));
    int version, threads;
    if (!read_int(json_object_get(json, "version"), &version) || version != VERSION || !kind ||
        strcmp(kind, shape->kind) != 0 ||
        !json_equal(json_object_get(json, "host"), making->host) ||
        !read_int(json_object_get(json, "pool_threads"), &threads) ||
        threads != pen_thread_pool_size(making->frame->pool) ||
        !(elapsed_ms >= 0 && elapsed_ms < elapsed_max_ms) ||
        !read_int(json_object_get(json, "breaks"), &making->breaks) ||
        !read_int(json_object_get(json, "done"), &making->done) ||
        !read_record(shape->study, making->study, json) ||
        !read_record(shape->results, making->results, json) ||
        (shape->fits && !shape->fits(making->study)) ||
        !read_rows(making, json_object_get(json, "rows")) || !read_pictures(making))
        return false;
    making->breaks++;
    making->begun_ns -= (int64_t)(elapsed_ms * 1e6);
    making->began_ms = json_integer_value(json_object_get(json, "began_ms"));
    return true;
}

/* Resets the study to its beginning. */
static void forget(struct pen_making *making)
{
    const struct pen_kept_shape *shape = making->shape;
    clear_record(shape->study, making->study);
    clear_record(shape->results, making->results);
    for (int i = 0; i < making->rows; i++) {
        clear_record(shape->row, shape->row_at(making->study, i));
        shape->take_runs(making->study, i, 0);
    }
    making->done = making->breaks = 0;
}

bool pen_making_resume(struct pen_making *making)
{
    const struct pen_kept_study *kept = making->frame->kept;
    const bool goes_on = kept && kept->state && read_state(making, kept->state);
    if (!goes_on && kept)
        forget(making);
    report_progress(making);
    return goes_on;
}

/* SPDX-License-Identifier: MIT */
/* The statistics of a job, from those of its committed batches:
 *
 *   times, rays          sums over the batches; if several workers render at once, render_ms may be
 *                        longer than the elapsed time
 *   threads, memory      the largest of all batches
 *   percentiles          of all tiles together
 *   adaptive             of the view with the largest estimated error
 *   audit                of the view with the largest bound
 *   queue_ms, total_ms   from the times of the job itself
 *   store_ms             the time that workers waited for the store
 *
 * Each batch stores the time that the worker waited for the previous commit. The wait for the last
 * commit has no next batch. So it is stored beside the batch, as measured up to the commit's
 * transaction. */
#include <math.h>
#include <stdlib.h>

#include "io/figures.h"
#include "io/stats_json.h"
#include "jobs/internal/stats.h"

/* Members that are taken whole from one batch. */
static const char *const of_last[] = {"accelerator", "kernel", "effects", "host", "meshes", NULL};
static const char *const of_precision[] = {"precision", NULL};
static const char *const of_error[] = {"estimated_error", "adaptive", "render", "scene_sha256",
                                       NULL};
static const char *const of_audit[] = {"audit", NULL};

struct sum {
    json_t *sums;  /* owned; the members that are added up: reals are times, integers are counts */
    json_t *whole; /* owned; the members that are taken whole */
    json_int_t threads, peak_bytes; /* the largest */
    double last_commit_ms;
    struct pen_weighted_time *times;
    size_t time_count, time_capacity;
    bool no_memory, damaged;
};

/* Begins with the members that every statistics object has, even if no batch was committed. */
static struct sum begin(void)
{
    struct sum sum = {
        .sums = json_pack(
            "{s:{s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f}, s:{s:i, s:i, s:i, s:i, s:i}, s:{s:i}, "
            "s:f, s:i, s:i, s:i, s:i}",
            "timing", "queue_ms", 0.0, "parse_ms", 0.0, "build_ms", 0.0, "render_ms", 0.0,
            "encode_ms", 0.0, "store_ms", 0.0, "total_ms", 0.0, "cpu_ms", 0.0, "rays", "primary", 0,
            "shadow", 0, "reflection", 0, "transmission", 0, "total", 0, "tiles", "count", 0,
            "store_before_ms", 0.0, "dropped_samples", 0, "truncated_paths", 0, "unmatched_exits",
            0, "float_resets", 0),
        .whole =
            json_pack("{s:{}, s:s, s:[], s:{}}", "accelerator", "kernel", "", "effects", "host")};
    sum.no_memory = !sum.sums || !sum.whole;
    return sum;
}

/* Adds the members of `stats` to the members of `sums` with the same names. Fails if a time is not
 * finite. */
static bool add(json_t *sums, const json_t *stats)
{
    const char *key;
    json_t *sum;
    bool ok = true;
    json_object_foreach(sums, key, sum)
    {
        const json_t *more = json_object_get(stats, key);
        if (json_is_object(sum))
            ok &= add(sum, more);
        else if (json_is_real(sum))
            ok &= json_real_set(sum, json_real_value(sum) + json_number_value(more)) == 0;
        else
            json_integer_set(sum, (json_int_t)((uint64_t)json_integer_value(sum) +
                                               (uint64_t)json_integer_value(more)));
    }
    return ok;
}

static json_int_t larger(json_int_t a, const json_t *b)
{
    return json_integer_value(b) > a ? json_integer_value(b) : a;
}

static bool reserve_times(struct sum *sum, size_t more)
{
    size_t needed = sum->time_count + more;
    if (needed <= sum->time_capacity)
        return true;
    size_t capacity = needed + needed / 2;
    struct pen_weighted_time *times = realloc(sum->times, capacity * sizeof *times);
    if (!times)
        return !(sum->no_memory = true);
    sum->times = times;
    sum->time_capacity = capacity;
    return true;
}

static void add_tiles(struct sum *sum, const json_t *stats)
{
    const json_t *list = json_object_get(stats, "tile_ms");
    const size_t n = json_array_size(list);
    const double tiles =
        (double)json_integer_value(json_object_get(json_object_get(stats, "tiles"), "count"));
    if (n == 0 || !reserve_times(sum, n))
        return;
    for (size_t i = 0; i < n; i++) {
        const double ms = json_number_value(json_array_get(list, i));
        sum->damaged |= !isfinite(ms * 1e6); /* figures are rounded to a millionth */
        sum->times[sum->time_count++] =
            (struct pen_weighted_time){.ms = ms, .weight = tiles / (double)n};
    }
}

static void take(struct sum *sum, const json_t *stats, const char *const *keys)
{
    for (; *keys; keys++) {
        json_t *value = json_object_get(stats, *keys);
        if (value && json_object_set(sum->whole, *keys, value) != 0)
            sum->no_memory = true;
    }
}

/* Calls `take` if the first key's number (or its member, if that is not NULL) is larger than the
 * present number. Both are multiplied by `sign`. */
static void take_if_beyond(struct sum *sum, const json_t *stats, const char *const *keys,
                           const char *member, double sign)
{
    const json_t *more = json_object_get(stats, *keys), *has = json_object_get(sum->whole, *keys);
    const double to = json_number_value(member ? json_object_get(more, member) : more),
                 from = json_number_value(member ? json_object_get(has, member) : has);
    if (more && (!has || sign * to > sign * from))
        take(sum, stats, keys);
}

static bool take_batch(void *user, const struct pen_batch_stats *batch)
{
    struct sum *sum = user;
    json_t *stats = json_loads(batch->stats, 0, NULL);
    sum->damaged = !stats || !add(sum->sums, stats);
    sum->last_commit_ms = (double)batch->commit_us / 1000;
    sum->threads = larger(sum->threads, json_object_get(stats, "threads"));
    sum->peak_bytes =
        larger(sum->peak_bytes, json_object_get(json_object_get(stats, "memory"), "peak_bytes"));
    add_tiles(sum, stats);
    take(sum, stats, of_last);
    take_if_beyond(sum, stats, of_precision, "resolution", -1);
    take_if_beyond(sum, stats, of_error, NULL, 1);
    take_if_beyond(sum, stats, of_audit, "bound", 1);
    json_decref(stats);
    return !sum->damaged && !sum->no_memory;
}

/* Completes the times, and rounds them. */
static bool finish_timing(const struct sum *sum, const struct pen_job_record *job)
{
    json_t *timing = json_object_get(sum->sums, "timing"), *time;
    const int64_t queue_us = job->started_ms ? job->queue_us : job->elapsed_us;
    const double store_ms = json_real_value(json_object_get(sum->sums, "store_before_ms"));
    const char *key;
    bool ok = true;
    json_real_set(json_object_get(timing, "queue_ms"), (double)queue_us / 1000);
    json_real_set(json_object_get(timing, "store_ms"), store_ms + sum->last_commit_ms);
    json_real_set(json_object_get(timing, "total_ms"), (double)job->elapsed_us / 1000);
    json_object_foreach(timing, key, time)
    {
        ok &= json_real_set(time, round(json_real_value(time) * 1e6) / 1e6) == 0;
    }
    return ok;
}

static json_t *job_stats(const struct sum *sum)
{
    json_t *timing = json_object_get(sum->sums, "timing"),
           *rays = json_object_get(sum->sums, "rays"), *tiles = json_object_get(sum->sums, "tiles");
    const struct pen_ray_counts all = {
        .primary = (uint64_t)json_integer_value(json_object_get(rays, "total"))};
    const struct pen_percentiles ms = pen_percentiles_weighted(sum->times, sum->time_count);
    json_t *stats = json_pack(
        "{s:O, s:O, s:o, s:I, s:o, s:{s:I}}", "timing", timing, "rays", rays, "mrays_per_second",
        pen_figure_rate(&all, json_real_value(json_object_get(timing, "render_ms"))), "threads",
        sum->threads, "tiles",
        pen_stats_tiles((uint64_t)json_integer_value(json_object_get(tiles, "count")), &ms),
        "memory", "peak_bytes", sum->peak_bytes);
    json_object_del(sum->sums, "store_before_ms");
    if (stats && json_object_update(stats, sum->whole) == 0 &&
        json_object_update_missing(stats, sum->sums) == 0)
        return stats;
    json_decref(stats);
    return NULL;
}

/* Makes the statistics from the sums, which are released. NULL after an error. */
static json_t *finish(struct sum *sum, const struct pen_job_record *job, struct pen_status *st)
{
    json_t *stats = NULL;
    if (sum->no_memory)
        pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
    else if (sum->damaged || !finish_timing(sum, job))
        pen_fail(st, PEN_STORAGE, "stored statistics of job %s are damaged", job->id);
    else if (!(stats = job_stats(sum)))
        pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
    json_decref(sum->sums);
    json_decref(sum->whole);
    free(sum->times);
    return stats;
}

json_t *pen_stats_of_batches(const struct pen_batch_stats *batches, size_t count,
                             const struct pen_job_record *job, struct pen_status *st)
{
    struct sum sum = begin();
    for (size_t i = 0; i < count && take_batch(&sum, &batches[i]); i++)
        continue;
    return finish(&sum, job, st);
}

json_t *pen_stats_of_job(struct pen_store *store, const struct pen_job_record *job,
                         struct pen_status *st)
{
    struct sum sum = begin();
    struct pen_status why;
    const bool read = pen_store_stats(store, job->id, take_batch, &sum, &why);
    json_t *stats = finish(&sum, job, st);
    if (read)
        return stats;
    *st = why;
    json_decref(stats);
    return NULL;
}

/* SPDX-License-Identifier: MIT */
/* The statistics of a job, from those of its committed batches:
 *
 *   times, rays          sums over the batches; if several workers render at once, render_ms may be
 *                        longer than the time that has passed
 *   threads, memory      the largest of all batches
 *   percentiles          of all tiles together
 *   adaptive             of the view with the largest estimated error
 *   audit                of the view with the largest bound
 *   queue_ms, total_ms   from the times of the job itself
 *   store_ms             the time that workers waited for the store and for the compression of
 * pixels
 *
 * Each batch stores the waiting time before its own commit. No later batch stores that of the last
 * commit, so that up to the commit's transaction is stored beside them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/figures.h"
#include "io/stats_json.h"
#include "jobs/internal/stats.h"

struct sum {
    double parse_ms, build_ms, render_ms, encode_ms, store_ms, cpu_ms;
    double last_commit_ms;
    uint64_t float_resets;
    struct pen_ray_counts rays;
    int threads;
    int64_t peak_bytes;
    uint64_t tile_count;
    struct pen_weighted_time *times;
    size_t time_count, time_capacity;
    json_t *accelerator, *kernel, *effects, *host; /* owned; of the last batch that has them */
    json_t *precision;                  /* owned; of the view with the lowest resolution */
    json_t *estimated_error, *adaptive; /* owned; of the view with the largest estimated error */
    json_t *render, *scene_sha256;      /* owned; of a job with a budget */
    json_t *audit;                      /* owned; of the view with the largest bound */
    bool no_memory, damaged;
};

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

static uint64_t count_of(const json_t *object, const char *key)
{
    return (uint64_t)json_integer_value(json_object_get(object, key));
}

static void add_rays(struct sum *sum, const json_t *stats)
{
    const json_t *rays = json_object_get(stats, "rays");
    sum->rays.primary += count_of(rays, "primary");
    sum->rays.shadow += count_of(rays, "shadow");
    sum->rays.reflection += count_of(rays, "reflection");
    sum->rays.transmission += count_of(rays, "transmission");
    sum->rays.dropped_samples += count_of(stats, "dropped_samples");
    sum->rays.truncated_paths += count_of(stats, "truncated_paths");
    sum->rays.unmatched_exits += count_of(stats, "unmatched_exits");
    sum->float_resets += count_of(stats, "float_resets");
}

static void add_timing(struct sum *sum, const json_t *stats, int64_t commit_us)
{
    const json_t *timing = json_object_get(stats, "timing");
    sum->parse_ms += number(timing, "parse_ms");
    sum->build_ms += number(timing, "build_ms");
    sum->render_ms += number(timing, "render_ms");
    sum->encode_ms += number(timing, "encode_ms");
    sum->cpu_ms += number(timing, "cpu_ms");
    sum->store_ms += number(stats, "store_before_ms");
    sum->last_commit_ms = (double)commit_us / 1000;
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
    size_t n = json_array_size(list);
    uint64_t tiles = count_of(json_object_get(stats, "tiles"), "count");
    sum->tile_count += tiles;
    if (n == 0 || !reserve_times(sum, n))
        return;
    for (size_t i = 0; i < n; i++)
        sum->times[sum->time_count++] = (struct pen_weighted_time){
            .ms = json_number_value(json_array_get(list, i)), .weight = (double)tiles / (double)n};
}

static void keep_last(json_t **kept, const json_t *stats, const char *key)
{
    json_t *value = json_object_get(stats, key);
    if (!value)
        return;
    json_decref(*kept);
    *kept = json_incref(value);
}

static void keep_lowest_precision(struct sum *sum, const json_t *stats)
{
    const json_t *more = json_object_get(stats, "precision");
    if (more &&
        (!sum->precision || number(more, "resolution") < number(sum->precision, "resolution")))
        keep_last(&sum->precision, stats, "precision");
}

static void keep_largest_error(struct sum *sum, const json_t *stats)
{
    const json_t *more = json_object_get(stats, "estimated_error");
    if (more && (!sum->estimated_error ||
                 json_number_value(more) > json_number_value(sum->estimated_error))) {
        keep_last(&sum->estimated_error, stats, "estimated_error");
        keep_last(&sum->adaptive, stats, "adaptive");
        keep_last(&sum->render, stats, "render");
        keep_last(&sum->scene_sha256, stats, "scene_sha256");
    }
}

static void keep_largest_bound(struct sum *sum, const json_t *stats)
{
    const json_t *more = json_object_get(stats, "audit");
    if (more && (!sum->audit || number(more, "bound") > number(sum->audit, "bound")))
        keep_last(&sum->audit, stats, "audit");
}

static void add_batch(struct sum *sum, const json_t *stats, int64_t commit_us)
{
    int threads = (int)count_of(stats, "threads");
    int64_t peak = (int64_t)count_of(json_object_get(stats, "memory"), "peak_bytes");
    add_timing(sum, stats, commit_us);
    add_rays(sum, stats);
    add_tiles(sum, stats);
    sum->threads = threads > sum->threads ? threads : sum->threads;
    sum->peak_bytes = peak > sum->peak_bytes ? peak : sum->peak_bytes;
    keep_last(&sum->accelerator, stats, "accelerator");
    keep_last(&sum->kernel, stats, "kernel");
    keep_last(&sum->effects, stats, "effects");
    keep_last(&sum->host, stats, "host");
    keep_lowest_precision(sum, stats);
    keep_largest_error(sum, stats);
    keep_largest_bound(sum, stats);
}

static bool take_batch(void *user, const struct pen_batch_stats *batch)
{
    struct sum *sum = user;
    json_t *stats = json_loads(batch->stats, 0, NULL);
    sum->damaged = !stats;
    if (stats)
        add_batch(sum, stats, batch->commit_us);
    json_decref(stats);
    return !sum->damaged && !sum->no_memory;
}

static json_t *timing_json(const struct sum *sum, const struct pen_job_record *job)
{
    const int64_t queue_us = job->started_ms ? job->queue_us : job->elapsed_us;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "queue_ms",
                     pen_figure((double)queue_us / 1000), "parse_ms", pen_figure(sum->parse_ms),
                     "build_ms", pen_figure(sum->build_ms), "render_ms", pen_figure(sum->render_ms),
                     "encode_ms", pen_figure(sum->encode_ms), "store_ms",
                     pen_figure(sum->store_ms + sum->last_commit_ms), "total_ms",
                     pen_figure((double)job->elapsed_us / 1000), "cpu_ms", pen_figure(sum->cpu_ms));
}

/* Gives the members that every statistics object has their empty values if they are not known,
 * because no batch was committed. */
static bool fill_unknown(struct sum *sum)
{
    sum->accelerator = sum->accelerator ? sum->accelerator : json_object();
    sum->kernel = sum->kernel ? sum->kernel : json_string("");
    sum->effects = sum->effects ? sum->effects : json_array();
    sum->host = sum->host ? sum->host : json_object();
    return sum->accelerator && sum->kernel && sum->effects && sum->host;
}

static json_t *job_stats(struct sum *sum, const struct pen_job_record *job)
{
    if (!fill_unknown(sum))
        return NULL;
    struct pen_percentiles tiles = pen_percentiles_weighted(sum->times, sum->time_count);
    return json_pack("{s:o, s:o, s:o, s:i, s:o, s:O, s:O, s:O, s:{s:I}, s:I, s:I, s:I, s:I, "
                     "s:O, s:O*, s:O*, s:O*, s:O*, s:O*, s:O*}",
                     "timing", timing_json(sum, job), "rays", pen_figure_rays(&sum->rays),
                     "mrays_per_second", pen_figure_rate(&sum->rays, sum->render_ms), "threads",
                     sum->threads, "tiles", pen_stats_tiles(sum->tile_count, &tiles), "accelerator",
                     sum->accelerator, "kernel", sum->kernel, "effects", sum->effects, "memory",
                     "peak_bytes", (json_int_t)sum->peak_bytes, "dropped_samples",
                     (json_int_t)sum->rays.dropped_samples, "truncated_paths",
                     (json_int_t)sum->rays.truncated_paths, "unmatched_exits",
                     (json_int_t)sum->rays.unmatched_exits, "float_resets",
                     (json_int_t)sum->float_resets, "host", sum->host, "precision", sum->precision,
                     "estimated_error", sum->estimated_error, "adaptive", sum->adaptive, "audit",
                     sum->audit, "render", sum->render, "scene_sha256", sum->scene_sha256);
}

static void release(struct sum *sum)
{
    json_decref(sum->accelerator);
    json_decref(sum->kernel);
    json_decref(sum->effects);
    json_decref(sum->host);
    json_decref(sum->precision);
    json_decref(sum->estimated_error);
    json_decref(sum->adaptive);
    json_decref(sum->audit);
    json_decref(sum->render);
    json_decref(sum->scene_sha256);
    free(sum->times);
}

/* JSON has no infinite numbers; only damaged rows add up to one. */
static bool is_finite(const struct sum *sum)
{
    bool ok = isfinite(sum->parse_ms + sum->build_ms + sum->render_ms + sum->encode_ms) &&
              isfinite(sum->store_ms + sum->cpu_ms + sum->last_commit_ms);
    for (size_t i = 0; ok && i < sum->time_count; i++)
        ok = isfinite(sum->times[i].ms * 1e6); /* figures are rounded to millionths */
    return ok && isfinite(sum->render_ms * 1e6) && isfinite(sum->cpu_ms * 1e6);
}

/* The statistics from the sums, which are released. NULL after an error. */
static json_t *finish(struct sum *sum, const struct pen_job_record *job, struct pen_status *st)
{
    json_t *stats = NULL;
    if (sum->damaged || !is_finite(sum))
        pen_fail(st, PEN_STORAGE, "stored statistics of job %s are damaged", job->id);
    else if (sum->no_memory || !(stats = job_stats(sum, job)))
        pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
    release(sum);
    return stats;
}

json_t *pen_stats_of_batches(const struct pen_batch_stats *batches, size_t count,
                             const struct pen_job_record *job, struct pen_status *st)
{
    struct sum sum = {0};
    for (size_t i = 0; i < count && take_batch(&sum, &batches[i]); i++)
        continue;
    return finish(&sum, job, st);
}

json_t *pen_stats_of_job(struct pen_store *store, const struct pen_job_record *job,
                         struct pen_status *st)
{
    struct sum sum = {0};
    if (pen_store_stats(store, job->id, take_batch, &sum, st))
        return finish(&sum, job, st);
    release(&sum);
    return NULL;
}

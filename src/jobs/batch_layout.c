/* SPDX-License-Identifier: MIT */
/* The size of a batch: two seconds of work. A crash loses at most one batch. A job is cancelled,
 * previewed and shared between workers in steps of a batch.
 *
 * When a job is submitted, only an upper bound of its primary and shadow rays is known, times what
 * blur multiplies, and the rates that workers have reported. A batch that takes longer is divided
 * between two tiles while it is rendered (batch_render.c). So the client's tiles are used only if
 * none takes longer than a batch. A pixel has as many samples as the client asks for. A block of
 * pixels is never divided, and a cancel waits for its end. */
#include "jobs/internal/batch_layout.h"

#include <math.h>
#include <stdlib.h>

#include "jobs/internal/view_pixels.h"
#include "render/render.h"
#include "study/bill.h"

/* Of a batch, as planned. */
static const double BATCH_S = 2;

/* The rate of workers that have not reported theirs, in rays a second. Two threads do 8 to 50
 * million in a scene like the built-in room. */
static const double UNKNOWN_RATE = 4e6;

/* Bounds the rows of a job in the store. */
enum { JOB_BATCHES_MAX = 16384 };

enum { TILE_MAX = 64 };

/* With a target error, few pixels take max_samples, and not all in one round. */
static const double adaptive_share = 1.0 / 32;

static double rays_of_pixel(const struct pen_request *request)
{
    const struct pen_settings *s = &request->settings, sampling = pen_settings_sampling(s);
    const bool blurred = pen_effects_blur(pen_desc_effects(&request->desc, s));
    return pen_work_per_pixel(&request->desc, s) * (blurred ? sampling.blur_samples : 1) *
           (pen_settings_adaptive(s) ? adaptive_share : 1) * (1 + pen_request_layer_work(request));
}

int pen_batch_tile(const struct pen_request *request)
{
    const double rays = rays_of_pixel(request);
    int edge = request->settings.tile < TILE_MAX ? request->settings.tile : TILE_MAX;
    if (request->kind != PEN_KIND_RENDER && request->kind != PEN_KIND_EXPLAIN)
        return 0;
    while (edge > PEN_BLOCK_SIDE && edge * edge * rays > BATCH_S * UNKNOWN_RATE)
        edge = edge / 2 > PEN_BLOCK_SIDE ? edge / 2 : PEN_BLOCK_SIDE;
    return edge;
}

/* The bound of a view's rays. */
static double rays_of_view(const struct pen_request *request)
{
    const struct pen_settings *s = &request->settings;
    return (double)s->width * s->height * rays_of_pixel(request);
}

double pen_batch_bound_rays(const struct pen_request *request)
{
    return request->view_count * rays_of_view(request);
}

/* A view that takes longer than a batch has at least two batches for each worker, so that all
 * workers take part. */
static int batches_of_view(const struct pen_request *request,
                           const struct pen_batch_workers *workers, int tiles)
{
    if (pen_settings_adaptive(&request->settings))
        return 1; /* the decisions of a round need the whole picture */
    const double rate = workers->rays_per_s > 0 ? workers->rays_per_s : UNKNOWN_RATE;
    double wanted = ceil(rays_of_view(request) / (rate * BATCH_S));
    if (wanted > 1 && wanted < 2.0 * workers->count)
        wanted = 2.0 * workers->count;
    int most = JOB_BATCHES_MAX / request->view_count;
    if (most > tiles)
        most = tiles;
    return wanted < most ? (int)wanted : most;
}

bool pen_batch_needs_rate(const struct pen_request *request)
{
    enum { SLOWEST = 1000000 }; /* rays a second */
    return !pen_job_kind_has_report(request->kind) && !pen_settings_adaptive(&request->settings) &&
           rays_of_view(request) > BATCH_S * SLOWEST;
}

/* Makes the only batch of a study. Its progress is counted in runs. */
static struct pen_batch_new study_batch(const struct pen_request *request)
{
    const struct pen_bench bench = pen_bench_of_spec(&request->spec);
    const struct pen_accuracy_task accuracy = pen_accuracy_of_spec(&request->accuracy);
    struct pen_batch_new batch = {.kind = PEN_BATCH_STUDY};
    if (request->kind == PEN_KIND_BENCHMARK)
        batch.pixels = pen_bench_runs(&bench);
    else if (request->kind == PEN_KIND_EFFECTS)
        batch.pixels =
            pen_bill_runs(pen_bill_effects(&request->desc, request->views[0], &request->settings),
                          request->repeats);
    else if (request->kind == PEN_KIND_ACCURACY)
        batch.pixels = pen_accuracy_runs(&accuracy);
    else
        batch.pixels = request->analyze ? 2 : 1; /* a pre-render, and a render */
    return batch;
}

bool pen_batch_layout(const struct pen_request *request, const struct pen_batch_workers *workers,
                      struct pen_batch_new **batches, int *count, struct pen_status *st)
{
    const bool study = pen_job_kind_has_report(request->kind);
    struct pen_settings s = request->settings;
    s.tile = study ? s.tile : pen_batch_tile(request);
    int tiles = pen_tile_count(s.width, s.height, s.tile);
    int each = batches_of_view(request, workers, tiles);
    *count = study ? 1 : each * request->view_count;
    *batches = malloc((size_t)*count * sizeof **batches);
    if (!*batches)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %d batches", *count);
    if (study)
        **batches = study_batch(request);
    for (int i = 0; i < *count && !study; i++) {
        int first = (int)((int64_t)tiles * (i % each) / each);
        int end = (int)((int64_t)tiles * (i % each + 1) / each);
        (*batches)[i] = (struct pen_batch_new){.view = i / each,
                                               .first_tile = first,
                                               .tile_count = end - first,
                                               .pixels = pen_tiles_pixels(&s, first, end - first)};
    }
    return true;
}

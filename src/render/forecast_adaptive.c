/* SPDX-License-Identifier: MIT */
/* Adaptive renders of the view at two small sizes show the number of samples that an adaptive
 * render takes. Samples beyond the pilot are mostly spent at edges, whose share of the pixels falls
 * with the width of the picture, and in penumbrae and blur, whose share is constant. So their
 * number per pixel is modelled as a power of the width. The two sizes give the exponent. */
#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "math/fn.h"
#include "render/internal/forecast_adaptive.h"
#include "render/render.h"

/* The pixels of the larger of the two pictures. */
static const double SMALL_PIXELS = 4096;

/* The exponent is between 0, at which refined pixels keep their share, and LARGEST_POWER. The
 * interval allows it to be off by UPWARDS and DOWNWARDS; the pilot varies by PILOT_OFF. This was
 * tested over the ten built-in scenes, targets of 0.03, 0.02, 0.01 and 0.005, and pictures of 12
 * 000 and 90 000 pixels. The interval of all rays covers all 80 renders; their rays are 0.58 to
 * 1.37 times the expected number. */
static const double LARGEST_POWER = 1.5, UPWARDS = 2, DOWNWARDS = 0.75, PILOT_OFF = 0.05;

/* The time of a ray, including the overhead of rounds: processor time, and time by the clock if
 * every thread has its own processor. */
struct ray_time {
    double cpu_ms, ms;
};

/* A smaller picture of the view: its camera rays per pixel, the time of a ray, and whether a
 * deadline ended its rounds. */
struct small {
    double mean;
    struct ray_time ray;
    bool timed_out;
};

static double within(double low, double x, double high)
{
    return x < low ? low : x > high ? high : x;
}

enum { TIMED_TILE = 8 }; /* the deadline is tested between tiles */

/* Renders a smaller picture, in `part` of the remaining time. */
static bool render_small(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                         double shrink, double part, struct small *out, struct pen_status *st)
{
    const int64_t begun_ns = pen_clock_ns(), left_ns = task->deadline_ns - begun_ns;
    const bool timed = task->deadline_ns != 0;
    struct pen_settings s = *task->settings;
    s.width = (int)ceil(s.width * shrink);
    s.height = (int)ceil(s.height * shrink);
    if (timed && s.tile > TIMED_TILE)
        s.tile = TIMED_TILE;
    struct pen_render_stats stats;
    float *rgb = malloc(3 * sizeof *rgb * (size_t)s.width * (size_t)s.height);
    const struct pen_render_task render = {
        .scene = task->scene,
        .view = task->view,
        .settings = &s,
        .tile_count = -1,
        .rgb = rgb,
        .cancel = task->cancel,
        .deadline_ns = timed ? pen_clock_between(begun_ns, task->deadline_ns, part) : 0,
        .pixel_begins = task->pixel_begins,
        .pixel_user = task->pixel_user};
    const bool ok = rgb ? pen_render_run(pool, &render, &stats, st)
                        : pen_fail(st, PEN_NO_MEMORY, "out of memory for a forecast");
    free(rgb);
    if (!ok)
        return false;
    const struct pen_ray_counts *r = &stats.rays;
    out->mean = stats.adaptive.samples.mean;
    const double rays = (double)(r->primary + r->shadow + r->reflection + r->transmission);
    /* The clock continues while threads wait for a processor. Alone, a render takes at least the
     * time of threads that share its processor time evenly. */
    const double cpu_ms = stats.cpu_ms,
                 used = cpu_ms < stats.thread_ms ? cpu_ms / stats.thread_ms : 1;
    out->ray.cpu_ms = cpu_ms / rays;
    out->ray.ms = within(cpu_ms / stats.threads, used * stats.render_ms, HUGE_VAL) / rays;
    /* A round is not begun if too little time remains. */
    out->timed_out = timed && !stats.adaptive.met &&
                     (double)(stats.done_ns - begun_ns) > 0.5 * part * (double)left_ns;
    return true;
}

static double log2_of(double x)
{
    return x > 0 ? pen_ln(x) / pen_ln(2) : 0;
}

/* Extends the interval to the number that max_samples allows: rounds were ended early, and it is
 * unknown how many samples they would have taken. */
static void widen(struct pen_estimate *growth, double most)
{
    growth->high = most > growth->high ? most : growth->high;
    growth->expected = sqrt(growth->expected * growth->high);
}

/* The factor by which the camera rays of all rounds exceed those of the pilot, and the time of a
 * ray. */
static bool find_growth(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                        struct pen_estimate *growth, struct ray_time *ray, struct pen_status *st)
{
    const double pixels = (double)task->settings->width * task->settings->height;
    const double shrink = pixels > SMALL_PIXELS ? sqrt(SMALL_PIXELS / pixels) : 1;
    struct small large, small;
    if (!render_small(pool, task, shrink / 2, 0.25, &small, st) ||
        !render_small(pool, task, shrink, 1, &large, st))
        return false;
    *ray = large.ray;
    const double pilot = pen_settings_pilot(task->settings);
    const double more = large.mean / pilot - 1,
                 ratio = more > 0 ? (small.mean / pilot - 1) / more : 1;
    const double power = within(0, log2_of(ratio), LARGEST_POWER);
    growth->expected = 1 + more * pen_pow(shrink, power);
    growth->low = 1 - PILOT_OFF + more * pen_pow(shrink, power + UPWARDS);
    growth->high =
        1 + PILOT_OFF + more * pen_pow(shrink, power > DOWNWARDS ? power - DOWNWARDS : 0);
    if (small.timed_out || large.timed_out)
        widen(growth, task->settings->max_samples / pilot);
    return true;
}

static double both_off(double a, double b)
{
    return sqrt(a * a + b * b);
}

/* The product of two estimates with independent errors. */
static struct pen_estimate product(struct pen_estimate a, struct pen_estimate b)
{
    const double expected = a.expected * b.expected;
    if (!(expected > 0))
        return (struct pen_estimate){0, 0, a.high * b.high};
    const double down = both_off(1 - a.low / a.expected, 1 - b.low / b.expected);
    const double up = both_off(a.high / a.expected - 1, b.high / b.expected - 1);
    return (struct pen_estimate){expected, down < 1 ? expected * (1 - down) : 0,
                                 expected * (1 + up)};
}

bool pen_forecast_add_rounds(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                             struct pen_forecast *out, struct pen_status *st)
{
    struct pen_estimate growth, ray = out->cpu_ms;
    struct ray_time took;
    if (!pen_settings_adaptive(task->settings))
        return true;
    if (!find_growth(pool, task, &growth, &took, st))
        return false;
    struct pen_estimate *const all[] = {&out->primary, &out->shadow, &out->reflection,
                                        &out->transmission, &out->total};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        *all[i] = product(*all[i], growth);
    ray = pen_estimate_scaled(ray, ray.expected > 0 ? took.cpu_ms / ray.expected : 0);
    out->cpu_ms = product(out->total, ray);
    out->time_ms = pen_estimate_scaled(out->cpu_ms, took.cpu_ms > 0 ? took.ms / took.cpu_ms : 0);
    const double pixels = (double)task->settings->width * task->settings->height;
    out->memory_bytes += pixels * (double)(sizeof(struct pen_pixel_sums) +
                                           sizeof(struct pen_pixel_estimate) + sizeof(float) + 1);
    return true;
}

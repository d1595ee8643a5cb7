/* SPDX-License-Identifier: MIT */
/* References to measure errors against. They share nothing with the rule of adaptive rendering. */
#ifndef BENCH_REFERENCE_H
#define BENCH_REFERENCE_H

#include <math.h>

#include "bench/glow.h"
#include "bench/load_scene.h"
#include "film/encode.h"
#include "render/render.h"
#include "render/transfer.h"

/* The mean of two renders with fixed numbers of samples. */
struct bench_reference {
    const struct pen_settings *settings;
    struct pen_scene *scene;
    struct pen_thread_pool *pool;
    size_t values;
    float *mean;
    double error; /* half of the difference of the two renders */
};

static inline struct pen_render_stats bench_render(const struct bench_reference *r,
                                                   const struct pen_settings *settings, float *rgb)
{
    struct pen_status st;
    struct pen_render_stats stats;
    const struct pen_render_task task = {
        .scene = r->scene, .settings = settings, .tile_count = -1, .rgb = rgb};
    if (!pen_render_run(r->pool, &task, &stats, &st))
        bench_fail(st.msg);
    return stats;
}

static inline double bench_encoded(const struct bench_reference *r, float linear)
{
    return pen_encode_unit((double)linear, pen_settings_transfer(r->settings));
}

/* Returns the root mean square of the differences of all values, which api/scene-format.md defines
 * as the error of a picture. */
static inline double bench_difference(const struct bench_reference *r, const float *a,
                                      const float *b)
{
    double sum = 0;
    for (size_t i = 0; i < r->values; i++) {
        const double d = bench_encoded(r, a[i]) - bench_encoded(r, b[i]);
        sum += d * d;
    }
    return sqrt(sum / (double)r->values);
}

/* Renders one half of the reference. */
static inline void bench_reference_half(const struct bench_reference *r, struct pen_settings *s,
                                        uint64_t seed, float *rgb)
{
    s->seed = seed;
    if (!bench_glow_only(r->scene))
        bench_render(r, s, rgb);
    else if (!bench_glow_render(r->scene, s, seed, rgb))
        bench_fail("out of memory");
}

/* Renders the reference with one thread for each processor, and with seeds that no other render
 * uses. Scenes of spheres that only shine are rendered by glow.h. It borrows the description.
 * Owns: free with bench_reference_free. */
static inline void bench_reference_make(struct bench_reference *r,
                                        const struct pen_scene_desc *desc, int samples)
{
    struct pen_status st;
    struct pen_settings s = desc->settings;
    *r = (struct bench_reference){.settings = &desc->settings};
    r->values = 3 * (size_t)s.width * (size_t)s.height;
    r->mean = malloc(r->values * sizeof *r->mean);
    float *other = malloc(r->values * sizeof *other);
    if (!r->mean || !other)
        bench_fail("out of memory");
    if (!(r->pool = pen_thread_pool_new(0, &st)) ||
        !(r->scene = pen_scene_freeze(desc, PEN_ACCEL_AUTO, 0, &st)))
        bench_fail(st.msg);
    s.target_error = 0;
    s.samples_per_pixel = s.lens_samples = samples;
    s.light_samples = 16;
    s.blur_samples = 4;
    bench_reference_half(r, &s, 1000001, r->mean);
    bench_reference_half(r, &s, 1000002, other);
    r->error = bench_difference(r, r->mean, other) / 2;
    for (size_t i = 0; i < r->values; i++)
        r->mean[i] = (r->mean[i] + other[i]) / 2;
    free(other);
}

static inline void bench_reference_free(struct bench_reference *r)
{
    pen_scene_free(r->scene);
    pen_thread_pool_free(r->pool);
    free(r->mean);
}

#endif

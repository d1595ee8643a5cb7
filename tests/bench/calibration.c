/* SPDX-License-Identifier: MIT */
/* The error that was asked for, against the error that is reached.
 *
 * usage: calibration REFERENCE_SAMPLES SEEDS TARGET… < SCENE
 * Renders the scene with each target error and each seed from 1 to SEEDS, one thread for each
 * processor. What is reached is told by a reference, the mean of two renders with
 * REFERENCE_SAMPLES samples per pixel each, which know nothing of the rule of adaptive rendering;
 * half of their difference is the reference's own error. Prints a line for each render, its columns
 * parted by tabs: target, seed, reached error, estimated error, its interval's ends, whether the
 * target was met, rounds, capped pixels, samples per pixel, milliseconds of processor time, error
 * of the reference. */
#include <math.h>
#include <string.h>

#include "bench/load_scene.h"
#include "film/encode.h"
#include "render/render.h"

struct calibration {
    const struct pen_settings *settings;
    struct pen_scene *scene;
    struct pen_thread_pool *pool;
    size_t values;
    float *picture, *reference;
    double reference_error;
};

static struct pen_render_stats render(const struct calibration *c,
                                      const struct pen_settings *settings, float *rgb)
{
    struct pen_status st;
    struct pen_render_stats stats;
    const struct pen_render_task task = {
        .scene = c->scene, .settings = settings, .tile_count = -1, .rgb = rgb};
    if (!pen_render_run(c->pool, &task, &stats, &st))
        bench_fail(st.msg);
    return stats;
}

static double encoded(const struct calibration *c, float linear)
{
    return pen_encode_unit((double)linear, c->settings->transfer == PEN_SETTING_LINEAR
                                               ? PEN_TRANSFER_LINEAR
                                               : PEN_TRANSFER_SRGB);
}

/* The root mean square of the differences of all values, as api/scene-format.md defines the error.
 */
static double difference(const struct calibration *c, const float *a, const float *b)
{
    double sum = 0;
    for (size_t i = 0; i < c->values; i++) {
        const double d = encoded(c, a[i]) - encoded(c, b[i]);
        sum += d * d;
    }
    return sqrt(sum / (double)c->values);
}

/* Renders the reference, with seeds that no target is rendered with. */
static void make_reference(struct calibration *c, int samples)
{
    struct pen_settings s = *c->settings;
    s.target_error = 0;
    s.samples_per_pixel = s.lens_samples = samples;
    s.light_samples = 16;
    s.blur_samples = 4;
    s.seed = 1000001;
    render(c, &s, c->reference);
    s.seed = 1000002;
    render(c, &s, c->picture);
    c->reference_error = difference(c, c->reference, c->picture) / 2;
    for (size_t i = 0; i < c->values; i++)
        c->reference[i] = (c->reference[i] + c->picture[i]) / 2;
}

static void measure(const struct calibration *c, double target, uint64_t seed)
{
    struct pen_settings s = *c->settings;
    s.target_error = target;
    s.seed = seed;
    const struct pen_render_stats stats = render(c, &s, c->picture);
    const struct pen_adaptive_stats *a = &stats.adaptive;
    const struct pen_round *last = &a->round[a->rounds - 1];
    printf("%g\t%llu\t%.6f\t%.6f\t%.6f\t%.6f\t%d\t%d\t%llu\t%.2f\t%.1f\t%.6f\n", target,
           (unsigned long long)seed, difference(c, c->picture, c->reference), last->error,
           last->low, last->high, a->met, a->rounds, (unsigned long long)a->capped, a->samples.mean,
           stats.cpu_ms, c->reference_error);
    fflush(stdout);
}

static void calibrate(const struct pen_scene_desc *desc, char **argv)
{
    struct pen_status st;
    struct calibration c = {.settings = &desc->settings};
    c.values = 3 * (size_t)desc->settings.width * (size_t)desc->settings.height;
    c.picture = malloc(c.values * sizeof *c.picture);
    c.reference = malloc(c.values * sizeof *c.reference);
    if (!c.picture || !c.reference)
        bench_fail("out of memory");
    if (!(c.pool = pen_thread_pool_new(0, &st)) ||
        !(c.scene = pen_scene_freeze(desc, PEN_ACCEL_AUTO, 0, &st)))
        bench_fail(st.msg);
    make_reference(&c, atoi(argv[1]));
    for (char **target = argv + 3; *target; target++)
        for (int seed = 1; seed <= atoi(argv[2]); seed++)
            measure(&c, atof(*target), (uint64_t)seed);
    pen_scene_free(c.scene);
    pen_thread_pool_free(c.pool);
    free(c.picture);
    free(c.reference);
}

int main(int argc, char **argv)
{
    if (argc < 4 || atoi(argv[1]) < 1 || atoi(argv[2]) < 1)
        bench_fail("usage: calibration REFERENCE_SAMPLES SEEDS TARGET… < SCENE");
    size_t bytes;
    char *text = bench_read(&bytes);
    struct pen_arena *arena = pen_arena_new(0);
    const struct pen_scene_desc desc = bench_load(text, bytes, arena);
    calibrate(&desc, argv);
    pen_arena_free(arena);
    free(text);
    return 0;
}

/* SPDX-License-Identifier: MIT */
/* The requested error, beside the error that is reached.
 *
 * usage: calibration REFERENCE_SAMPLES SEEDS TARGET… < SCENE
 *
 * Renders the scene with each target error and each seed from 1 to SEEDS, with one thread for each
 * processor. The reached error is measured against a reference, the mean of two renders with
 * REFERENCE_SAMPLES samples per pixel each (reference.h). Prints a line for each render. Its
 * columns, with tabs between them, are: target, seed, reached error, estimated error, its
 * interval's ends, whether the target was met, rounds, capped pixels, samples per pixel,
 * milliseconds of processor time, error of the reference. */
#include "bench/reference.h"

static void measure(const struct bench_reference *r, double target, uint64_t seed, float *picture)
{
    struct pen_settings s = *r->settings;
    s.target_error = target;
    s.seed = seed;
    const struct pen_render_stats stats = bench_render(r, &s, picture);
    const struct pen_adaptive_stats *a = &stats.adaptive;
    const struct pen_round *last = &a->round[a->rounds - 1];
    printf("%g\t%llu\t%.6f\t%.6f\t%.6f\t%.6f\t%d\t%d\t%llu\t%.2f\t%.1f\t%.6f\n", target,
           (unsigned long long)seed, bench_difference(r, picture, r->mean), last->error, last->low,
           last->high, a->met, a->rounds, (unsigned long long)a->capped, a->samples.mean,
           stats.cpu_ms, r->error);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    if (argc < 4 || atoi(argv[1]) < 1 || atoi(argv[2]) < 1)
        bench_fail("usage: calibration REFERENCE_SAMPLES SEEDS TARGET… < SCENE");
    size_t bytes;
    char *text = bench_read(&bytes);
    struct pen_arena *arena = pen_arena_new(0);
    const struct pen_scene_desc desc = bench_load(text, bytes, arena);
    struct bench_reference r;
    bench_reference_make(&r, &desc, atoi(argv[1]));
    float *picture = malloc(r.values * sizeof *picture);
    if (!picture)
        bench_fail("out of memory");
    for (char **target = argv + 3; *target; target++)
        for (int seed = 1; seed <= atoi(argv[2]); seed++)
            measure(&r, atof(*target), (uint64_t)seed, picture);
    free(picture);
    bench_reference_free(&r);
    pen_arena_free(arena);
    free(text);
    return 0;
}

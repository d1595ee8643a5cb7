/* SPDX-License-Identifier: MIT */
/* How often the bound of an audit holds.
 *
 * usage: audits REFERENCE_SAMPLES AUDITS TARGET THRESHOLD < SCENE
 *
 * Renders the scene with the target error and each seed from 1 to AUDITS, and audits 300 pixels of
 * each picture. Compares the bound with the share of all pixels that are wrong by a reference: the
 * mean of two renders with REFERENCE_SAMPLES samples per pixel each. Prints the number of audits,
 * how often the bound held, the mean share of wrong pixels, and the mean of the bounds. */
#include <math.h>

#include "bench/reference.h"
#include "render/audit.h"
#include "study/hash.h"

enum { AUDITED = 300 };

/* The share of the pixels of which a channel is off by more than the threshold. */
static double wrong_share(const struct bench_reference *r, const float *picture, double threshold)
{
    size_t wrong = 0;
    for (size_t i = 0; i < r->values; i += 3) {
        double most = 0;
        for (size_t c = i; c < i + 3; c++)
            most = fmax(most, fabs(bench_encoded(r, picture[c]) - bench_encoded(r, r->mean[c])));
        wrong += most > threshold;
    }
    return 3.0 * (double)wrong / (double)r->values;
}

/* Renders and audits; returns the bound. */
static double audit(const struct bench_reference *r, const struct pen_settings *settings,
                    double threshold, float *picture)
{
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_audit found;
    const struct pen_film film = {settings->width, settings->height, picture};
    struct pen_adaptive *adaptive = pen_adaptive_new(settings, &st);
    const struct pen_render_task render = {
        .scene = r->scene, .settings = settings, .tile_count = -1, .rgb = picture};
    if (!adaptive || !pen_render_rounds(r->pool, &render, adaptive, &stats, &st))
        bench_fail(st.msg);
    const struct pen_audit_task task = {.scene = r->scene,
                                        .settings = settings,
                                        .rgb = picture,
                                        .adaptive = adaptive,
                                        .pixels = AUDITED,
                                        .threshold = threshold,
                                        .seed = pen_audit_seed(&film)};
    if (!pen_audit_run(r->pool, &task, &found, &st))
        bench_fail(st.msg);
    pen_adaptive_free(adaptive);
    return found.bound;
}

int main(int argc, char **argv)
{
    if (argc != 5)
        bench_fail("usage: audits REFERENCE_SAMPLES AUDITS TARGET THRESHOLD < SCENE");
    size_t bytes;
    char *text = bench_read(&bytes);
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc = bench_load(text, bytes, arena);
    struct bench_reference r;
    bench_reference_make(&r, &desc, atoi(argv[1]));
    const int audits = atoi(argv[2]);
    const double threshold = atof(argv[4]);
    float *picture = malloc(r.values * sizeof *picture);
    double shares = 0, bounds = 0;
    int held = 0;
    for (int seed = 1; picture && seed <= audits; seed++) {
        struct pen_settings s = desc.settings;
        s.target_error = atof(argv[3]);
        s.seed = (uint64_t)seed;
        const double bound = audit(&r, &s, threshold, picture);
        const double share = wrong_share(&r, picture, threshold);
        held += share <= bound;
        shares += share / audits;
        bounds += bound / audits;
    }
    printf("%d\t%d\t%.5f\t%.5f\n", audits, held, shares, bounds);
    free(picture);
    bench_reference_free(&r);
    pen_arena_free(arena);
    free(text);
    return 0;
}

/* SPDX-License-Identifier: MIT */
/* Times the choices of `auto` on a scene, beside the costs that the cost model expects
 * (src/accel/auto_choice.c).
 *
 * usage: choices RUNS [KEY=VALUE…] < SCENE
 *
 * KEY is a render setting, as for `penumbra render --set`. Prints a JSON object with the expected
 * cost of each choice, and its processor time per ray in ns: the median of RUNS interleaved runs by
 * one thread. */
#include <string.h>

#include "accel/internal/test_doors.h"
#include "bench/load_scene.h"
#include "bench/median.h"
#include "render/render.h"

enum { RUNS_MAX = 100 };

struct bench {
    const struct pen_settings *settings;
    struct pen_scene *scene;
    const struct pen_accel *accel[PEN_AUTO_COUNT];
    struct pen_thread_pool *pool;
    float *rgb;
};

/* Renders once; returns ns per ray. */
static double render(struct bench *b, int choice)
{
    struct pen_status st;
    struct pen_render_stats stats;
    b->scene->accel = b->accel[choice];
    struct pen_render_task task = {
        .scene = b->scene, .settings = b->settings, .tile_count = -1, .rgb = b->rgb};
    if (!pen_render_run(b->pool, &task, &stats, &st))
        bench_fail(st.msg);
    const struct pen_ray_counts *rays = &stats.rays;
    uint64_t sum = rays->primary + rays->shadow + rays->reflection + rays->transmission;
    return stats.cpu_ms * 1e6 / (double)sum;
}

static void print(struct bench *b, int runs)
{
    static double ns[PEN_AUTO_COUNT][RUNS_MAX];
    const struct pen_accel_stats *stats = pen_accel_get_stats(b->accel[0]);
    for (int r = 0; r < runs; r++) {
        for (int i = 0; i < PEN_AUTO_COUNT; i++)
            ns[i][r] = render(b, i);
    }
    printf("{");
    for (int i = 0; i < PEN_AUTO_COUNT; i++)
        printf("%s\"%s\": {\"expected\": %.3f, \"ns\": %.1f}", i ? ", " : "",
               pen_auto_choice_name((enum pen_auto_choice)i), stats->expected[i],
               bench_median(ns[i], runs));
    printf("}\n");
}

static void bench_choices(const struct pen_scene_desc *desc, int runs)
{
    struct pen_status st;
    struct bench b = {.settings = &desc->settings};
    const size_t pixels = (size_t)b.settings->width * (size_t)b.settings->height;
    b.scene = pen_scene_freeze(desc, PEN_ACCEL_AUTO, 0, &st);
    b.pool = pen_thread_pool_new(1, &st);
    b.rgb = calloc(pixels, 3 * sizeof *b.rgb);
    if (!b.scene || !b.pool || !b.rgb)
        bench_fail("out of memory, or no scene");
    for (int i = 0; i < PEN_AUTO_COUNT; i++) {
        b.accel[i] =
            pen_accel_build_choice(&b.scene->prims, (enum pen_auto_choice)i, b.scene->arena, &st);
        if (!b.accel[i])
            bench_fail(st.msg);
    }
    print(&b, runs);
    free(b.rgb);
    pen_thread_pool_free(b.pool);
    pen_scene_free(b.scene);
}

int main(int argc, char **argv)
{
    int runs = argc > 1 ? atoi(argv[1]) : 0;
    if (runs < 1 || runs > RUNS_MAX) {
        fprintf(stderr, "usage: choices RUNS [KEY=VALUE…] < SCENE   (1 to %d runs)\n", RUNS_MAX);
        return 2;
    }
    size_t bytes;
    char *text = bench_read(&bytes);
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc = bench_load(text, bytes, arena);
    for (int i = 2; i < argc; i++) {
        if (!pen_settings_set(&desc.settings, argv[i], &st))
            bench_fail(st.msg);
    }
    bench_choices(&desc, runs);
    pen_arena_free(arena);
    free(text);
    return 0;
}

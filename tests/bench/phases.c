/* SPDX-License-Identifier: MIT */
/* Times the phases of one picture in this process: reading the scene, freezing it (which includes
 * building the structure), rendering.
 *
 * usage: phases RUNS [KEY=VALUE…] < SCENE
 *
 * KEY is a render setting, as for `penumbra render --set`. Prints a JSON object: milliseconds,
 * medians of RUNS; `cpu_ms` is processor time of the render threads. */
#include <string.h>

#include "base/clock.h"
#include "bench/load_scene.h"
#include "bench/median.h"
#include "render/render.h"

enum { RUNS_MAX = 100, PHASES = 5 };

static const char *const phase_names[PHASES] = {"parse", "freeze", "build", "render", "cpu"};

static double ms_since(int64_t start)
{
    return (double)(pen_clock_ns() - start) / 1e6;
}

struct frame {
    double ms[PHASES];
    uint64_t rays, primitives;
};

static void render(const struct pen_scene_desc *desc, const struct pen_scene *scene,
                   struct frame *frame)
{
    struct pen_status st;
    const struct pen_settings *settings = &desc->settings;
    size_t pixels = (size_t)settings->width * (size_t)settings->height;
    float *rgb = calloc(pixels, 3 * sizeof *rgb);
    struct pen_thread_pool *pool = pen_thread_pool_new(settings->threads, &st);
    struct pen_render_task task = {
        .scene = scene, .settings = settings, .tile_count = -1, .rgb = rgb};
    struct pen_render_stats stats;
    if (!rgb || !pool || !pen_render_run(pool, &task, &stats, &st))
        bench_fail("rendering failed");
    frame->ms[3] = stats.render_ms;
    frame->ms[4] = stats.cpu_ms;
    frame->rays =
        stats.rays.primary + stats.rays.shadow + stats.rays.reflection + stats.rays.transmission;
    pen_thread_pool_free(pool);
    free(rgb);
}

static struct frame run(const char *text, size_t bytes, char **set, int set_count)
{
    struct frame frame = {0};
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    int64_t start = pen_clock_ns();
    struct pen_scene_desc desc = bench_load(text, bytes, arena);
    frame.ms[0] = ms_since(start);
    for (int i = 0; i < set_count; i++) {
        if (!pen_settings_set(&desc.settings, set[i], &st))
            bench_fail(st.msg);
    }
    start = pen_clock_ns();
    struct pen_scene *scene =
        pen_scene_freeze(&desc, (enum pen_accelerator)desc.settings.accelerator, 0, &st);
    if (!scene)
        bench_fail(st.msg);
    frame.ms[1] = ms_since(start);
    frame.ms[2] = pen_accel_get_stats(scene->accel)->build_ms;
    frame.primitives = scene->prims.count;
    render(&desc, scene, &frame);
    pen_scene_free(scene);
    pen_arena_free(arena);
    return frame;
}

int main(int argc, char **argv)
{
    static double ms[PHASES][RUNS_MAX];
    int runs = argc > 1 ? atoi(argv[1]) : 0;
    if (runs < 1 || runs > RUNS_MAX) {
        fprintf(stderr, "usage: phases RUNS [KEY=VALUE…] < SCENE   (1 to %d runs)\n", RUNS_MAX);
        return 2;
    }
    size_t bytes;
    char *text = bench_read(&bytes);
    struct frame frame = {0};
    for (int r = 0; r < runs; r++) {
        frame = run(text, bytes, argv + 2, argc - 2);
        for (int p = 0; p < PHASES; p++)
            ms[p][r] = frame.ms[p];
    }
    printf("{\"primitives\": %llu, \"rays\": %llu", (unsigned long long)frame.primitives,
           (unsigned long long)frame.rays);
    for (int p = 0; p < PHASES; p++)
        printf(", \"%s_ms\": %.3f", phase_names[p], bench_median(ms[p], runs));
    printf("}\n");
    free(text);
    return 0;
}

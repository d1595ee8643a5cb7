/* SPDX-License-Identifier: MIT */
/* Any bytes as the kept state of an unfinished batch. The first byte selects the state of an
 * adaptive render or of a benchmark. A state is used whole or not at all. */
#include "base/thread_pool.h"
#include "fuzz/fuzz.h"
#include "render/adaptive.h"
#include "render/adaptive_state.h"
#include "study/bench.h"
#include "study/internal/bench_state.h"

enum { WIDTH = 4, HEIGHT = 3, TILE = 2, TILES = 4, ROWS = 2, RUNS = 8 };

/* The rounds have ended, or one of them, perhaps the first, goes on at one of the tiles. */
static void check_adaptive_stats(const struct pen_adaptive_stats *stats)
{
    if (stats->ended) {
        must(stats->rounds > 0 && stats->rounds <= PEN_ROUNDS_MAX);
        return;
    }
    must(stats->rounds >= 0 && stats->rounds < PEN_ROUNDS_MAX);
    const int tiles = stats->round[stats->rounds].tiles;
    must(tiles >= 0 && tiles < TILES);
}

static void check_adaptive(const uint8_t *data, size_t size)
{
    struct pen_settings settings = pen_settings_default();
    struct pen_render_stats stats = {0};
    struct pen_status st = {0};
    float rgb[3 * WIDTH * HEIGHT];
    settings.width = WIDTH;
    settings.height = HEIGHT;
    settings.tile = TILE;
    settings.target_error = 0.5;
    struct pen_adaptive *adaptive = pen_adaptive_new(&settings, &st);
    must(adaptive != NULL);
    if (pen_adaptive_load(adaptive, data, size, "b", &stats, rgb, &st))
        check_adaptive_stats(&stats.adaptive);
    else
        must(st.code == PEN_NOT_FOUND);
    free(stats.tile_ms);
    pen_adaptive_free(adaptive);
}

static void check_bench(const uint8_t *data, size_t size)
{
    static struct pen_thread_pool *pool;
    static struct pen_bench_times runs[ROWS + 1][RUNS];
    struct pen_bench_row rows[ROWS] = {{.varied = NULL}};
    struct pen_bench_row_result results[ROWS] = {{.runs = runs[0]}, {.runs = runs[1]}};
    struct pen_status st;
    if (!pool)
        pool = pen_thread_pool_new(1, &st);
    must(pool != NULL);
    json_t *document = json_loadb((const char *)data, size, JSON_DECODE_ANY, NULL);
    const struct pen_kept_study kept = {.state = document};
    struct pen_bench bench = {.frame = {.pool = pool, .kept = &kept},
                              .rows = rows,
                              .row_count = ROWS,
                              .warmup = 1,
                              .order_seed = 7};
    struct pen_bench_result result = {.rows = results, .twin = {.runs = runs[ROWS]}};
    struct pen_bench_state state = {.making = {.frame = &bench.frame,
                                               .shape = &pen_bench_shape,
                                               .study = &state,
                                               .rows = ROWS + 1,
                                               .host = json_object()},
                                    .bench = &bench,
                                    .result = &result,
                                    .order_seed = 7,
                                    .warmup = 1,
                                    .repeats_max = RUNS};
    if (pen_making_resume(&state.making))
        must(state.place >= 0 && state.place < ROWS + 1 && pen_bench_repeats(&state) <= RUNS);
    else
        must(state.passes == 0 && state.place == 0 && results[0].picture_hash == 0);
    json_decref(document);
    json_decref(state.making.host);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 1)
        return 0;
    if (data[0] == 'a')
        check_adaptive(data + 1, size - 1);
    else
        check_bench(data + 1, size - 1);
    return 0;
}

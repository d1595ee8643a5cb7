/* SPDX-License-Identifier: MIT */
/* How often benchmarks judge rightly. Each comparison is a benchmark of two rows of the same
 * settings. The second row may be slowed by work that it repeats, so its right verdict is known.
 * The first row is also compared with the first row of the benchmark before, as two reports.
 *   verdicts COMPARISONS SLOWER BUDGET [SETTING=VALUE…] <scene.json
 * SLOWER is the slowdown, 0.05; BUDGET is the seconds for each comparison. Prints a line of JSON.
 *   verdicts --load SECONDS SEED
 * keeps a processor busy for random times, with random pauses, both of 0.05 to 1.5 s. */
#include <math.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "io/settings_json.h"
#include "load_scene.h"
#include "study/bench.h"
#include "study/comparison.h"
#include "support/random.h"

enum { VERDICTS = PEN_VERDICT_BASELINE + 1, PILOTS = 9 };

struct trial {
    struct pen_bench bench;
    double loops_per_ms, slower, row_ms;
    json_t *last; /* report */
    int rows[VERDICTS], reports[VERDICTS];
    long repeats;
    double spoiled;
};

/* Work that takes as long each time as others leave it. */
static void spin(double loops)
{
    volatile double sink = 1;
    for (double i = 0; i < loops; i++)
        sink = sink * 1.0000001 + 1e-9;
}

static double spin_rate(void)
{
    double best = 0;
    for (int i = 0; i < 20; i++) {
        const int64_t begun_ns = pen_clock_ns();
        spin(1e6);
        best = fmax(best, 1e6 / ((double)(pen_clock_ns() - begun_ns) * 1e-6));
    }
    return best;
}

static void dawdle(void *user, int row)
{
    const struct trial *trial = user;
    if (row == 1)
        spin(trial->slower * trial->row_ms * trial->loops_per_ms);
}

static void run(struct trial *trial, struct pen_bench_result *result)
{
    struct pen_status st;
    if (!pen_bench_run(&trial->bench, result, &st))
        bench_fail(st.msg);
}

/* What a row takes that is not slowed: the least of some runs, and the machine is to be idle. */
static void find_time(struct trial *trial)
{
    struct pen_bench_result result;
    struct pen_bench saved = trial->bench;
    trial->bench.repeats = PILOTS;
    trial->bench.interval = 0;
    trial->row_ms = 0;
    run(trial, &result);
    trial->row_ms = result.rows[0].min_ms;
    pen_bench_result_release(&trial->bench, &result);
    trial->bench = saved;
}

static int verdict_of_name(const char *name)
{
    int v = 0;
    while (v < VERDICTS && strcmp(pen_verdict_name((enum pen_verdict)v), name) != 0)
        v++;
    return v < VERDICTS ? v : PEN_VERDICT_UNDECIDED;
}

static void compare_reports(struct trial *trial, json_t *report)
{
    struct pen_status st;
    json_t *comparison = trial->last ? pen_comparison_new(trial->last, report, &st) : NULL;
    const json_t *row = json_array_get(json_object_get(comparison, "rows"), 0);
    if (comparison)
        trial->reports[verdict_of_name(json_string_value(json_object_get(row, "verdict")))]++;
    json_decref(comparison);
    json_decref(trial->last);
    trial->last = report;
}

static void compare(struct trial *trial, int number)
{
    struct pen_bench_result result;
    trial->bench.order_seed = (uint64_t)number;
    run(trial, &result);
    trial->rows[result.rows[1].verdict]++;
    trial->repeats += result.repeats;
    trial->spoiled += (double)result.rows[1].ratio.spoiled / result.repeats;
    compare_reports(trial, pen_bench_report_new(&trial->bench, &result,
                                                json_pack("{s:s}", "kind", "benchmark")));
    pen_bench_result_release(&trial->bench, &result);
}

static void print_counts(const char *name, const int counts[VERDICTS])
{
    printf("\"%s\": {", name);
    for (int v = 0; v < VERDICTS; v++)
        printf("%s\"%s\": %d", v ? ", " : "", pen_verdict_name((enum pen_verdict)v), counts[v]);
    printf("}");
}

static int load(double seconds, uint64_t seed)
{
    struct random random = {seed, seed};
    const int64_t end_ns = pen_clock_ns() + (int64_t)(seconds * 1e9);
    while (pen_clock_ns() < end_ns) {
        const int64_t until_ns = pen_clock_ns() + (int64_t)(random_in(&random, 0.05, 1.5) * 1e9);
        const double pause_s = random_in(&random, 0.05, 1.5);
        while (pen_clock_ns() < until_ns) {
        }
        nanosleep(&(struct timespec){.tv_sec = (time_t)pause_s,
                                     .tv_nsec = (long)((pause_s - floor(pause_s)) * 1e9)},
                  NULL);
    }
    return 0;
}

int main(int argc, char **argv)
{
    static const int views[] = {0};
    struct pen_status st;
    size_t bytes;
    if (argc == 4 && strcmp(argv[1], "--load") == 0)
        return load(atof(argv[2]), strtoull(argv[3], NULL, 10));
    if (argc < 4)
        bench_fail("verdicts COMPARISONS SLOWER BUDGET [SETTING=VALUE…] <scene.json");
    char *text = bench_read(&bytes);
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc = bench_load(text, bytes, arena);
    for (int i = 4; i < argc; i++)
        if (!pen_settings_set(&desc.settings, argv[i], &st))
            bench_fail(st.msg);
    /* The rows are named by a setting in which they do not differ. */
    struct pen_bench_row rows[] = {
        {.settings = desc.settings, .varied = json_pack("{s:i}", "tile", 1)},
        {.settings = desc.settings, .varied = json_pack("{s:i}", "tile", 2)}};
    struct trial trial = {.slower = atof(argv[2]),
                          .bench = {.frame = {.desc = &desc, .pool = pen_thread_pool_new(0, &st)},
                                    .views = views,
                                    .view_count = 1,
                                    .rows = rows,
                                    .row_count = 2,
                                    .warmup = 1,
                                    .interval = 0.02,
                                    .least_effect = 0.02,
                                    .budget_ms = atof(argv[3]) * 1000,
                                    .dawdle = dawdle}};
    trial.bench.frame.user = &trial;
    trial.loops_per_ms = spin_rate();
    find_time(&trial);
    const int comparisons = atoi(argv[1]);
    for (int i = 0; i < comparisons; i++)
        compare(&trial, i);
    printf("{\"comparisons\": %d, \"slower\": %g, \"row_ms\": %.3f, \"repeats\": %.1f, "
           "\"spoiled_share\": %.3f, ",
           comparisons, trial.slower, trial.row_ms, (double)trial.repeats / comparisons,
           trial.spoiled / comparisons);
    print_counts("rows", trial.rows);
    printf(", ");
    print_counts("reports", trial.reports);
    puts("}");
    json_decref(trial.last);
    json_decref((json_t *)(uintptr_t)rows[0].varied);
    json_decref((json_t *)(uintptr_t)rows[1].varied);
    pen_thread_pool_free(trial.bench.frame.pool);
    pen_arena_free(arena);
    free(text);
    return 0;
}

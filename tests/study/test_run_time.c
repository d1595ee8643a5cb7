/* SPDX-License-Identifier: MIT */
/* Times of runs: which runs count, and which of two rows is faster. */
#include "study/run_time.h"
#include "support/suite.h"

START_TEST(test_run_time__spoiled_runs_are_left_out)
{
    const struct pen_run_time runs[] = {{10, 1, false}, {90, 0.4, true}, {12, 0.99, false}},
                              spoiled[] = {{90, 0.4, true}, {70, 0.5, true}};
    struct pen_row_time time = pen_row_time_of(runs, 3);
    ck_assert(time.median == 11 && time.min == 10 && time.max == 12 && time.alone == 10);
    ck_assert(time.runs == 3 && time.spoiled == 1);
    time = pen_row_time_of(spoiled, 2);
    ck_assert(time.median == 80 && time.spoiled == 2);
}
END_TEST

START_TEST(test_run_time__rows_are_distinguished_if_their_intervals_lie_apart)
{
    static const struct {
        struct pen_run_time a[2], b[2];
        int order;
    } cases[] = {
        {{{10, 1, false}, {11, 1, false}}, {{12, 1, false}, {13, 1, false}}, -1},
        {{{12, 1, false}, {13, 1, false}}, {{10, 1, false}, {11, 1, false}}, 1},
        {{{10, 1, false}, {12.5, 1, false}}, {{12, 1, false}, {13, 1, false}}, 0}, /* overlap */
        {{{10, 1, false}, {11, 1, false}}, {{11.1, 1, false}, {13, 1, false}}, 0}, /* 1 % */
        {{{10, 1, false}, {11, 1, false}}, {{12, 0.9, false}, {13, 1, false}}, 0}, /* waited */
        {{{10, 1, false}, {30, 1, true}}, {{12, 1, false}, {13, 1, false}}, -1},
        {{{10, 1, true}, {11, 1, true}}, {{12, 1, false}, {13, 1, false}}, 0}};
    const struct pen_ray_counts few = {.shadow = 5}, many = {.primary = 5, .reflection = 1};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const struct pen_row_time a = pen_row_time_of(cases[i].a, 2),
                                  b = pen_row_time_of(cases[i].b, 2);
        ck_assert_msg(pen_row_time_compare(&a, &b) == cases[i].order, "%zu", i);
        const int cost = pen_row_cost_compare(&a, &many, &b, &few);
        ck_assert_msg(cost == (cases[i].order ? cases[i].order : 1), "%zu", i);
    }
}
END_TEST

/* Two threads that had a processor for 190 of 200 ms, and for less. */
START_TEST(test_run_time__threads_that_wait_spoil_a_run)
{
    struct pen_render_stats stats = {.threads = 2, .thread_ms = 200, .cpu_ms = 191};
    const struct pen_run_watch watch = pen_run_begin();
    struct pen_run_use use = pen_run_end(&watch, &stats, 0, 0);
    ck_assert(!use.spoiled && use.used == 0.955);
    stats.cpu_ms = 180;
    ck_assert(pen_run_end(&watch, &stats, 0, 0).spoiled);
    ck_assert(!pen_run_end(&watch, &stats, 500, 500).spoiled); /* a long build alone */
    stats = (struct pen_render_stats){.threads = 2, .thread_ms = 2, .cpu_ms = 1};
    ck_assert(!pen_run_end(&watch, &stats, 0, 0).spoiled); /* the time in which threads start */
}
END_TEST

START_TEST(test_run_time__over_half_withholds)
{
    struct pen_run_time runs[4] = {
        {10, 0.5, true}, {10, 0.5, true}, {10, 1, false}, {10, 1, false}};
    struct pen_runs_use use = {0};
    pen_runs_use_add(&use, runs, 4);
    ck_assert(!pen_runs_spoiled(&use) && use.used == 0.75);
    runs[2].spoiled = true;
    use = (struct pen_runs_use){0};
    pen_runs_use_add(&use, runs, 4);
    ck_assert(pen_runs_spoiled(&use));
}
END_TEST

PEN_SUITE("run_time", test_run_time__spoiled_runs_are_left_out,
          test_run_time__rows_are_distinguished_if_their_intervals_lie_apart,
          test_run_time__threads_that_wait_spoil_a_run, test_run_time__over_half_withholds)

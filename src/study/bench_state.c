/* SPDX-License-Identifier: MIT */
/* The saved state of a benchmark: the times of all runs, and the progress of the current pass. The
 * orders of passes follow from the seed. */
#include "study/internal/bench_state.h"

int pen_bench_repeats(const struct pen_bench_state *s)
{
    return s->passes > s->bench->warmup ? s->passes - s->bench->warmup : 0;
}

static void *row_at(void *study, int slot)
{
    struct pen_bench_state *s = study;
    return slot == s->bench->row_count ? &s->result->twin : &s->result->rows[slot];
}

static void *run_at(void *study, int slot, int run)
{
    struct pen_bench_row_result *row = row_at(study, slot);
    return &row->runs[run];
}

/* The number of runs of a slot: of whole repeats, and of a repeat in progress even if the slot has
 * not run in it. */
static int runs_of(const void *study, int slot)
{
    const struct pen_bench_state *s = study;
    (void)slot;
    return pen_bench_repeats(s) + (s->place > 0 && s->passes >= s->bench->warmup);
}

static bool take_runs(void *study, int slot, int count)
{
    return count == runs_of(study, slot);
}

static bool fits(const void *study)
{
    const struct pen_bench_state *s = study;
    return s->place < s->making.rows && runs_of(s, 0) <= s->repeats_max;
}

static const struct pen_kept_member study_members[] = {
    {"order_seed", PEN_KEPT_SAME, offsetof(struct pen_bench_state, order_seed)},
    {"warmup", PEN_KEPT_SAME, offsetof(struct pen_bench_state, warmup)},
    {"passes", PEN_KEPT_INT, offsetof(struct pen_bench_state, passes)},
    {"place", PEN_KEPT_INT, offsetof(struct pen_bench_state, place)},
    {"load_before", PEN_KEPT_NUMBER, offsetof(struct pen_bench_state, load_before)},
    {0}};

static const struct pen_kept_member row_members[] = {
    {"threads", PEN_KEPT_INT, offsetof(struct pen_bench_row_result, stats.threads)},
    {"picture_hash", PEN_KEPT_COUNT, offsetof(struct pen_bench_row_result, picture_hash)},
    {0}};

static const struct pen_kept_member run_members[] = {
    {"build_ms", PEN_KEPT_NUMBER, offsetof(struct pen_bench_times, build_ms)},
    {"render_ms", PEN_KEPT_NUMBER, offsetof(struct pen_bench_times, render_ms)},
    {"cpu_ms", PEN_KEPT_NUMBER, offsetof(struct pen_bench_times, cpu_ms)},
    {"cpu_share", PEN_KEPT_NUMBER, offsetof(struct pen_bench_times, used)},
    {"steal_ms", PEN_KEPT_NUMBER, offsetof(struct pen_bench_times, steal_ms)},
    {"spoiled", PEN_KEPT_BOOL, offsetof(struct pen_bench_times, spoiled)},
    {"in_a_row", PEN_KEPT_INT, offsetof(struct pen_bench_times, in_a_row)},
    {"calibration_ms", PEN_KEPT_NUMBER, offsetof(struct pen_bench_times, calibration_ms)},
    {0}};

const struct pen_kept_shape pen_bench_shape = {.kind = "benchmark",
                                               .study = study_members,
                                               .row = row_members,
                                               .run = run_members,
                                               .row_at = row_at,
                                               .run_at = run_at,
                                               .runs = runs_of,
                                               .take_runs = take_runs,
                                               .fits = fits};

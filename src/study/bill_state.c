/* SPDX-License-Identifier: MIT */
/* The saved state of a bill, and the rows' pictures. */
#include "study/internal/bill_state.h"

_Static_assert((int)PEN_FX_COUNT + 1 <= (int)PEN_STUDY_PICTURES_MAX, "a place for each row");

static void *row_at(void *study, int row)
{
    struct pen_bill_state *state = study;
    return &state->bill->row[row];
}

static void *run_at(void *study, int row, int run)
{
    struct pen_bill_row *of = row_at(study, row);
    return &of->runs[run];
}

/* The number of a row's runs without the warm-up; -1: not even the warm-up. */
static int repeats_of(const struct pen_bill_state *state, int row)
{
    const int done = state->making.done, rows = state->bill->rows;
    return done / rows - (row >= done % rows);
}

static int runs_of(const void *study, int row)
{
    const int repeats = repeats_of(study, row);
    return repeats > 0 ? repeats : 0;
}

static bool take_runs(void *study, int row, int count)
{
    return count == runs_of(study, row);
}

static bool fits(const void *study)
{
    const struct pen_bill_state *state = study;
    return state->making.done > 0 && state->making.done <= state->making.total;
}

/* Whether each row that has run has a kernel. */
static bool rows_fit(const void *study)
{
    const struct pen_bill_state *state = study;
    bool fit = true;
    for (int i = 0; i < state->bill->rows; i++)
        fit &= repeats_of(state, i) < 0 || state->bill->row[i].kernel;
    return fit;
}

/* The picture of a row that has run. */
static struct pen_study_picture picture(const void *study, int row)
{
    const struct pen_bill_state *state = study;
    const struct pen_bill_row *of = &state->bill->row[row];
    return repeats_of(state, row) < 0 ? (struct pen_study_picture){0}
                                      : (struct pen_study_picture){of->rgb, of->hash};
}

static const struct pen_kept_member row_members[] = {
    {"kernel", PEN_KEPT_KERNEL, offsetof(struct pen_bill_row, kernel)},
    {"picture_hash", PEN_KEPT_COUNT, offsetof(struct pen_bill_row, hash)},
    PEN_KEPT_RAYS(struct pen_bill_row, rays),
    {0}};

static const struct pen_kept_member run_members[] = {
    {"ms", PEN_KEPT_NUMBER, offsetof(struct pen_run_time, ms)},
    {"cpu_share", PEN_KEPT_NUMBER, offsetof(struct pen_run_time, used)},
    {"spoiled", PEN_KEPT_BOOL, offsetof(struct pen_run_time, spoiled)},
    {0}};

const struct pen_kept_shape pen_bill_shape = {.kind = "effects",
                                              .row = row_members,
                                              .run = run_members,
                                              .row_at = row_at,
                                              .run_at = run_at,
                                              .runs = runs_of,
                                              .take_runs = take_runs,
                                              .fits = fits,
                                              .rows_fit = rows_fit,
                                              .picture = picture};

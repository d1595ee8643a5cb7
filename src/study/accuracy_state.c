/* SPDX-License-Identifier: MIT */
/* The saved state of an accuracy study, and its pictures. The pictures of the rows' first runs are
 * saved, because the report shows them and a better reference is compared with them. The reference,
 * or its finished part, is saved because errors of further runs need it. All other pictures are
 * measured at once and not saved. */
#include "study/internal/accuracy_run.h"

_Static_assert((int)PEN_ACCURACY_ROWS_MAX + 2 <= (int)PEN_STUDY_PICTURES_MAX,
               "a place for each row and both renders of the reference");

static void *row_at(void *study, int row)
{
    struct pen_accuracy_state *state = study;
    return &state->out->row[row];
}

static void *run_at(void *study, int row, int run)
{
    struct pen_accuracy_row_result *result = row_at(study, row);
    return &result->run[run];
}

static int runs_of(const void *study, int row)
{
    const struct pen_accuracy_state *state = study;
    return state->out->row[row].runs;
}

static bool take_runs(void *study, int row, int count)
{
    struct pen_accuracy_state *state = study;
    const int seeds = state->task->seeds, most = state->pass == 0      ? 1
                                                 : state->pass < seeds ? state->pass + 1
                                                                       : seeds;
    state->out->row[row].runs = count <= most ? count : 0;
    return count <= most;
}

/* Whether the progress of the reference and of the pass are consistent. */
static bool fits(const void *study)
{
    const struct pen_accuracy_state *state = study;
    const struct pen_settings *s = state->task->settings;
    const int factor = state->out->reference.factor;
    return state->halves <= 2 && factor <= PEN_ACCURACY_FACTOR_MAX &&
           state->tiles < pen_tile_count(s->width, s->height, s->tile) &&
           (state->halves < 2 || state->tiles == 0) &&
           (factor > 0 || (state->halves == 0 && state->tiles == 0)) &&
           state->pass <= state->task->seeds && state->place <= state->task->row_count &&
           (state->pass == 0 || state->halves == 2) && (state->pass > 0 || state->place == 0);
}

/* Whether the order of the current pass has each row once, and whether the rows that must have run
 * have run. */
static bool rows_fit(const void *study)
{
    const struct pen_accuracy_state *state = study;
    const bool ran = state->halves > 0 || state->tiles > 0;
    bool seen[PEN_ACCURACY_ROWS_MAX] = {false}, any = false;
    for (int i = 0; i < state->task->row_count; i++) {
        const struct pen_accuracy_row_result *row = &state->out->row[i];
        if ((!row->wanted && row->runs > 0) || (ran && row->wanted && row->runs == 0) ||
            (state->place > 0 && (row->next >= state->task->row_count || seen[row->next])))
            return false;
        any |= row->wanted;
        if (state->place > 0)
            seen[row->next] = true;
    }
    return any;
}

/* The picture at a place: first those of the rows, then the two of the reference. */
static struct pen_study_picture picture(const void *study, int place)
{
    const struct pen_accuracy_state *state = study;
    const struct pen_accuracy *out = state->out;
    const int rows = state->task->row_count;
    if (place < rows && out->row[place].runs > 0)
        return (struct pen_study_picture){out->row[place].rgb, out->row[place].picture_hash};
    if (place == rows && (state->halves > 0 || state->tiles > 0))
        return (struct pen_study_picture){out->reference.rgb, state->half_hash[0]};
    if (place == rows + 1 && state->halves == 1 && state->tiles > 0)
        return (struct pen_study_picture){state->target, state->half_hash[1]};
    return (struct pen_study_picture){0};
}

#define OF_STATE(member) offsetof(struct pen_accuracy_state, member)
#define OF_RESULTS(member) offsetof(struct pen_accuracy, member)
#define OF_ROW(member) offsetof(struct pen_accuracy_row_result, member)
#define OF_RUN(member) offsetof(struct pen_accuracy_run, member)

static const struct pen_kept_member study_members[] = {
    {"halves", PEN_KEPT_INT, OF_STATE(halves)},
    {"tiles", PEN_KEPT_INT, OF_STATE(tiles)},
    {"first_hash", PEN_KEPT_COUNT, OF_STATE(half_hash[0])},
    {"second_hash", PEN_KEPT_COUNT, OF_STATE(half_hash[1])},
    {"pass", PEN_KEPT_INT, OF_STATE(pass)},
    {"place", PEN_KEPT_INT, OF_STATE(place)},
    {0}};

static const struct pen_kept_member results_members[] = {
    {"factor", PEN_KEPT_INT, OF_RESULTS(reference.factor)},
    {"reference_error", PEN_KEPT_NUMBER, OF_RESULTS(reference.error)},
    {"reference_ms", PEN_KEPT_NUMBER, OF_RESULTS(reference.render_ms)},
    {"expected_ms", PEN_KEPT_NUMBER, OF_RESULTS(forecast.expected_ms)},
    {"low_ms", PEN_KEPT_NUMBER, OF_RESULTS(forecast.low_ms)},
    {"high_ms", PEN_KEPT_NUMBER, OF_RESULTS(forecast.high_ms)},
    {"thread_ms", PEN_KEPT_NUMBER, OF_RESULTS(thread_ms)},
    {"had_ms", PEN_KEPT_NUMBER, OF_RESULTS(had_ms)},
    {"calibration_ms", PEN_KEPT_NUMBER, OF_RESULTS(calibration_ms)},
    {"left_out", PEN_KEPT_LIST, OF_RESULTS(left_out)},
    {0}};

static const struct pen_kept_member row_members[] = {
    {"wanted", PEN_KEPT_BOOL, OF_ROW(wanted)},
    {"next", PEN_KEPT_INT, OF_ROW(next)},
    {"expected_ms", PEN_KEPT_NUMBER, OF_ROW(expected_ms)},
    {"threads", PEN_KEPT_INT, OF_ROW(threads)},
    {"picture_hash", PEN_KEPT_COUNT, OF_ROW(picture_hash)},
    PEN_KEPT_RAYS(struct pen_accuracy_row_result, rays),
    {0}};

static const struct pen_kept_member run_members[] = {
    {"ms", PEN_KEPT_NUMBER, OF_RUN(time.ms)},
    {"cpu_share", PEN_KEPT_NUMBER, OF_RUN(time.used)},
    {"spoiled", PEN_KEPT_BOOL, OF_RUN(time.spoiled)},
    {"rmse", PEN_KEPT_NUMBER, OF_RUN(error[PEN_METRIC_RMSE])},
    {"relative_mse", PEN_KEPT_NUMBER, OF_RUN(error[PEN_METRIC_RELATIVE_MSE])},
    {"psnr", PEN_KEPT_NUMBER, OF_RUN(error[PEN_METRIC_PSNR])},
    {"ssim", PEN_KEPT_NUMBER, OF_RUN(error[PEN_METRIC_SSIM])},
    {"flip", PEN_KEPT_NUMBER, OF_RUN(error[PEN_METRIC_FLIP])},
    {"max_error", PEN_KEPT_NUMBER, OF_RUN(error[PEN_METRIC_MAX_ERROR])},
    {0}};

const struct pen_kept_shape pen_accuracy_shape = {.kind = "accuracy",
                                                  .study = study_members,
                                                  .results = results_members,
                                                  .row = row_members,
                                                  .run = run_members,
                                                  .row_at = row_at,
                                                  .run_at = run_at,
                                                  .runs = runs_of,
                                                  .take_runs = take_runs,
                                                  .fits = fits,
                                                  .rows_fit = rows_fit,
                                                  .picture = picture};

/* SPDX-License-Identifier: MIT */
/* The reference of an accuracy study: its settings, and the time that it may take.
 *
 * A pixel of the reference has the most camera rays that a pixel has in any row, times a factor.
 * The points on lights and the rays of cones, summed over a pixel, grow by the same factor. If
 * every row sees the scene through the centres of the pixels, the reference does too. Then the
 * jagged edges of the rows are not part of the error. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/encode.h"
#include "study/internal/accuracy_run.h"

enum { FACTOR = 8, FACTOR_MORE = 4 };
/* The samples of a pixel that are assumed for a row with a target error. */
enum { ADAPTIVE_CAMERA = 32, ADAPTIVE_LIGHT = 16, ADAPTIVE_BLUR = 4 };
enum { SEED_STEP = 1000000 }; /* larger than all seeds of rows */

static const double default_at_once_ms = 5000;
static const double most_of_best =
    0.2; /* the greatest error of the reference, as a share of the best row's error */

/* The most samples that a pixel has in any row. */
struct samples {
    double camera, light, blur; /* light, blur: summed over the camera rays of a pixel */
    bool area;                  /* spread over the pixel's area, not only at its centre */
};

static void add_row(struct samples *most, const struct pen_settings *s, bool lens)
{
    double camera = s->samples_per_pixel, light = s->light_samples, blur = s->blur_samples;
    if (lens && s->lens_samples > camera)
        camera = s->lens_samples;
    if (pen_settings_adaptive(s)) {
        camera = ADAPTIVE_CAMERA;
        light = ADAPTIVE_LIGHT;
        blur = ADAPTIVE_BLUR;
    }
    most->area |= camera > 1;
    most->camera = fmax(most->camera, camera);
    most->light = fmax(most->light, camera * light);
    most->blur = fmax(most->blur, camera * blur);
}

static int count_of(double samples)
{
    return samples < 1 ? 1 : samples < INT_MAX ? (int)ceil(samples) : INT_MAX;
}

/* Whether rows differ in a setting. */
static bool is_varied(const struct pen_accuracy_task *task, const char *key)
{
    return json_object_get(task->rows[0].varied, key) != NULL;
}

/* Sets the cut-offs of paths. If rows differ in a cut-off, the reference goes further than every
 * row. */
static void set_cutoffs(const struct pen_accuracy_task *task, struct pen_settings *s)
{
    struct pen_status ignored;
    for (int i = 0; i < task->row_count; i++) {
        const struct pen_settings *row = &task->rows[i].settings;
        s->max_depth = row->max_depth > s->max_depth ? row->max_depth : s->max_depth;
        s->min_contribution = fmin(s->min_contribution, row->min_contribution);
    }
    if (is_varied(task, "min_contribution"))
        s->min_contribution /= FACTOR;
    if (!is_varied(task, "max_depth"))
        return;
    struct pen_settings deeper = *s;
    deeper.max_depth = 2 * s->max_depth;
    if (pen_limits_check(&task->limits, task->frame.desc, &deeper, 1, "", &ignored))
        *s = deeper;
}

/* The settings of a reference with `factor` times the samples of the longest row that has run. The
 * task's own settings of the reference override them. */
static struct pen_settings settings_for(const struct pen_accuracy_state *state, int factor)
{
    const struct pen_accuracy_task *task = state->task;
    struct pen_settings s = *task->settings;
    struct samples most = {0};
    struct pen_errors ignored = {0};
    unsigned effects = 0;
    for (int i = 0; i < task->row_count; i++)
        effects |= pen_desc_effects(task->frame.desc, &task->rows[i].settings);
    const bool lens = effects & PEN_FX_DEPTH_OF_FIELD;
    for (int i = 0; i < task->row_count; i++)
        if (state->out->row[i].runs > 0)
            add_row(&most, &task->rows[i].settings, lens);
    s.target_error = 0;
    s.light_pattern = PEN_PATTERN_SOBOL;
    s.samples_per_pixel = most.area ? count_of(most.camera * factor) : 1;
    s.lens_samples = lens ? s.samples_per_pixel : s.lens_samples;
    if (effects & PEN_FX_SOFT_SHADOWS)
        s.light_samples = count_of(most.light * factor / s.samples_per_pixel);
    if (pen_effects_blur(effects))
        s.blur_samples = count_of(most.blur * factor / s.samples_per_pixel);
    set_cutoffs(task, &s);
    if (task->reference)
        pen_settings_read(task->reference, "", &s, &ignored); /* checked by the caller */
    s.target_error = 0;
    return s;
}

/* As settings_for, with the seed of the first of the two renders. */
static struct pen_settings settings_of(const struct pen_accuracy_state *state, int factor)
{
    struct pen_settings s = settings_for(state, factor);
    s.seed = state->task->settings->seed + SEED_STEP + (uint64_t)factor;
    return s;
}

/* The rays of a pixel, from counts of samples: a measure of time. */
static double work_of(const struct pen_accuracy_task *task, const struct pen_settings *s)
{
    return pen_work_per_pixel(task->frame.desc, s);
}

/* The settings of a row. For a row with a target error, fixed numbers of samples that give as many
 * camera rays as its first run had. */
static struct pen_settings fixed_settings(const struct pen_accuracy_state *state, int row)
{
    const struct pen_settings *asked = &state->task->rows[row].settings;
    struct pen_settings s = pen_settings_sampling(asked);
    if (pen_settings_adaptive(asked))
        s.samples_per_pixel = s.lens_samples =
            count_of((double)state->out->row[row].rays.primary * 3 / (double)state->values);
    return s;
}

/* The expected time of both renders of a reference, from the time of the row with the most rays. */
static double expected_ms(const struct pen_accuracy_state *state, const struct pen_settings *s)
{
    double most = 0, ms = 0;
    for (int i = 0; i < state->task->row_count; i++) {
        const struct pen_accuracy_row_result *result = &state->out->row[i];
        if (result->runs == 0)
            continue;
        const struct pen_settings fixed = fixed_settings(state, i);
        const double work = work_of(state->task, &fixed);
        if (work > most) {
            most = work;
            ms = result->run[0].time.ms;
        }
    }
    return 2 * ms / most * work_of(state->task, s);
}

/* Whether a reference fits into half of the remaining time. The limits of one render's work do not
 * apply, since the budget bounds the whole study. */
static bool fits(const struct pen_accuracy_state *state, int factor)
{
    const struct pen_settings s = settings_for(state, factor);
    return expected_ms(state, &s) <= pen_accuracy_left_ms(state) / 2;
}

/* The root mean square of the differences between two pictures' encoded values. */
static double difference(const float *a, const float *b, size_t values)
{
    double sum = 0;
    for (size_t i = 0; i < values; i++) {
        const double d = pen_encode_unit((double)a[i], PEN_TRANSFER_SRGB) -
                         pen_encode_unit((double)b[i], PEN_TRANSFER_SRGB);
        sum += d * d;
    }
    return sqrt(sum / (double)values);
}

/* The number of tiles that are rendered between two points at which the study may be saved or end.
 */
static int tiles_at_once(const struct pen_accuracy_state *state, int tiles)
{
    const double asked_ms = state->task->at_once_ms,
                 at_once_ms = asked_ms > 0 ? asked_ms : default_at_once_ms,
                 ms = expected_ms(state, &state->out->reference.settings) / 2,
                 groups = fmin(ceil(ms / at_once_ms), tiles);
    return groups > 1 ? (int)ceil(tiles / groups) : tiles;
}

/* Makes one of the two renders, or finishes one that an earlier process began. It is rendered in
 * groups of tiles, since it may take longer than any other step. Its time is not compared with
 * other times. */
static bool render_half(struct pen_accuracy_state *state, const struct pen_settings *s, float *rgb,
                        struct pen_status *st)
{
    const int all = pen_tile_count(s->width, s->height, s->tile),
              at_once = tiles_at_once(state, all);
    if (state->tiles == 0)
        memset(rgb, 0, state->values * sizeof *rgb);
    while (state->tiles < all) {
        const int left = all - state->tiles;
        struct pen_render_task render = {.settings = s,
                                         .rgb = rgb,
                                         .first_tile = state->tiles,
                                         .tile_count = left < at_once ? left : at_once};
        struct pen_render_stats stats;
        if (!pen_accuracy_render(state, &render, &stats, st))
            return false;
        state->out->reference.render_ms += stats.render_ms;
        state->tiles += render.tile_count;
        state->half_hash[state->halves] = pen_accuracy_hash(state, rgb);
        if (state->tiles < all && !pen_making_between(&state->making, st))
            return false;
    }
    state->tiles = 0;
    state->halves++;
    return true;
}

/* Makes the mean of both renders, and estimates its error. */
static void join_halves(struct pen_accuracy_state *state)
{
    struct pen_accuracy_reference *r = &state->out->reference;
    r->error = difference(r->rgb, state->target, state->values) / 2;
    for (size_t i = 0; i < state->values; i++)
        r->rgb[i] = (float)(((double)r->rgb[i] + (double)state->target[i]) / 2);
    state->half_hash[0] = pen_accuracy_hash(state, r->rgb);
}

/* Renders the reference with `factor` times the samples, in place of an earlier reference. Or
 * finishes one that an earlier process began. */
static bool render(struct pen_accuracy_state *state, int factor, struct pen_status *st)
{
    struct pen_accuracy_reference *r = &state->out->reference;
    r->factor = factor;
    r->settings = settings_of(state, factor);
    struct pen_settings other = r->settings;
    other.seed = r->settings.seed + SEED_STEP;
    if (state->halves == 0 && state->tiles == 0)
        r->render_ms = 0;
    if (state->halves == 0 &&
        (!render_half(state, &r->settings, r->rgb, st) || !pen_making_end_run(&state->making, st)))
        return false;
    if (state->halves == 2)
        return true;
    if (!render_half(state, &other, state->target, st))
        return false;
    join_halves(state);
    return pen_making_end_run(&state->making, st);
}

/* Compares the first picture of every row with the reference. *best becomes the least error of a
 * row. */
static bool measure_rows(const struct pen_accuracy_state *state, double *best,
                         struct pen_status *st)
{
    *best = HUGE_VAL;
    for (int i = 0; i < state->task->row_count; i++) {
        struct pen_accuracy_row_result *row = &state->out->row[i];
        if (row->runs == 0)
            continue;
        if (!pen_accuracy_measure(state, row->rgb, &row->run[0], st))
            return false;
        *best = fmin(*best, row->run[0].error[PEN_METRIC_RMSE]);
    }
    return true;
}

static bool note_short(const struct pen_accuracy_state *state, double best, struct pen_status *st)
{
    const struct pen_accuracy_reference *r = &state->out->reference;
    return r->error <= most_of_best * best ||
           pen_accuracy_left_out(
               state->out,
               json_sprintf("a better reference: the error of this one, with %d times the samples "
                            "of the longest row, is %.2g, which is more than a fifth of the best "
                            "row's, %.2g",
                            r->factor, r->error, best),
               st);
}

/* Whether the reference can be made again with more samples. */
static bool can_be_better(const struct pen_accuracy_state *state)
{
    const struct pen_accuracy_reference *r = &state->out->reference;
    const int factor = r->factor * FACTOR_MORE;
    const struct pen_settings s = settings_for(state, factor);
    return factor <= PEN_ACCURACY_FACTOR_MAX && fits(state, factor) &&
           work_of(state->task, &s) > work_of(state->task, &r->settings);
}

/* The first factor to try. If an earlier process began a reference, its factor. */
static int first_factor(const struct pen_accuracy_state *state)
{
    int factor = FACTOR;
    if (state->halves > 0 || state->tiles > 0)
        return state->out->reference.factor;
    while (factor > 1 && !fits(state, factor))
        factor /= 2;
    return factor;
}

bool pen_accuracy_make_reference(struct pen_accuracy_state *state, struct pen_status *st)
{
    struct pen_accuracy_reference *r = &state->out->reference;
    double best;
    if (state->pass > 0) {
        r->settings = settings_of(state, r->factor);
        return true;
    }
    if (!render(state, first_factor(state), st) || !measure_rows(state, &best, st))
        return false;
    while (r->error > most_of_best * best && can_be_better(state)) {
        state->halves = 0;
        if (!render(state, r->factor * FACTOR_MORE, st) || !measure_rows(state, &best, st))
            return false;
    }
    state->pass = 1;
    return note_short(state, best, st);
}

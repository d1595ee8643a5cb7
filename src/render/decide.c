/* SPDX-License-Identifier: MIT */
/* The decision after a round. Threads take slices of the picture. The number of slices does not
 * depend on the number of threads, and their sums are added in order. So a decision is the same on
 * every machine. */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/memory.h"
#include "math/fn.h"
#include "render/adaptive.h"
#include "render/internal/beams.h"

/* The rate at which a mean square error falls with the number of samples, as n^-RATE. It is between
 * 1, for independent samples, and 1.5, for a stratified set across an edge (Mitchell, SIGGRAPH 96).
 */
static const double RATE = 1.25;

/* In a normal distribution, PEN_ADAPTIVE_CONFIDENCE of the values are within this number of
 * standard deviations. */
static const double SPREAD = 2.576;

/* The error of an unseen edge, see unseen_edge. */
static const double UNSEEN = 0.3;

/* If samples are limited, a round aims at this part of the error. */
static const double STEP = 0.6;

/* A round takes at least this part of the samples taken so far. Each round costs a pass over the
 * picture, and without this limit the last rounds would refine a few pixels each. */
static const double LEAST_ROUND = 1.0 / 32;

/* The rate at which the error falls across an edge. Where a picture is smooth, it falls faster. */
static const double EDGE_RATE = 1.5;

/* The pixels of a slice, if that makes at most SLICES_MOST slices. Each slice has its own sums,
 * which cost some microseconds. */
enum { SLICE_PIXELS = 2048, SLICES_MOST = 64 };

/* Numbers of samples, by their binary logarithm. */
enum { SIZES = 32 };

/* Levels of priority: eighths of powers of two, from 0 on; below 2^LOWEST all are 0. */
enum { EIGHTHS = 8, LOWEST = -120, LEVELS = 128 * EIGHTHS };

/* The sums over the pixels of a slice; then, added up, over all pixels. */
struct slice {
    int first_row, end_row;
    double before[SIZES], after[SIZES];                 /* see true_part: sums of errors, */
    double before_squares[SIZES], after_squares[SIZES]; /* and of their squares */
    double error, squares;                              /* of the pixels' own estimates, */
    double told;                                        /* and the estimates of their halves; */
    double hidden; /* the most that unseen things add to that at the upper end of the interval, */
    uint64_t unproven; /* and the number of pixels that they may change by more than the target */
    double around;     /* errors as estimated from neighbours: of all pixels, */
    double at_level[LEVELS];  /* of those with that priority, */
    uint64_t samples[LEVELS]; /* the samples of their next round, */
    double capped_error;      /* and of pixels that may have no more samples */
    uint64_t capped;
};

/* The work of the threads with each slice. */
struct pass {
    struct pen_adaptive *adaptive;
    struct slice *slices;
    int slice_count;
    /* By number of samples: true_part, and the error of an unseen edge per unit of
     * square_difference. */
    double truth[SIZES];
    float unseen[SIZES];
    double target;
    double after_doublings[2 *
                           SIZES]; /* the part of an error that remains after i - SIZES doublings */
    void (*visit)(struct pen_adaptive *adaptive, const struct pass *pass, struct slice *slice);
    atomic_int next;
};

static void visit_slices(void *user, int thread)
{
    struct pass *pass = user;
    int i;
    (void)thread;
    while ((i = atomic_fetch_add_explicit(&pass->next, 1, memory_order_relaxed)) <
           pass->slice_count)
        pass->visit(pass->adaptive, pass, &pass->slices[i]);
}

static void run_pass(struct pen_thread_pool *pool, struct pass *pass)
{
    const int size = pen_thread_pool_size(pool);
    const int threads = size < pass->slice_count ? size : pass->slice_count;
    atomic_store(&pass->next, 0);
    pen_thread_pool_run(pool, threads, visit_slices, pass);
}

/* The number of slices of a picture. */
static int slices_in(const struct pen_settings *s)
{
    const double full = (double)s->width * s->height / SLICE_PIXELS;
    return full < 1 ? 1 : full < SLICES_MOST ? (int)full : SLICES_MOST;
}

/* The slices of a state, and one more for their sum; all empty. They take up to a megabyte, so they
 * are made once.
 * Fails: NULL; PEN_NO_MEMORY. */
static struct slice *slices_of(struct pen_adaptive *a, struct pen_status *st)
{
    const int count = slices_in(a->settings);
    const size_t bytes = (size_t)(count + 1) * sizeof(struct slice);
    if (!a->slices)
        a->slices = pen_memory_large(bytes);
    if (!a->slices) {
        pen_fail(st, PEN_NO_MEMORY, "out of memory for the decision after a round");
        return NULL;
    }
    struct slice *slices = memset(a->slices, 0, bytes);
    for (int i = 0; i < count; i++) {
        slices[i].first_row = (int)((int64_t)a->settings->height * i / count);
        slices[i].end_row = (int)((int64_t)a->settings->height * (i + 1) / count);
    }
    return slices;
}

static int size_of(uint32_t samples)
{
    return samples > 0 ? 31 - __builtin_clz(samples) : 0;
}

/* Whether a pixel may not have twice as many samples. */
static bool is_capped(const struct pen_adaptive *a, size_t pixel)
{
    return 2.0 * a->sums[pixel].samples > a->settings->max_samples;
}

/* Three times the mean square difference of the values. */
static float square_difference(const struct pen_pixel_estimate *a,
                               const struct pen_pixel_estimate *b)
{
    const float d[] = {a->value[0] - b->value[0], a->value[1] - b->value[1],
                       a->value[2] - b->value[2]};
    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

/* The mean square error of an edge that no sample has seen. n samples that are stratified along
 * both axes leave an unseen strip of the pixel that is at most about 2 / n wide. An edge that
 * separates this pixel from a neighbour is in the strip of one of the two. If its place in the
 * strips is uniform, the mean square of the width that it cuts off is between (1 / n)^2 / 6 and (2
 * / n)^2 / 6. */
static float unseen_edge(const struct pen_adaptive *a, const struct pass *pass, int x, int y)
{
    const int width = a->settings->width, height = a->settings->height;
    const struct pen_pixel_estimate *e = &a->estimates[(size_t)y * (size_t)width + (size_t)x];
    /* Beyond its borders the picture is continued by its outermost pixels. */
    const struct pen_pixel_estimate *const neighbour[] = {
        x > 0 ? e - 1 : e, x + 1 < width ? e + 1 : e, y > 0 ? e - width : e,
        y + 1 < height ? e + width : e};
    float most = 0;
    for (int i = 0; i < 4; i++) {
        const float square = square_difference(e, neighbour[i]);
        most = square > most ? square : most;
    }
    return most * pass->unseen[size_of(a->sums[e - a->estimates].samples)];
}

/* Counts the things that a pixel may not have seen. n samples miss a share v of a beam with a
 * probability of (1 - v)^n: 1 / n with 0.16 to 0.39, 4 / n with 0.01. Returns the increase of the
 * error if a share of 1 / n is unseen. Sets the increase for 4 / n. */
static double unseen_things(struct pen_adaptive *a, const struct pass *pass, struct slice *slice,
                            size_t at)
{
    const double error = (double)a->errors[at];
    double linear[3];
    pen_pixel_mean(&a->sums[at], linear);
    struct pen_beam_view view = {.samples = a->sums[at].samples,
                                 .times = 1,
                                 .looks = a->sums[at].looks == PEN_LOOKS,
                                 .agree = pen_pixel_agrees(a, at),
                                 .same = pen_pixel_same(a, at)};
    const double probable = pen_beam_unseen(a->beams, at, linear, &view);
    view.times = 4;
    const double possible = pen_beam_unseen(a->beams, at, linear, &view);
    const double most = probable > error ? probable : error;
    slice->hidden += possible > most ? possible - most : 0;
    slice->unproven += possible > pass->target * pass->target;
    a->things[at] = possible > error ? (float)(possible - error) : 0;
    return most - error;
}

/* Sums the effect of doublings. */
static void visit_doubled(struct pen_adaptive *a, const struct pass *pass, struct slice *slice)
{
    (void)pass;
    const size_t width = (size_t)a->settings->width;
    const size_t end = (size_t)slice->end_row * width;
    for (size_t at = (size_t)slice->first_row * width; at < end; at++) {
        const double before = (double)a->sums[at].before, after = (double)a->estimates[at].error;
        const int size = size_of(a->sums[at].samples);
        slice->before[size] += before;
        slice->after[size] += after;
        slice->before_squares[size] += before * before;
        slice->after_squares[size] += after * after;
    }
}

static void add_doubled(const struct slice *slices, int count, struct slice *all)
{
    for (int i = 0; i < count; i++)
        for (int size = 0; size < SIZES; size++) {
            all->before[size] += slices[i].before[size];
            all->after[size] += slices[i].after[size];
            all->before_squares[size] += slices[i].before_squares[size];
            all->after_squares[size] += slices[i].after_squares[size];
        }
}

/* The largest part of the halves' estimate that is error, for pixels with 2n samples. Let q(n) be
 * the mean square error of n samples. The estimate is q(n) - q(2n) (adaptive.h); with n samples it
 * was q(n / 2) - q(n). If q falls by the factor R with each doubling, R is the ratio of the two,
 * and the error is 1 / (R - 1) of the estimate.
 *
 * The sums over many pixels give R with an interval; the lower end is used. But pixels differ: R is
 * 2 where samples are like independent ones, 2^1.5 across most edges, 4 across edges along the
 * pixel's sides. 1 / (R - 1) is convex. So its mean over such a mixture is at most the value of its
 * chord from 1 at R = 2 to 1/3 at R = 4, at the mean of R. So the chord is used, up to 2^1.5. Below
 * R = 2 the value is 1, because samples are not worse than independent ones. Pixels of the pilot
 * have no earlier estimate. R of the other pixels may not be theirs, because these were chosen for
 * refinement. */
static double true_part(const struct slice *all, int size)
{
    const double before = all->before[size], after = all->after[size];
    if (!(before > 0) || !(after > 0))
        return 1;
    const double off = SPREAD * sqrt(all->before_squares[size] / (before * before) +
                                     all->after_squares[size] / (after * after));
    const double ratio = before / after * (1 - off), most = pen_pow(2, EDGE_RATE);
    return ratio < 2 ? 1 : 1 - ((ratio < most ? ratio : most) - 2) / 3;
}

/* Sets the estimates of each pixel that use only its own samples. */
static void visit_own(struct pen_adaptive *a, const struct pass *pass, struct slice *slice)
{
    size_t at = (size_t)slice->first_row * (size_t)a->settings->width;
    for (int y = slice->first_row; y < slice->end_row; y++)
        for (int x = 0; x < a->settings->width; x++, at++) {
            a->unseen[at] = unseen_edge(a, pass, x, y);
            const double told = (double)a->estimates[at].error;
            const float own = (float)(told * pass->truth[size_of(a->sums[at].samples)]);
            a->errors[at] = own > a->unseen[at] ? own : a->unseen[at];
            const double things = a->beams ? unseen_things(a, pass, slice, at) : 0;
            const double error = (double)a->errors[at] + things;
            slice->error += error;
            slice->squares += error * error;
            slice->told += told;
        }
}

/* The error that a pixel would have if it had `wanted` samples. */
static double error_with(const struct pass *pass, double error, uint32_t samples, uint32_t wanted)
{
    return samples == wanted
               ? error
               : error * pass->after_doublings[SIZES + size_of(wanted) - size_of(samples)];
}

/* The error of a pixel as estimated from its neighbours. It is the mean of their errors, scaled to
 * the same number of samples, and the error of an edge that it may have. Its own unseen things are
 * added, because neighbours do not show them. */
static double error_around(const struct pen_adaptive *a, const struct pass *pass, int x, int y)
{
    const int width = a->settings->width, height = a->settings->height;
    const size_t at = (size_t)y * (size_t)width + (size_t)x;
    double sum = (double)a->unseen[at], count = 1;
    for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < height; v++)
        for (int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < width; u++) {
            const size_t other = (size_t)v * (size_t)width + (size_t)u;
            if (other == at)
                continue;
            count++;
            if (a->errors[other] > 0)
                sum += error_with(pass, (double)a->errors[other], a->sums[other].samples,
                                  a->sums[at].samples);
        }
    return sum / count + (double)a->things[at];
}

/* The level of a priority: the number's binary exponent and the first three bits after it. */
static int level_of(double priority)
{
    enum { MANTISSA_BITS = 52, EIGHTH_BITS = 3, BIAS = 1022 };
    uint64_t bits;
    memcpy(&bits, &priority, sizeof bits);
    const int level = (int)(bits >> (MANTISSA_BITS - EIGHTH_BITS)) - (BIAS + LOWEST) * EIGHTHS;
    if (!(priority > 0) || level < 1)
        return 0;
    return level < LEVELS ? level : LEVELS - 1;
}

/* The priority of a pixel: its neighbourhood's error per sample. */
static int priority_of(const struct pen_adaptive *a, size_t at, double around)
{
    return level_of(around / a->sums[at].samples);
}

/* Sums the errors by the priority of their pixels. */
static void visit_around(struct pen_adaptive *a, const struct pass *pass, struct slice *slice)
{
    size_t at = (size_t)slice->first_row * (size_t)a->settings->width;
    for (int y = slice->first_row; y < slice->end_row; y++)
        for (int x = 0; x < a->settings->width; x++, at++) {
            const double around = error_around(a, pass, x, y);
            slice->around += around;
            if (is_capped(a, at)) {
                a->priority[at] = 0;
                slice->capped_error += around;
                slice->capped += around > 0;
            } else {
                const int priority = priority_of(a, at, around);
                a->priority[at] = (uint16_t)(1 + priority);
                slice->at_level[priority] += around;
                slice->samples[priority] += a->sums[at].samples;
            }
        }
}

/* Sums the slices, in order. */
static void add_slices(const struct slice *slices, int count, struct slice *all)
{
    for (int i = 0; i < count; i++) {
        const struct slice *s = &slices[i];
        all->error += s->error;
        all->told += s->told;
        all->hidden += s->hidden;
        all->unproven += s->unproven;
        all->squares += s->squares;
        all->around += s->around;
        all->capped_error += s->capped_error;
        all->capped += s->capped;
        for (int level = 0; level < LEVELS; level++) {
            all->at_level[level] += s->at_level[level];
            all->samples[level] += s->samples[level];
        }
    }
}

/* The sum of the errors, given by level, after every pixel has been doubled until it is below
 * `level`. A doubling lowers the error by 2^RATE and the priority by twice that. */
static double predicted(const double *errors, int level)
{
    double sum = 0;
    for (int i = 0; i < LEVELS; i++) {
        if (errors[i] == 0)
            continue;
        const int over = i - level + 1;
        const double doublings = over > 0 ? ceil(over / (EIGHTHS * (1 + RATE))) : 0;
        sum += errors[i] * pen_pow(2, -RATE * doublings);
    }
    return sum;
}

/* The lowest level such that the goal is reached if all pixels at it or above are refined; found by
 * bisection. */
static int level_for(const struct slice *all, double goal)
{
    int level = LEVELS;
    for (int step = LEVELS / 2; step > 0; step /= 2)
        if (predicted(all->at_level, level - step + 1) > goal)
            level -= step;
    return level;
}

/* The level at which a round takes its least number of samples, or the given level if that is
 * lower. Level 0 contains pixels whose error is zero, which are not refined. */
static int level_of_least(const struct slice *all, int level)
{
    uint64_t sum = 0, total = 0;
    for (int i = 0; i < LEVELS; i++)
        total += all->samples[i];
    for (int i = LEVELS - 1; i >= 1; i--) {
        sum += all->samples[i];
        if ((double)sum >= LEAST_ROUND * (double)total)
            return i < level ? i : level;
    }
    return level < 1 ? level : 1;
}

/* The lowest level, from `level` on, such that doubling all pixels at it or above takes at most the
 * allowed samples. */
static int level_within(const struct slice *all, int level, uint64_t samples)
{
    uint64_t sum = 0;
    int lowest = LEVELS;
    while (lowest > level && all->samples[lowest - 1] <= samples - sum)
        sum += all->samples[--lowest];
    return lowest;
}

static struct pen_decision decision_of(const struct slice *all, double pixels,
                                       const struct pen_goal *goal)
{
    const double mean = all->error / pixels, off = SPREAD * sqrt(all->squares) / pixels;
    const double least = all->told / (pen_pow(2, EDGE_RATE) - 1) / pixels - off;
    const double high = mean + off + all->hidden / pixels, low = least > 0 ? least : 0;
    struct pen_decision d = {.error = sqrt(mean),
                             .low = sqrt(low),
                             .high = sqrt(high),
                             .met = high <= goal->target * goal->target};
    double aim = goal->target * goal->target;
    if (goal->samples != UINT64_MAX && aim < high * STEP * STEP)
        aim = high * STEP * STEP;
    /* The sum of errors at which the upper end of the interval would be the target. Up to chance,
     * the neighbours' estimates have the same sum as the pixels' own, plus the light that may be
     * hidden. */
    const double sum = high > 0 ? aim / high * all->around - all->capped_error : 0;
    bool any = false;
    d.level = level_within(all, level_of_least(all, level_for(all, sum)), goal->samples);
    for (int i = d.level; i < LEVELS; i++)
        any |= all->at_level[i] > 0;
    d.done = d.met || !any;
    d.capped = d.met ? 0 : all->capped;
    d.unproven = d.met ? 0 : (double)all->unproven / pixels;
    return d;
}

bool pen_adaptive_decide(struct pen_adaptive *a, struct pen_thread_pool *pool,
                         const struct pen_goal *goal, struct pen_decision *decision,
                         struct pen_status *st)
{
    struct pass pass = {.adaptive = a,
                        .slices = slices_of(a, st),
                        .slice_count = slices_in(a->settings),
                        .target = goal->target};
    if (!pass.slices)
        return false;
    struct slice *all = &pass.slices[pass.slice_count];
    for (int i = 0; i < 2 * SIZES; i++)
        pass.after_doublings[i] = pen_pow(2, RATE * (SIZES - i));
    for (int i = 0; i < SIZES; i++) {
        pass.truth[i] = 1;
        pass.unseen[i] = (float)(UNSEEN / 3 * pen_pow(4, -i));
    }
    if (a->refined) {
        pass.visit = visit_doubled;
        run_pass(pool, &pass);
        add_doubled(pass.slices, pass.slice_count, all);
        for (int i = 0; i < SIZES; i++)
            pass.truth[i] = true_part(all, i);
    }
    pass.visit = visit_own;
    run_pass(pool, &pass);
    pass.visit = visit_around;
    run_pass(pool, &pass);
    add_slices(pass.slices, pass.slice_count, all);
    *decision = decision_of(all, (double)a->settings->width * a->settings->height, goal);
    return true;
}

uint64_t pen_adaptive_select(struct pen_adaptive *a, int level)
{
    const size_t pixels = (size_t)a->settings->width * (size_t)a->settings->height;
    uint64_t selected = 0;
    a->refined = true;
    for (size_t at = 0; at < pixels; at++) {
        a->wanted[at] = a->priority[at] > level;
        selected += a->wanted[at];
    }
    return selected;
}

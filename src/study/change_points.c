/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "study/history.h"
#include "study/internal/random_order.h"
#include "study/verdict.h"

enum { ORDERS = 999, POINTS_MIN = 8 };

static const double most_likely = 0.05;

/* The median of a range; `sorted` is scratch space. */
static double median_of(const double *values, int count, double *sorted)
{
    memcpy(sorted, values, (size_t)count * sizeof *values);
    return pen_median(sorted, count);
}

/* The ranks of the values, from 1. Equal values share the mean of their ranks. */
static void rank_values(const double *values, int count, double *ranks)
{
    for (int i = 0; i < count; i++) {
        int less = 0, equal = 0;
        for (int j = 0; j < count; j++) {
            less += values[j] < values[i];
            equal += values[j] == values[i];
        }
        ranks[i] = less + (equal + 1) / 2.0;
    }
}

/* Pettitt's K: the largest |U| over all splits. U counts the pairs across a split in which the
 * first value is larger, minus those in which the second is larger. From ranks, U = 2 (sum of the
 * first t ranks) - t (count + 1). */
static double pettitt(const double *ranks, int count)
{
    double sum = 0, most = 0;
    for (int t = 1; t < count; t++) {
        sum += ranks[t - 1];
        most = fmax(most, fabs(2 * sum - (double)t * (count + 1)));
    }
    return most;
}

static void shuffle(double *ranks, int count, uint64_t *random)
{
    for (int i = count - 1; i > 0; i--) {
        const int j = (int)(pen_random_next(random) % (uint64_t)(i + 1));
        const double moved = ranks[i];
        ranks[i] = ranks[j];
        ranks[j] = moved;
    }
}

/* Whether the values change by more than chance explains. `ranks` is scratch space. */
static bool is_change(const double *values, int count, double *ranks)
{
    uint64_t random = 1;
    int as_much = 1;
    if (count < POINTS_MIN)
        return false;
    rank_values(values, count, ranks);
    const double found = pettitt(ranks, count);
    for (int i = 0; i < ORDERS; i++) {
        shuffle(ranks, count, &random);
        as_much += pettitt(ranks, count) >= found;
    }
    return (double)as_much / (ORDERS + 1) <= most_likely;
}

/* The sum of the distances of some values from their median. */
static double spread_of(const double *values, int count, double *sorted)
{
    const double median = median_of(values, count, sorted);
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += fabs(values[i] - median);
    return sum;
}

/* The split at which the values of both parts lie closest to their medians. If the change is near
 * an end, the split with the largest |U| lies too near the middle. */
static int find_split(const double *values, int count, double *sorted)
{
    int split = 0;
    double least = HUGE_VAL;
    for (int t = 1; t < count; t++) {
        const double here = spread_of(values, t, sorted) + spread_of(values + t, count - t, sorted);
        if (here < least) {
            least = here;
            split = t;
        }
    }
    return split;
}

struct search {
    const double *values;
    double least_effect;
    double *scratch;
    int *at;
    int found;
};

/* Searches values first … end - 1, and then both sides of the change point. Finds change points in
 * rising order. */
static void search(struct search *s, int first, int end)
{
    const double *values = s->values + first;
    if (!is_change(values, end - first, s->scratch))
        return;
    const int split = find_split(values, end - first, s->scratch);
    const double before = median_of(values, split, s->scratch);
    const double after = median_of(values + split, end - first - split, s->scratch);
    if (!(before > 0) || !(fmax(after / before, before / after) >= 1 + s->least_effect))
        return;
    search(s, first, first + split);
    s->at[s->found++] = first + split;
    search(s, first + split, end);
}

int pen_history_changes(const double *values, int count, double least_effect, int *at)
{
    struct search s = {.values = values,
                       .least_effect = least_effect,
                       .scratch = calloc((size_t)count + 1, sizeof *s.scratch),
                       .at = at};
    if (!s.scratch)
        return -1;
    search(&s, 0, count);
    free(s.scratch);
    return s.found;
}

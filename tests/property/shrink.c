/* SPDX-License-Identifier: MIT */
#include "property/shrink.h"

#include <math.h>
#include <string.h>

enum { TRIES = 600 };

struct shrinker {
    struct row_case *best;
    row_judge_fn *judge;
    char *why;
    int tries;
};

/* The bits between a number's first and last set bit. */
static int mantissa_bits(double x)
{
    int e, n = 53;
    double m = ldexp(fabs(frexp(x, &e)), 53);
    if (x == 0 || !isfinite(x))
        return 0;
    for (; fmod(m, 2) == 0; n--)
        m /= 2;
    return n;
}

static double keep_bits(double x, int bits)
{
    int e;
    double m = frexp(x, &e);
    return ldexp(nearbyint(ldexp(m, bits)), e - bits);
}

/* Whether the case still fails with argument `i` replaced; then it is. */
static bool try_value(struct shrinker *s, int i, double x)
{
    double old = s->best->arg[i];
    if ((x == old && signbit(x) == signbit(old)) || !isfinite(x) || s->tries >= TRIES)
        return false;
    struct row_verdict v = {.failed = false};
    s->best->arg[i] = x;
    s->tries++;
    s->judge(s->best, &v);
    if (v.failed && !v.skipped) {
        memcpy(s->why, v.why, ROW_WHY);
        return true;
    }
    s->best->arg[i] = old;
    return false;
}

static bool simplify(struct shrinker *s, int i)
{
    double x = s->best->arg[i];
    int bits = mantissa_bits(x);
    if (bits == 0)
        return false;
    if (try_value(s, i, 0) || (bits > 1 && try_value(s, i, nearbyint(x))))
        return true;
    for (int keep = 1; keep < bits; keep *= 2)
        if (try_value(s, i, keep_bits(x, keep)))
            return true;
    return bits > 1 && try_value(s, i, keep_bits(x, bits - 1));
}

void shrink_case(struct row_case *c, row_judge_fn *judge, char *why)
{
    struct shrinker s = {c, judge, why, 0};
    bool better = true;
    while (better && s.tries < TRIES) {
        better = false;
        for (int i = c->fixed; i < c->count; i++)
            better |= simplify(&s, i);
    }
}

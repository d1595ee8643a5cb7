/* SPDX-License-Identifier: MIT */
/* Round primitives in 400 bits, by the textbook: the roots of a t^2 + 2 b t + c. It is slow, and
 * checks oracle_quad.c, which uses another formula. */
#include "property/oracle.h"

#ifdef HAVE_MPFR
#include <mpfr.h>

enum { BITS = 400, REGISTERS = 16 };

struct registers {
    mpfr_t r[REGISTERS];
};

/* r[to .. to+2] = p - q */
static void load(struct registers *m, int to, struct pen_vec3 p, struct pen_vec3 q)
{
    for (int i = 0; i < 3; i++) {
        mpfr_set_d(m->r[to + i], pen_component(p, i), MPFR_RNDN);
        mpfr_sub_d(m->r[to + i], m->r[to + i], pen_component(q, i), MPFR_RNDN);
    }
}

/* r[to] = r[a..].r[b..]; uses r[15]. */
static void dot(struct registers *m, int to, int a, int b)
{
    mpfr_mul(m->r[to], m->r[a], m->r[b], MPFR_RNDN);
    for (int i = 1; i < 3; i++) {
        mpfr_mul(m->r[15], m->r[a + i], m->r[b + i], MPFR_RNDN);
        mpfr_add(m->r[to], m->r[to], m->r[15], MPFR_RNDN);
    }
}

/* r[v..] = r[v..] x r[a..]; uses r[9] to r[12] and r[15]. */
static void cross_with(struct registers *m, int v, int a)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        mpfr_mul(m->r[9 + i], m->r[v + j], m->r[a + k], MPFR_RNDN);
        mpfr_mul(m->r[15], m->r[v + k], m->r[a + j], MPFR_RNDN);
        mpfr_sub(m->r[9 + i], m->r[9 + i], m->r[15], MPFR_RNDN);
    }
    for (int i = 0; i < 3; i++)
        mpfr_set(m->r[v + i], m->r[9 + i], MPFR_RNDN);
}

static struct truth split(struct registers *m, int from)
{
    struct truth t = {mpfr_get_d(m->r[from], MPFR_RNDN), 0};
    mpfr_sub_d(m->r[15], m->r[from], t.hi, MPFR_RNDN);
    t.lo = mpfr_get_d(m->r[15], MPFR_RNDN);
    return t;
}

/* f in r[0..], d in r[3..], (r |a|)^2 in r[8]: the two roots. */
static void solve(struct registers *m, struct oracle_roots *out)
{
    dot(m, 9, 3, 3);
    dot(m, 10, 0, 3);
    dot(m, 11, 0, 0);
    mpfr_sub(m->r[11], m->r[11], m->r[8], MPFR_RNDN);
    mpfr_mul(m->r[12], m->r[10], m->r[10], MPFR_RNDN);
    mpfr_mul(m->r[13], m->r[9], m->r[11], MPFR_RNDN);
    mpfr_sub(m->r[12], m->r[12], m->r[13], MPFR_RNDN);
    out->count = mpfr_sgn(m->r[12]) > 0 && mpfr_sgn(m->r[9]) > 0 ? 2 : 0;
    if (out->count == 0)
        return;
    mpfr_sqrt(m->r[12], m->r[12], MPFR_RNDN);
    for (int i = 0; i < 2; i++) {
        mpfr_neg(m->r[13], m->r[10], MPFR_RNDN);
        (i ? mpfr_add : mpfr_sub)(m->r[13], m->r[13], m->r[12], MPFR_RNDN);
        mpfr_div(m->r[13], m->r[13], m->r[9], MPFR_RNDN);
        out->t[i] = split(m, 13);
        out->part[i] = ORACLE_SIDE;
    }
}

bool oracle_mpfr_roots(const struct oracle_round *b, struct oracle_ray ray,
                       struct oracle_roots *out)
{
    struct registers m;
    const struct pen_vec3 zero = {0, 0, 0};
    bool infinite_cylinder = b->a.x != 0 || b->a.y != 0 || b->a.z != 0;
    for (int i = 0; i < REGISTERS; i++)
        mpfr_init2(m.r[i], BITS);
    load(&m, 0, ray.o, b->c);
    load(&m, 3, ray.d, zero);
    mpfr_set_d(m.r[8], b->r, MPFR_RNDN);
    mpfr_mul(m.r[8], m.r[8], m.r[8], MPFR_RNDN);
    if (infinite_cylinder) {
        mpfr_set(m.r[14], m.r[8], MPFR_RNDN);
        load(&m, 6, b->a, zero); /* r[6..8] */
        cross_with(&m, 0, 6);
        cross_with(&m, 3, 6);
        dot(&m, 13, 6, 6);
        mpfr_mul(m.r[8], m.r[14], m.r[13], MPFR_RNDN);
    }
    solve(&m, out);
    for (int i = 0; i < REGISTERS; i++)
        mpfr_clear(m.r[i]);
    return true;
}
#else
bool oracle_mpfr_roots(const struct oracle_round *b, struct oracle_ray ray,
                       struct oracle_roots *out)
{
    (void)b, (void)ray, (void)out;
    return false;
}
#endif

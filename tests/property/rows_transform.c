/* SPDX-License-Identifier: MIT */
/* Maps that flatten space, or nearly: whether they can be inverted, whether they mirror, and where
 * they put the normal of a plane. */
#include "math/transform.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"

/* The third row is a sum of the others, often moved by ulps; a column and a row may be of any size.
 * Arguments: three rows, a normal. */
static void draw_map(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 row[3];
    for (int i = 0; i < 2; i++)
        row[i] = random_below(r, 2) ? gen_dyadic3(r, 4) : random_vec(r, 1);
    row[2] = pen_along(pen_scale(row[0], gen_dyadic(r, 2)), row[1], gen_dyadic(r, 2));
    if (random_below(r, 2))
        row[2] = gen_nudged(r, row[2]);
    vec3 by = {ldexp(1, (int)random_below(r, 41) - 20), 1, ldexp(1, (int)random_below(r, 41) - 20)};
    for (int i = 0; i < 3; i++)
        row_arg3(c, pen_mul(row[((uint64_t)i + d->index) % 3], by));
    row_arg3(c, random_below(r, 2) ? random_direction(r) : gen_axial(r));
}

static void judge_map(const struct row_case *c, struct row_verdict *v)
{
    struct pen_transform f = pen_transform_identity();
    vec3 row[3], exact;
    int at = 0;
    for (int i = 0; i < 3; i++) {
        row[i] = row_next3(c, &at);
        for (int j = 0; j < 3; j++) {
            double x = f.m[i][j] = pen_component(row[i], j);
            if (x != 0 && !(fabs(x) > 0x1p-100 && fabs(x) < 0x1p100)) {
                row_skip(v);
                return;
            }
        }
    }
    vec3 n = row_next3(c, &at);
    int sign = oracle_side((struct oracle_ray){{0, 0, 0}, row[0]}, row[1], row[2]);
    row_tally(v, sign == 0 ? "flattens" : "can be inverted");
    row_require(v, pen_transform_invertible(&f) == (sign != 0),
                sign ? "can be inverted, but is refused" : "flattens, but is accepted");
    row_require(v, pen_transform_orientation(&f) == sign, "mirrors, or does not");
    if (sign == 0 || !(pen_norm1(n) > 0x1p-40 && pen_norm1(n) < 0x1p40) ||
        !oracle_moved_normal(row, n, &exact))
        return;
    vec3 got = pen_transform_normal(&f, n);
    got = pen_scale(got, 1 / pen_length(got));
    row_measure(v, "normal [u]", pen_norm1(pen_sub(got, pen_scale(exact, sign))) / 0x1p-53, 16);
}

void rows_map(struct pen_row_run *run)
{
    row_each(run, draw_map, judge_map);
}

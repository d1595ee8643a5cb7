/* SPDX-License-Identifier: MIT */
/* The rows, in the order of the catalogue. */
#include "property/rows.h"

static const struct row bumpy = {
    .id = "H038 H039",
    .name = "h038_watertight",
    .what = "a closed surface of 420 triangles is crossed an odd number of times from inside, at "
            "offsets 0, 1e6 and 1e9",
    .oracle = "parity",
    .run = rows_bumpy,
    .full = 4000000,
};

static const struct row sheet = {
    .id = "H050 H057",
    .name = "h050_folded_sheet",
    .what = "a folded sheet of triangles and concave polygons is crossed exactly once, at offsets "
            "0, 1e6 and 1e9",
    .oracle = "count = 1",
    .run = rows_sheet,
    .full = 4000000,
};

static const char roots_oracle[] = "113-bit roots; class by growing and shrinking the body";

static const struct row oracle = {
    .id = "O1",
    .name = "o1_oracle",
    .what = "the oracle's roots in 113 bits agree with roots in 400 bits to 2^-6 ulp",
    .oracle = "MPFR, textbook formula (skipped where MPFR was not there at build time)",
    .run = rows_oracle,
    .full = 10000,
    .check = 1000,
};

static const struct row sphere_roots = {
    .id = "O1 sphere",
    .name = "o1_sphere",
    .what = "passing within 0.9 r: t within 5 ulp from 2 r on, else within 8u (|f| + r); no wrong "
            "hit or miss outside BE(8)",
    .oracle = roots_oracle,
    .run = rows_sphere_roots,
};

static const struct row sphere_grazing = {
    .id = "O1 sphere",
    .name = "o1_sphere_grazing",
    .what = "the same where the ray passes beyond 0.9 r, to tangents within 1e-16",
    .oracle = roots_oracle,
    .run = rows_sphere_grazing,
    .known = "t of grazing rays: the square root of a discriminant that keeps few digits",
};

static const struct row tube_roots = {
    .id = "O1 tube",
    .name = "o1_tube",
    .what = "axis near the origin, passing within 0.9 r, at any angle to the axis: t within 16 ulp "
            "from 2 r on, else "
            "within 8u (|f| + r); no wrong hit or miss outside BE(8)",
    .oracle = roots_oracle,
    .run = rows_tube_roots,
};

static const struct row tube_grazing = {
    .id = "O1 tube",
    .name = "o1_tube_grazing",
    .what = "the same where the ray passes beyond 0.9 r",
    .oracle = roots_oracle,
    .run = rows_tube_grazing,
    .known = "t of grazing rays: the square root of a discriminant that keeps few digits",
};

static const struct row tube_far = {
    .id = "O1 tube",
    .name = "o1_tube_far",
    .what = "the same for thin tubes about 1 from the origin, and others up to 1e9 from it",
    .oracle = roots_oracle,
    .run = rows_tube_far,
    .known = "the point of the axis near the origin is rounded to double when a tube is made",
};

static const struct row cylinder_caps = {
    .id = "O1 cylinder",
    .name = "o1_cylinder_caps",
    .what = "crossings of the caps: t within 16 ulp from 2 r on, else within 8u (|f| + r)",
    .oracle = roots_oracle,
    .run = rows_cylinder_caps,
    .known = "t of a cap loses digits where the ray starts near its plane or runs along it",
};

static const struct row cylinder_roots = {
    .id = "O1 cylinder",
    .name = "o1_cylinder",
    .what = "capped cylinders, aimed at sides, caps and rims: hit or miss, and t of the side, as "
            "for tubes",
    .oracle = roots_oracle,
    .run = rows_cylinder_roots,
};

static const struct row cylinder_grazing = {
    .id = "O1 cylinder",
    .name = "o1_cylinder_grazing",
    .what = "the same where the ray passes the axis beyond 0.9 r",
    .oracle = roots_oracle,
    .run = rows_cylinder_grazing,
    .known = "t of grazing rays: the square root of a discriminant that keeps few digits",
};

const struct row *const row_table[] = {
    &bumpy,        &sheet,    &oracle,         &sphere_roots,  &sphere_grazing,   &tube_roots,
    &tube_grazing, &tube_far, &cylinder_roots, &cylinder_caps, &cylinder_grazing,
};
const int row_table_count = sizeof row_table / sizeof row_table[0];

/* SPDX-License-Identifier: MIT */
/* Spheres. */
#include "pen/geom/prims.h"
#include "support/suite.h"

START_TEST(test_sphere__h015_tmax)
{
    struct pen_sphere s;
    struct pen_ray ray;
    double t[2];
    ck_assert(pen_sphere_make(&s, pen_vec3(0, 0, 0), 1));
    ck_assert(pen_ray_make(&ray, pen_vec3(-2, 0, 0), pen_vec3(1, 0, 0)));
    ck_assert(pen_sphere_roots(&s, &ray, t));
    ck_assert(t[0] == 1 && t[1] == 3);
}
END_TEST

PEN_SUITE("sphere", test_sphere__h015_tmax)

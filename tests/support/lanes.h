/* SPDX-License-Identifier: MIT */
/* Code in lanes (math/lanes.h) as functions of arrays, compiled for each instruction set, so that
 * tests compare one lane with many. */
#ifndef TESTS_SUPPORT_LANES_H
#define TESTS_SUPPORT_LANES_H

#include "base/cpu.h"
#include "geom/ray.h"
#include "math/sample.h"
#include "scene/scene.h"

enum { LANES_TEST_MAX = 8, LANES_TEST_FUNCTIONS = 7 };

/* A point of a surface, as in struct surface of shade. */
struct lanes_point {
    struct pen_vec3 kd, ks, p, n, v;
    double shininess, nv, grazing_sine, bound;
    bool lit;
};

/* Light that arrives at it; `term` is valid only if it arrives. */
struct lanes_arriving {
    bool arrives;
    struct pen_vec3 term, to_light;
};

/* Hit points, and the results of lanes_prim_surface. */
struct lanes_hits {
    struct pen_vec3 p[LANES_TEST_MAX], n[LANES_TEST_MAX];
    double scale[LANES_TEST_MAX], curvature[LANES_TEST_MAX];
};

/* Arrays are by lane. */
struct lanes_test {
    int lanes;
    /* exp(x), ln(x), pow(x, y), sine and cosine of x in radians, and of x in degrees. */
    void (*functions)(const double *x, const double *y,
                      double out[LANES_TEST_FUNCTIONS][LANES_TEST_MAX]);
    /* pen_random2, pen_sobol2 and, of the points of the first, pen_disk_of_square, for as many
     * indices in a row as there are lanes. */
    /* pen_sobol2 of an index with pen_sample_hash of a key, each in its lane; keys with one seed
     * and purpose, and light 0. */
    void (*sequences)(const struct pen_sample_key *key, const uint32_t *index,
                      struct pen_point2 *sobol);
    void (*samples)(uint64_t hash, uint32_t index, struct pen_point2 random[LANES_TEST_MAX],
                    struct pen_point2 sobol[LANES_TEST_MAX],
                    struct pen_point2 disk[LANES_TEST_MAX]);
    /* lanes_ray_make, with a bit for each lane that has a ray. */
    unsigned (*rays)(const struct pen_vec3 *o, const struct pen_vec3 *d, struct pen_ray *out);
    /* lanes_ray_array_make of the rays from `first` on. */
    unsigned (*ray_array)(const struct pen_vec3 *o, const struct pen_vec3 *d, int first,
                          struct pen_ray_array *out);
    /* lanes_prim_surface. */
    bool (*surface)(const struct pen_prims *prims, struct pen_hit hit, struct lanes_hits *hits);
    /* lanes_origin_at, of rays that meet surfaces of these scales at t, in p. */
    void (*origins)(const struct pen_ray *ray, const double *t,
                    const struct pen_origin_surface *left, const struct pen_vec3 *p,
                    const double *scale, struct pen_origin_surface *out);
    /* light_unshadowed, with and without specular light. */
    void (*light)(const struct pen_light *light, const struct lanes_point *point, bool specular,
                  struct lanes_arriving *out);
};

/* NULL if this processor does not have the instruction set. */
const struct lanes_test *lanes_test_of(enum pen_isa isa);

#endif

/* SPDX-License-Identifier: MIT */
/* Compiled once for each instruction set, PEN_ISA (base/cpu.h). */
#include <string.h>

#include "support/lanes.h"

#include "geom/ray_lanes.h"
#include "geom/surface_lanes.h"
#include "math/lanes_fn.h"
#include "math/sample_lanes.h"
#include "shade/internal/unshadowed_light.h"

_Static_assert((int)LANES <= (int)LANES_TEST_MAX, "arrays are as long as the widest vector");

static void functions(const double *x, const double *y,
                      double out[LANES_TEST_FUNCTIONS][LANES_TEST_MAX])
{
    const lanes a = lanes_load(x);
    lanes sine, cosine;
    lanes_store(out[0], lanes_exp(a));
    lanes_store(out[1], lanes_ln(a));
    lanes_store(out[2], lanes_pow(a, lanes_load(y)));
    lanes_sincos(a, &sine, &cosine);
    lanes_store(out[3], sine);
    lanes_store(out[4], cosine);
    lanes_sincos_deg(a, &sine, &cosine);
    lanes_store(out[5], sine);
    lanes_store(out[6], cosine);
}

static void store_points(struct pen_point2 *to, struct lanes_point2 from)
{
    lanes_store_strided(&to[0].x, 2, from.x);
    lanes_store_strided(&to[0].y, 2, from.y);
}

static void samples(uint64_t hash, uint32_t index, struct pen_point2 random[LANES_TEST_MAX],
                    struct pen_point2 sobol[LANES_TEST_MAX], struct pen_point2 disk[LANES_TEST_MAX])
{
    store_points(random, lanes_random2(hash, index));
    store_points(sobol, lanes_sobol2(hash, index));
    store_points(disk, lanes_disk_of_square(lanes_random2(hash, index)));
}

static void sequences(const struct pen_sample_key *key, const uint32_t *index,
                      struct pen_point2 *sobol)
{
    uint64_t pixel[LANES], sequence[LANES];
    lane_words pixels, numbers;
    lane_halves indices;
    for (int i = 0; i < LANES; i++) {
        pixel[i] = (uint64_t)key[i].y << 32 | key[i].x;
        sequence[i] = (uint64_t)key[i].node << 32 | key[i].pixel_sample;
    }
    memcpy(&pixels, pixel, sizeof pixels);
    memcpy(&numbers, sequence, sizeof numbers);
    memcpy(&indices, index, sizeof indices);
    const lane_words hash =
        lanes_sample_purpose(lanes_sample_hash(key[0].seed, pixels, numbers), key[0].purpose);
    store_points(sobol, lanes_sobol2_each(hash, indices));
}

static unsigned rays(const struct pen_vec3 *o, const struct pen_vec3 *d, struct pen_ray *out)
{
    struct pen_ray *ray[LANES];
    for (int i = 0; i < LANES; i++)
        ray[i] = &out[i];
    return lane_mask_bits(lanes_ray_make(ray, lanes3_load(o), lanes3_load(d)));
}

static unsigned ray_array(const struct pen_vec3 *o, const struct pen_vec3 *d, int first,
                          struct pen_ray_array *out)
{
    return lane_mask_bits(lanes_ray_array_make(out, first, lanes3_load(o), lanes3_load(d)));
}

static bool surface(const struct pen_prims *prims, struct pen_hit hit, struct lanes_hits *hits)
{
    struct lanes_prim_point at = {.p = lanes3_load(hits->p)};
    if (!lanes_prim_surface(prims, hit.prim, hit.part, LANES_ALL, &at))
        return false;
    lanes3_store(hits->p, at.p);
    lanes3_store(hits->n, at.n);
    lanes_store(hits->scale, at.scale);
    lanes_store(hits->curvature, at.curvature);
    return true;
}

static lanes member(const double *first, size_t stride)
{
    return lanes_strided(first, stride / sizeof(double));
}

static struct lanes3 vector(const struct pen_vec3 *first, size_t stride)
{
    return (struct lanes3){member(&first->x, stride), member(&first->y, stride),
                           member(&first->z, stride)};
}

static void origins(const struct pen_ray *ray, const double *t,
                    const struct pen_origin_surface *left, const struct pen_vec3 *p,
                    const double *scale, struct pen_origin_surface *out)
{
    const struct lanes_arrived arrived = {
        .o = vector(&ray->o, sizeof *ray),
        .t = lanes_load(t),
        .inv_dd = member(&ray->inv_dd, sizeof *ray),
        .left = {vector(&left->toward, sizeof *left), vector(&left->before, sizeof *left),
                 member(&left->bound, sizeof *left), member(&left->toward_bound, sizeof *left),
                 member(&left->before_bound, sizeof *left)}};
    const struct lanes_origin origin = lanes_origin_at(&arrived, lanes3_load(p), lanes_load(scale));
    struct surface s;
    for (int i = 0; i < LANES; i++)
        s.hit[i] = (struct pen_hit){t[i], 0, PEN_PART_SIDE};
    surface_set_origins(&s, &origin);
    for (int i = 0; i < LANES; i++)
        out[i] = s.origin[i];
}

static struct surface surface_of(const struct lanes_point *point)
{
    const double *const first = (const double *)point;
    const size_t stride = sizeof *point / sizeof(double);
    struct surface s = {.finite = lane_mask_of(LANES_ALL)};
#define VECTOR(name)                                                                               \
    s.name.x =                                                                                     \
        lanes_strided(first + offsetof(struct lanes_point, name.x) / sizeof(double), stride);      \
    s.name.y =                                                                                     \
        lanes_strided(first + offsetof(struct lanes_point, name.y) / sizeof(double), stride);      \
    s.name.z = lanes_strided(first + offsetof(struct lanes_point, name.z) / sizeof(double), stride);
#define NUMBER(name)                                                                               \
    s.name = lanes_strided(first + offsetof(struct lanes_point, name) / sizeof(double), stride);
    VECTOR(kd)
    VECTOR(ks)
    VECTOR(p)
    VECTOR(n)
    VECTOR(v)
    NUMBER(shininess)
    NUMBER(nv)
    NUMBER(grazing_sine)
    NUMBER(bound)
    return s;
}

static void light(const struct pen_light *source, const struct lanes_point *point, bool specular,
                  struct lanes_arriving *out)
{
    const struct surface s = surface_of(point);
    struct pen_vec3 term[LANES], to_light[LANES];
    struct arriving_light arriving;
    unsigned lit = 0;
    for (int i = 0; i < LANES; i++)
        lit |= (unsigned)point[i].lit << i;
    arriving.term = lanes3_splat(pen_vec3(0, 0, 0));
    if (specular)
        light_unshadowed(&arriving, source, &s, lane_mask_of(lit), PEN_FX_SPECULAR);
    else
        light_unshadowed(&arriving, source, &s, lane_mask_of(lit), 0);
    lanes3_store(term, arriving.term);
    lanes3_store(to_light, arriving.to_light);
    for (int i = 0; i < LANES; i++)
        out[i] = (struct lanes_arriving){lane_mask_bits(arriving.arrives) >> i & 1, term[i],
                                         to_light[i]};
}

#define NAME_OF_ISA(isa) NAME_OF_TOKEN(isa)
#define NAME_OF_TOKEN(token) lanes_test_##token
extern const struct lanes_test NAME_OF_ISA(PEN_ISA);
const struct lanes_test NAME_OF_ISA(PEN_ISA) = {
    .lanes = LANES,
    .functions = functions,
    .sequences = sequences,
    .samples = samples,
    .rays = rays,
    .ray_array = ray_array,
    .surface = surface,
    .origins = origins,
    .light = light,
};

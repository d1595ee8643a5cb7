/* SPDX-License-Identifier: MIT */
/* Tests of boxes with AVX2 and FMA: the eight of a node or the four of a block at once. See
 * prim_test.h. */
#ifndef PEN_ACCEL_INTERNAL_BOXES_AVX2_H
#define PEN_ACCEL_INTERNAL_BOXES_AVX2_H

#include <immintrin.h>

#include "accel/internal/prim_test.h"

static inline __m256d splat4(double x)
{
    return _mm256_set1_pd(x);
}

/* The near or far planes of an axis: their row in a node, and the ray's origin and reciprocal for
 * the comparison. */
struct box_side {
    __m256 o, inv;
    size_t row;
};

struct box_ray {
    struct box_side near[3], far[3];
    float tmin; /* >= 0 */
    double scale;
};

static inline struct box_side box_side(float o, float inv, size_t row)
{
    return (struct box_side){_mm256_set1_ps(o), _mm256_set1_ps(inv), row};
}

/* The nearest floats, limited to finite ones. */
static inline __m128 floats_nearest(__m256d x)
{
    return _mm256_cvtpd_ps(_mm256_max_pd(_mm256_min_pd(x, splat4(FLT_MAX)), splat4(-FLT_MAX)));
}

/* A margin that exceeds the distance of a float from any number that rounds to it, and from its
 * neighbours. */
static inline __m128 floats_margin(__m128 f)
{
    __m128 size = _mm_andnot_ps(_mm_set1_ps(-0.0f), f);
    return _mm_fmadd_ps(size, _mm_set1_ps(0x1p-23f), _mm_set1_ps(FLT_MIN));
}

static inline void box_ray_make(struct box_ray *box, const struct pen_ray *ray, double tmin,
                                double grow)
{
    const __m256i three = _mm256_set_epi64x(0, -1, -1, -1);
    box->scale = box_scale(ray);
    __m256d o = _mm256_maskload_pd(&ray->o.x, three), d = _mm256_maskload_pd(&ray->d.x, three);
    __m128 low = floats_nearest(_mm256_sub_pd(o, splat4(grow)));
    __m128 high = floats_nearest(_mm256_add_pd(o, splat4(grow)));
    low = _mm_sub_ps(low, floats_margin(low));
    high = _mm_add_ps(high, floats_margin(high));
    __m256d inv = _mm256_div_pd(splat4(box->scale), d);
    __m128 far_inv = _mm256_cvtpd_ps(_mm256_mul_pd(inv, splat4(1 + 0x1p-22)));
    /* If d is negative or -0, the near plane is the high end. */
    float o_near[4], o_far[4], inv_near[4], inv_far[4];
    _mm_storeu_ps(o_near, _mm_blendv_ps(high, low, far_inv));
    _mm_storeu_ps(o_far, _mm_blendv_ps(low, high, far_inv));
    _mm_storeu_ps(inv_near, floats_nearest(_mm256_mul_pd(inv, splat4(1 - 0x1p-22))));
    _mm_storeu_ps(inv_far, far_inv);
    size_t negative = (size_t)_mm_movemask_ps(far_inv);
    for (size_t axis = 0; axis < 3; axis++) {
        size_t high_first = negative >> axis & 1;
        box->near[axis] = box_side(o_near[axis], inv_near[axis], axis + 3 * high_first);
        box->far[axis] = box_side(o_far[axis], inv_far[axis], axis + 3 - 3 * high_first);
    }
    box->tmin = pen_float_down(tmin * box->scale);
}

static inline __m256 box_t(const struct pen_node *node, const struct box_side *side)
{
    return _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(node->plane[side->row]), side->o),
                         side->inv);
}

/* The boxes of a node that the ray enters, as bits. An axis with a NaN, from 0 times infinity, does
 * not count, because max and min then return their second operand. */
static inline unsigned enter_node(const struct pen_node *node, const struct box_ray *box,
                                  float limit, float near[PEN_WIDE])
{
    __m256 t0 = _mm256_max_ps(box_t(node, &box->near[0]), _mm256_set1_ps(box->tmin));
    __m256 t1 = _mm256_min_ps(box_t(node, &box->far[0]), _mm256_set1_ps(limit));
    t0 = _mm256_max_ps(box_t(node, &box->near[1]), t0);
    t1 = _mm256_min_ps(box_t(node, &box->far[1]), t1);
    t0 = _mm256_max_ps(box_t(node, &box->near[2]), t0);
    t1 = _mm256_min_ps(box_t(node, &box->far[2]), t1);
    _mm256_storeu_ps(near, t0);
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(t0, t1, _CMP_LE_OQ));
}

/* Two boxes, in the low lanes of four. */
static inline __m128 pair_t(const struct pen_pair *pair, const struct box_side *side)
{
    const __m128i two = _mm_loadl_epi64((const __m128i *)pair->plane[side->row]);
    return _mm_mul_ps(_mm_sub_ps(_mm_castsi128_ps(two), _mm256_castps256_ps128(side->o)),
                      _mm256_castps256_ps128(side->inv));
}

static inline unsigned enter_pair(const struct pen_pair *pair, const struct box_ray *box,
                                  float limit, float near[2])
{
    __m128 t0 = _mm_max_ps(pair_t(pair, &box->near[0]), _mm_set1_ps(box->tmin));
    __m128 t1 = _mm_min_ps(pair_t(pair, &box->far[0]), _mm_set1_ps(limit));
    t0 = _mm_max_ps(pair_t(pair, &box->near[1]), t0);
    t1 = _mm_min_ps(pair_t(pair, &box->far[1]), t1);
    t0 = _mm_max_ps(pair_t(pair, &box->near[2]), t0);
    t1 = _mm_min_ps(pair_t(pair, &box->far[2]), t1);
    _mm_storel_pi((__m64 *)near, t0);
    return (unsigned)_mm_movemask_ps(_mm_cmp_ps(t0, t1, _CMP_LE_OQ)) & 3;
}

static inline __m128 boxes_t(const struct pen_boxes4 *boxes, const struct box_side *side)
{
    return _mm_mul_ps(
        _mm_sub_ps(_mm_loadu_ps(boxes->plane[side->row]), _mm256_castps256_ps128(side->o)),
        _mm256_castps256_ps128(side->inv));
}

/* The boxes of a block that the ray enters, as bits. *inside: those that it enters no later than
 * the query begins. */
static inline unsigned enter_boxes(const struct pen_boxes4 *boxes, const struct box_ray *box,
                                   float limit, unsigned *inside)
{
    const __m128 tmin = _mm_set1_ps(box->tmin);
    __m128 t0 = _mm_max_ps(boxes_t(boxes, &box->near[0]), tmin);
    __m128 t1 = _mm_min_ps(boxes_t(boxes, &box->far[0]), _mm_set1_ps(limit));
    t0 = _mm_max_ps(boxes_t(boxes, &box->near[1]), t0);
    t1 = _mm_min_ps(boxes_t(boxes, &box->far[1]), t1);
    t0 = _mm_max_ps(boxes_t(boxes, &box->near[2]), t0);
    t1 = _mm_min_ps(boxes_t(boxes, &box->far[2]), t1);
    *inside = (unsigned)_mm_movemask_ps(_mm_cmp_ps(t0, tmin, _CMP_EQ_OQ));
    return (unsigned)_mm_movemask_ps(_mm_cmp_ps(t0, t1, _CMP_LE_OQ));
}

#endif

/* SPDX-License-Identifier: MIT */
/* Queries with AVX2 and FMA: eight boxes, four primitives at once. */
#include "ops.h"

#ifdef __AVX2__

#include "blocks_avx2.h"

static inline unsigned enter_node(const struct pen_node *node, const struct box_ray *box,
                                  float limit, float near[PEN_WIDE])
{
    __m256 t0 = _mm256_set1_ps(box->tmin), t1 = _mm256_set1_ps(limit);
    for (int axis = 0; axis < 3; axis++) {
        __m256 lo = _mm256_loadu_ps(box->sign[axis] ? node->hi[axis] : node->lo[axis]);
        __m256 hi = _mm256_loadu_ps(box->sign[axis] ? node->lo[axis] : node->hi[axis]);
        __m256 a = _mm256_mul_ps(_mm256_sub_ps(lo, _mm256_set1_ps(box->near_o[axis])),
                                 _mm256_set1_ps(box->near_inv[axis]));
        __m256 b = _mm256_mul_ps(_mm256_sub_ps(hi, _mm256_set1_ps(box->far_o[axis])),
                                 _mm256_set1_ps(box->far_inv[axis]));
        t0 = _mm256_max_ps(a, t0); /* if a is NaN, from 0 times infinity, t0 stays */
        t1 = _mm256_min_ps(b, t1);
    }
    _mm256_storeu_ps(near, t0);
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(t0, t1, _CMP_LE_OQ));
}

static inline bool test_item(struct trace *w, uint32_t item, bool any)
{
    uint32_t index = PEN_ITEM_INDEX(item);
    switch (PEN_ITEM_KIND(item)) {
    case PEN_BLOCK_TRIANGLES:
        return test_triangles4(w, &w->accel->triangles[index], any);
    case PEN_BLOCK_POLYGONS:
        return test_polygons4(w, &w->accel->polygons[index], any);
    case PEN_BLOCK_SPHERES:
        return test_spheres4(w, &w->accel->spheres[index], any);
    case PEN_BLOCK_CYLINDERS:
        return test_cylinders4(w, &w->accel->cylinders[index], any);
    case PEN_BLOCK_PLANES:
        return test_planes4(w, &w->accel->planes[index], any);
    default:
        return test_each(w, item, any);
    }
}

#include "traverse_walk.h"

static const struct pen_trace_ops avx2 = {"avx2", nearest, shadow};

const struct pen_trace_ops *pen_trace_avx2(void)
{
    return &avx2;
}

#else

const struct pen_trace_ops *pen_trace_avx2(void)
{
    return NULL;
}

#endif

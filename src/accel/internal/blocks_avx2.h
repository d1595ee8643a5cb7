/* SPDX-License-Identifier: MIT */
/* Tests of blocks, four primitives at once, in binary64. Every lane does the operations of the
 * primitive's header in geom in the same order, so t has the same bits. Lanes with a special case
 * (the ray starts on or touches the primitive, or is parallel to it) are left to the scalar
 * functions. The comment of a small function names the scalar function that it computes. */
#ifndef PEN_ACCEL_INTERNAL_BLOCKS_AVX2_H
#define PEN_ACCEL_INTERNAL_BLOCKS_AVX2_H

#include "accel/internal/boxes_avx2.h"

/* Four vectors, one per lane. */
struct vec4 {
    __m256d x, y, z;
};

static inline struct vec4 splat_vec4(struct pen_vec3 v)
{
    return (struct vec4){splat4(v.x), splat4(v.y), splat4(v.z)};
}

/* pen_permuted */
static inline struct vec4 permuted4(const struct pen_ray *ray, const double v[3][PEN_LANES])
{
    return (struct vec4){_mm256_loadu_pd(v[ray->kx]), _mm256_loadu_pd(v[ray->ky]),
                         _mm256_loadu_pd(v[ray->kz])};
}

static inline struct vec4 sub3(struct vec4 a, struct vec4 b)
{
    return (struct vec4){_mm256_sub_pd(a.x, b.x), _mm256_sub_pd(a.y, b.y), _mm256_sub_pd(a.z, b.z)};
}

static inline struct vec4 add3(struct vec4 a, struct vec4 b)
{
    return (struct vec4){_mm256_add_pd(a.x, b.x), _mm256_add_pd(a.y, b.y), _mm256_add_pd(a.z, b.z)};
}

static inline __m256d dot4(struct vec4 a, struct vec4 b)
{
    __m256d xy = _mm256_add_pd(_mm256_mul_pd(a.x, b.x), _mm256_mul_pd(a.y, b.y));
    return _mm256_add_pd(xy, _mm256_mul_pd(a.z, b.z));
}

/* pen_dop */
static inline __m256d dop4(__m256d a, __m256d b, __m256d c, __m256d d)
{
    __m256d w = _mm256_mul_pd(c, d);
    __m256d e = _mm256_fnmadd_pd(c, d, w);
    __m256d f = _mm256_fmsub_pd(a, b, w);
    return _mm256_add_pd(f, e);
}

/* -pen_dop */
static inline __m256d minus_dop4(__m256d a, __m256d b, __m256d c, __m256d d)
{
    __m256d w = _mm256_mul_pd(c, d);
    __m256d e = _mm256_fmsub_pd(c, d, w);
    __m256d f = _mm256_fnmadd_pd(a, b, w);
    return _mm256_add_pd(f, e);
}

/* pen_cross */
static inline struct vec4 cross4(struct vec4 a, struct vec4 b)
{
    return (struct vec4){dop4(a.y, b.z, a.z, b.y), dop4(a.z, b.x, a.x, b.z),
                         dop4(a.x, b.y, a.y, b.x)};
}

/* pen_difference_error */
static inline __m256d difference_error4(__m256d a, __m256d b, __m256d diff)
{
    __m256d part = _mm256_sub_pd(diff, a);
    return _mm256_sub_pd(_mm256_sub_pd(a, _mm256_sub_pd(diff, part)), _mm256_add_pd(b, part));
}

/* pen_along_once */
static inline struct vec4 along4(struct vec4 a, struct vec4 d, __m256d t)
{
    return (struct vec4){_mm256_fmadd_pd(t, d.x, a.x), _mm256_fmadd_pd(t, d.y, a.y),
                         _mm256_fmadd_pd(t, d.z, a.z)};
}

static inline __m256d neg4(__m256d x)
{
    return _mm256_xor_pd(x, splat4(-0.0));
}

static inline __m256d abs4(__m256d x)
{
    return _mm256_andnot_pd(splat4(-0.0), x);
}

static inline unsigned bits(__m256d mask)
{
    return (unsigned)_mm256_movemask_pd(mask);
}

#define LESS(a, b) _mm256_cmp_pd(a, b, _CMP_LT_OQ)
#define LESS_EQUAL(a, b) _mm256_cmp_pd(a, b, _CMP_LE_OQ)

/* The largest t at which intersections count. */
static inline __m256d tmax4(const struct trace *trace, bool any)
{
    return splat4(any ? trace->shadow->tmax : trace->best.t);
}

/* The lane whose primitive the ray starts on, as a mask. */
static inline unsigned origin_lanes(const struct trace *trace, const uint32_t prim[PEN_LANES])
{
    __m128i same = _mm_cmpeq_epi32(_mm_loadu_si128((const __m128i *)prim),
                                   _mm_set1_epi32((int)trace->origin->prim));
    return trace->from_surface ? (unsigned)_mm_movemask_ps(_mm_castsi128_ps(same)) : 0;
}

/* Lanes whose interval [t0, t1] overlaps the query's. */
static inline unsigned useful_pairs(const struct trace *trace, __m256d t0, __m256d t1, bool any)
{
    __m256d after = splat4(any ? 0 : trace->after.t);
    return bits(_mm256_and_pd(
        LESS(t0, t1), _mm256_and_pd(LESS_EQUAL(t0, tmax4(trace, any)), LESS_EQUAL(after, t1))));
}

/* The same if t0 and t1 are only bounds, or NaN for no bound. */
static inline unsigned overlaps4(const struct trace *trace, __m256d t0, __m256d t1, bool any)
{
    __m256d out =
        _mm256_or_pd(LESS(tmax4(trace, any), t0), LESS(t1, splat4(any ? 0 : trace->after.t)));
    return 15 & ~bits(_mm256_or_pd(LESS(t1, t0), out));
}

/* Tests lanes by the scalar function; skips empty lanes. */
static inline bool test_lanes(struct trace *trace, const uint32_t prim[PEN_LANES], unsigned lanes,
                              bool any)
{
    for (; lanes; lanes &= lanes - 1) {
        if (prim[__builtin_ctz(lanes)] != PEN_NO_PRIM &&
            test_prim(trace, prim[__builtin_ctz(lanes)], any))
            return true;
    }
    return false;
}

/* Tests lanes by the reference, for flat primitives that may have the ray's origin on their border.
 */
static inline bool test_at_border(struct trace *trace, const uint32_t prim[PEN_LANES],
                                  unsigned lanes, bool any)
{
    for (; lanes; lanes &= lanes - 1) {
        uint32_t number = prim[__builtin_ctz(lanes)];
        if (number != PEN_NO_PRIM && test_reference(trace, number, any))
            return true;
    }
    return false;
}

/* Lanes whose intersections the scalar functions refine. */
static inline unsigned refined_lanes(const struct trace *trace, __m256d tp, __m256d h, __m256d disc,
                                     __m256d rr)
{
    __m256d near =
        LESS(abs4(_mm256_sub_pd(abs4(tp), h)), _mm256_mul_pd(splat4(trace->ray->near), h));
    return bits(_mm256_or_pd(near, LESS(abs4(disc), _mm256_mul_pd(splat4(PEN_GRAZING), rr))));
}

static inline bool test_spheres4(struct trace *trace, const struct pen_spheres4 *b, bool any)
{
    struct vec4 o = splat_vec4(trace->ray->permuted_o), d = splat_vec4(trace->ray->permuted_d),
                c = permuted4(trace->ray, b->c);
    struct vec4 f = sub3(o, c);
    struct vec4 low = {difference_error4(o.x, c.x, f.x), difference_error4(o.y, c.y, f.y),
                       difference_error4(o.z, c.z, f.z)};
    __m256d inv_dd = splat4(trace->ray->inv_dd);
    __m256d tp = _mm256_mul_pd(neg4(dot4(f, d)), inv_dd);
    struct vec4 l = add3(along4(f, d, tp), low);
    __m256d rest = _mm256_mul_pd(neg4(dot4(l, d)), inv_dd);
    __m256d rr = _mm256_loadu_pd(b->rr);
    __m256d disc = _mm256_add_pd(_mm256_sub_pd(rr, dot4(l, l)), _mm256_loadu_pd(b->rr_low));
    unsigned own = origin_lanes(trace, b->prim);
    /* All lanes certainly miss, by more than refinement can change. */
    if ((bits(LESS(_mm256_mul_pd(splat4(-PEN_GRAZING), rr), disc)) | own) == 0)
        return false;
    __m256d h = _mm256_sqrt_pd(_mm256_mul_pd(disc, inv_dd));
    double t[2][PEN_LANES];
    __m256d t0 = _mm256_add_pd(tp, _mm256_sub_pd(rest, h));
    __m256d t1 = _mm256_add_pd(tp, _mm256_add_pd(rest, h));
    unsigned lanes = useful_pairs(trace, t0, t1, any) & ~own,
             refined = refined_lanes(trace, tp, h, disc, rr);
    if (refined)
        own |= refined;
    lanes &= ~own;
    if (trace->reaches_origin) {
        __m256d r = _mm256_loadu_pd(b->r);
        __m256d near = _mm256_mul_pd(
            splat4(4), _mm256_mul_pd(r, _mm256_add_pd(splat4(trace->origin->bound),
                                                      _mm256_mul_pd(splat4(8 * PEN_U), r))));
        own |= bits(
            _mm256_and_pd(LESS_EQUAL(abs4(_mm256_sub_pd(dot4(f, f), rr)), near), LESS(t0, t1)));
        lanes &= ~own;
    }
    _mm256_storeu_pd(t[0], t0);
    _mm256_storeu_pd(t[1], t1);
    for (; lanes; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        double pair[2] = {t[0][lane], t[1][lane]};
        if (offer_pair(trace, b->prim[lane], pair, any))
            return true;
    }
    return own && test_lanes(trace, b->prim, own, any);
}

/* pen_sheared */
static inline struct vec4 shear4(const struct trace *trace, const double v[3][PEN_LANES])
{
    const struct pen_ray *ray = trace->ray;
    struct vec4 f = sub3(permuted4(ray, v), splat_vec4(ray->permuted_o));
    f.x = _mm256_sub_pd(f.x, _mm256_mul_pd(splat4(ray->sx), f.z));
    f.y = _mm256_sub_pd(f.y, _mm256_mul_pd(splat4(ray->sy), f.z));
    return f;
}

/* Its y alone, and below its x alone. */
static inline __m256d shear_y4(const struct trace *trace, const double v[3][PEN_LANES])
{
    const struct pen_ray *ray = trace->ray;
    __m256d z = _mm256_sub_pd(_mm256_loadu_pd(v[ray->kz]), splat4(ray->permuted_o.z));
    __m256d y = _mm256_sub_pd(_mm256_loadu_pd(v[ray->ky]), splat4(ray->permuted_o.y));
    return _mm256_sub_pd(y, _mm256_mul_pd(splat4(ray->sy), z));
}

static inline __m256d shear_x4(const struct trace *trace, const double v[3][PEN_LANES])
{
    const struct pen_ray *ray = trace->ray;
    __m256d z = _mm256_sub_pd(_mm256_loadu_pd(v[ray->kz]), splat4(ray->permuted_o.z));
    __m256d x = _mm256_sub_pd(_mm256_loadu_pd(v[ray->kx]), splat4(ray->permuted_o.x));
    return _mm256_sub_pd(x, _mm256_mul_pd(splat4(ray->sx), z));
}

/* A superset of the lanes whose edge from a to b passes within `slack` of the ray's origin. In ray
 * space the shear at most doubles distances across the ray. An edge that is a single point there
 * has a neighbour that is longer and passes as near. */
static inline __m256d edge_passes_origin4(const struct trace *trace, struct vec4 a, struct vec4 b)
{
    __m256d size = _mm256_add_pd(abs4(_mm256_sub_pd(b.x, a.x)), abs4(_mm256_sub_pd(b.y, a.y)));
    __m256d area = _mm256_sub_pd(_mm256_mul_pd(a.x, b.y), _mm256_mul_pd(a.y, b.x));
    return LESS(abs4(area), _mm256_mul_pd(splat4(16 * trace->slack), size));
}

/* A superset of the triangles with the ray's origin on their border. */
static __attribute__((noinline)) unsigned triangle_borders4(const struct trace *trace,
                                                            const struct pen_triangles4 *block)
{
    struct vec4 a = shear4(trace, block->v[0]), b = shear4(trace, block->v[1]),
                c = shear4(trace, block->v[2]);
    __m256d ab = edge_passes_origin4(trace, a, b), bc = edge_passes_origin4(trace, b, c);
    return bits(_mm256_or_pd(_mm256_or_pd(ab, bc), edge_passes_origin4(trace, c, a)));
}

/* Offers the intersections with triangles that the ray's line enters. */
static inline bool offer_triangles(struct trace *trace, const uint32_t prim[PEN_LANES],
                                   unsigned lanes, bool any)
{
    const struct pen_prims *prims = trace->accel->prims;
    for (; lanes; lanes &= lanes - 1) {
        uint32_t number = prim[__builtin_ctz(lanes)];
        const struct pen_triangle *tri = &prims->triangle[pen_prim_ref(prims, number).index];
        if (offer_outline(trace, number, &tri->facet, tri->v, 3, any))
            return true;
    }
    return false;
}

static inline bool test_triangles4(struct trace *trace, const struct pen_triangles4 *block,
                                   bool any)
{
    const __m256d zero = splat4(0);
    struct vec4 a = shear4(trace, block->v[0]), b = shear4(trace, block->v[1]),
                c = shear4(trace, block->v[2]);
    __m256d ew = dop4(a.x, b.y, a.y, b.x), eu = dop4(b.x, c.y, b.y, c.x);
    __m256d ev = minus_dop4(a.x, c.y, a.y, c.x);
    __m256d a_low = LESS_EQUAL(a.y, zero), b_low = LESS_EQUAL(b.y, zero);
    __m256d c_low = LESS_EQUAL(c.y, zero);
    /* At most one edge passes upward and one downward; the winding is their difference. */
    __m256d up =
        _mm256_or_pd(_mm256_or_pd(_mm256_and_pd(_mm256_andnot_pd(b_low, a_low), LESS(zero, ew)),
                                  _mm256_and_pd(_mm256_andnot_pd(c_low, b_low), LESS(zero, eu))),
                     _mm256_and_pd(_mm256_andnot_pd(a_low, c_low), LESS(zero, ev)));
    __m256d down =
        _mm256_or_pd(_mm256_or_pd(_mm256_and_pd(_mm256_andnot_pd(a_low, b_low), LESS(ew, zero)),
                                  _mm256_and_pd(_mm256_andnot_pd(b_low, c_low), LESS(eu, zero))),
                     _mm256_and_pd(_mm256_andnot_pd(c_low, a_low), LESS(ev, zero)));
    unsigned lanes = bits(_mm256_xor_pd(up, down));
    if (trace->reaches_origin) {
        unsigned border = triangle_borders4(trace, block) & ~origin_lanes(trace, block->prim);
        if (border && test_at_border(trace, block->prim, border, any))
            return true;
        lanes &= ~border;
    }
    return lanes &&
           offer_triangles(trace, block->prim, lanes & ~origin_lanes(trace, block->prim), any);
}

/* The lanes of a block whose boxes the ray enters; it certainly misses the others. *inside: the
 * lanes that may contain its origin. */
static inline unsigned lanes_entered(const struct trace *trace, const struct pen_boxes4 *boxes,
                                     bool any, unsigned *inside)
{
    const struct box_ray *box = trace->box;
    *inside = 15;
    if (!box)
        return 15;
    const double tmax = any ? trace->shadow->tmax : trace->best.t;
    return enter_boxes(boxes, box, pen_float_up(tmax * box->scale), inside);
}

/* The largest number of corners in `lanes` of a block. Lanes without a polygon have none. */
static inline uint32_t most_corners(const struct trace *trace, const struct pen_polygons4 *block,
                                    unsigned lanes)
{
    const struct pen_prims *prims = trace->accel->prims;
    uint32_t most = 1;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t prim = block->prim[__builtin_ctz(lanes)];
        const uint32_t count =
            prim != PEN_NO_PRIM ? prims->polygon[pen_prim_ref(prims, prim).index].count : 0;
        most = count > most ? count : most;
    }
    return most;
}

/* Whether polygons wind around the ray, by the winding rule of geom/triangle.h. */
struct entered4 {
    unsigned lanes; /* lanes that do; right except in `ties` */
    unsigned ties;  /* two products round to the same number: their order is not known */
};

/* The sums over the edges of four polygons. */
struct winding4 {
    __m256i turns;
    __m256d ties,
        near; /* masks: entered4.ties, and polygons with the ray's origin on their border */
};

/* Adds the edge from a to b in the lanes in which it `passes` y = 0; a_low: a.y is not above 0. If
 * two products round to different numbers, these have the order of the exact products. */
static inline void add_edge4(struct winding4 *w, struct vec4 a, struct vec4 b, __m256d a_low,
                             __m256d passes)
{
    const __m256i one = _mm256_set1_epi64x(1);
    __m256d p = _mm256_mul_pd(a.x, b.y), q = _mm256_mul_pd(a.y, b.x);
    w->ties = _mm256_or_pd(w->ties, _mm256_and_pd(passes, _mm256_cmp_pd(p, q, _CMP_EQ_OQ)));
    /* On the right: p > q for an upward edge, p < q for a downward one. */
    __m256d right = _mm256_andnot_pd(_mm256_xor_pd(LESS(q, p), a_low), passes);
    __m256i turn = _mm256_or_si256(_mm256_castpd_si256(a_low), one); /* up: -1, down: 1 */
    w->turns = _mm256_add_epi64(w->turns, _mm256_and_si256(_mm256_castpd_si256(right), turn));
}

/* The polygons that wind around the ray. The result is valid for `lanes` only, so a polygon of a
 * hundred corners that the ray misses costs nothing. x is computed only for ends of edges that pass
 * y = 0, which are few. If `border` is not NULL, it gets a superset of the polygons with the ray's
 * origin on their border. */
static inline struct entered4 polygons_entered4(const struct trace *trace,
                                                const struct pen_polygons4 *block, unsigned lanes,
                                                unsigned *border)
{
    const __m256d zero = splat4(0);
    const struct pen_corner4 *corner = &trace->accel->corners[block->first];
    const uint32_t count = most_corners(trace, block, lanes);
    const struct pen_corner4 *from = &corner[count - 1];
    struct winding4 w = {_mm256_setzero_si256(), zero, zero};
    struct vec4 a = {zero, shear_y4(trace, from->v), zero}, b = {zero, zero, zero};
    __m256d a_low = LESS_EQUAL(a.y, zero);
    for (uint32_t i = 0; i < count; from = &corner[i++]) {
        b.y = shear_y4(trace, corner[i].v);
        __m256d b_low = LESS_EQUAL(b.y, zero), passes = _mm256_xor_pd(a_low, b_low);
        if (border || bits(passes)) {
            a.x = shear_x4(trace, from->v);
            b.x = shear_x4(trace, corner[i].v);
            add_edge4(&w, a, b, a_low, passes);
            if (border)
                w.near = _mm256_or_pd(w.near, edge_passes_origin4(trace, a, b));
        }
        a.y = b.y;
        a_low = b_low;
    }
    if (border)
        *border = bits(w.near);
    __m256i none = _mm256_cmpeq_epi64(w.turns, _mm256_setzero_si256());
    unsigned tied = bits(w.ties);
    return (struct entered4){15 & ~bits(_mm256_castsi256_pd(none)) & ~tied, tied};
}

/* Offers the intersections with polygons that the ray's line enters. */
static inline bool offer_polygons(struct trace *trace, const struct pen_polygons4 *block,
                                  struct entered4 in, unsigned lanes, bool any)
{
    const struct pen_prims *prims = trace->accel->prims;
    for (unsigned sure = in.lanes & lanes; sure; sure &= sure - 1) {
        uint32_t number = block->prim[__builtin_ctz(sure)];
        const struct pen_polygon *p = &prims->polygon[pen_prim_ref(prims, number).index];
        if (offer_outline(trace, number, &p->facet, p->v, p->count, any))
            return true;
    }
    return in.ties & lanes && test_lanes(trace, block->prim, in.ties & lanes, any);
}

/* Tests `lanes`, none of which is the ray's origin surface. */
static __attribute__((noinline)) bool test_polygons_at_origin(struct trace *trace,
                                                              const struct pen_polygons4 *block,
                                                              unsigned lanes, bool any)
{
    unsigned border;
    struct entered4 in = polygons_entered4(trace, block, lanes, &border);
    if (border & lanes && test_at_border(trace, block->prim, border & lanes, any))
        return true;
    return (in.lanes | in.ties) & lanes & ~border &&
           offer_polygons(trace, block, in, lanes & ~border, any);
}

static inline bool test_polygons4(struct trace *trace, const struct pen_polygons4 *block, bool any)
{
    unsigned inside;
    const unsigned lanes =
        lanes_entered(trace, &block->boxes, any, &inside) & ~origin_lanes(trace, block->prim);
    if (!lanes)
        return false;
    if (trace->reaches_origin && inside & lanes)
        return test_polygons_at_origin(trace, block, lanes, any);
    struct entered4 in = polygons_entered4(trace, block, lanes, NULL);
    return (in.lanes | in.ties) & lanes && offer_polygons(trace, block, in, lanes, any);
}

/* a + b, and the rounding error of that sum in *lost (Knuth), as in pen_dot2. */
static inline __m256d sum4(__m256d a, __m256d b, __m256d *lost)
{
    __m256d next = _mm256_add_pd(a, b), part = _mm256_sub_pd(next, a);
    *lost = _mm256_add_pd(_mm256_sub_pd(a, _mm256_sub_pd(next, part)), _mm256_sub_pd(b, part));
    return next;
}

/* pen_dot2 */
static inline __m256d accurate_dot4(struct vec4 a, struct vec4 b)
{
    __m256d x = _mm256_mul_pd(a.x, b.x), y = _mm256_mul_pd(a.y, b.y), z = _mm256_mul_pd(a.z, b.z);
    __m256d low = _mm256_fmsub_pd(a.x, b.x, x), lost;
    __m256d total = sum4(x, y, &lost);
    low = _mm256_add_pd(low, _mm256_add_pd(lost, _mm256_fmsub_pd(a.y, b.y, y)));
    total = sum4(total, z, &lost);
    low = _mm256_add_pd(low, _mm256_add_pd(lost, _mm256_fmsub_pd(a.z, b.z, z)));
    return _mm256_add_pd(total, low);
}

/* pen_dot_guarded */
static inline __m256d dot_guarded4(struct vec4 a, struct vec4 b)
{
    __m256d x = _mm256_mul_pd(a.x, b.x), y = _mm256_mul_pd(a.y, b.y), z = _mm256_mul_pd(a.z, b.z);
    __m256d sum = _mm256_add_pd(_mm256_add_pd(x, y), z);
    __m256d size = _mm256_add_pd(_mm256_add_pd(abs4(x), abs4(y)), abs4(z));
    __m256d plain = LESS_EQUAL(size, _mm256_mul_pd(abs4(sum), splat4(8)));
    return bits(plain) == 15 ? sum : _mm256_blendv_pd(accurate_dot4(a, b), sum, plain);
}

/* Tests four planes. `tied` is a constant: whether the ray is tied. */
static inline __attribute__((always_inline)) bool
planes4(struct trace *trace, const struct pen_planes4 *b, bool any, bool tied)
{
    struct vec4 g = permuted4(trace->ray, b->g),
                f = sub3(permuted4(trace->ray, b->q), splat_vec4(trace->ray->permuted_o));
    struct vec4 d = splat_vec4(trace->ray->permuted_d);
    __m256d gd = tied ? accurate_dot4(g, d) : dot_guarded4(g, d);
    __m256d t = _mm256_div_pd(tied ? accurate_dot4(g, f) : dot4(g, f), gd);
    __m256d oblique = _mm256_cmp_pd(gd, splat4(0), _CMP_NEQ_OQ);
    __m256d after = splat4(any ? 0 : trace->after.t);
    __m256d useful = _mm256_and_pd(LESS_EQUAL(after, t), LESS_EQUAL(t, tmax4(trace, any)));
    unsigned lanes = bits(_mm256_and_pd(oblique, useful)), near = 0;
    if (trace->from_surface) {
        /* A superset of the lanes that the ray's origin touches; |g| < 2. */
        __m256d size = _mm256_add_pd(_mm256_add_pd(abs4(f.x), abs4(f.y)), abs4(f.z));
        __m256d bound = _mm256_fmadd_pd(splat4(8 * PEN_U), size, splat4(trace->origin->bound));
        __m256d touches = LESS_EQUAL(abs4(_mm256_mul_pd(t, gd)), _mm256_mul_pd(splat4(4), bound));
        unsigned own = origin_lanes(trace, b->prim);
        near = bits(_mm256_and_pd(oblique, touches)) & ~own;
        lanes &= ~(near | own);
    }
    if ((lanes | near) == 0)
        return false;
    double at[PEN_LANES];
    _mm256_storeu_pd(at, t);
    for (; near; near &= near - 1) {
        int lane = __builtin_ctz(near);
        if (offer_flat(trace, b->prim[lane], at[lane], any))
            return true;
    }
    for (; lanes; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        if (offer(trace, b->prim[lane], at[lane], PEN_PART_SIDE, any))
            return true;
    }
    return false;
}

static __attribute__((noinline)) bool test_planes_tied4(struct trace *trace,
                                                        const struct pen_planes4 *b, bool any)
{
    return planes4(trace, b, any, true);
}

static inline bool test_planes4(struct trace *trace, const struct pen_planes4 *b, bool any)
{
    if (pen_ray_tied(trace->ray))
        return test_planes_tied4(trace, b, any);
    return planes4(trace, b, any, false);
}

/* The intersections of a ray with four cylinders that are continued without end. */
struct side4 {
    __m256d mm, nn; /* |d x a|^2, 0 if parallel; squared distance of the origin from the axis, times
                       |a|^2 */
    __m256d inv, tp, lm, disc, rr; /* of pen_cylinder_side_roots; lm is l.m */
    __m256d t0, t1;                /* as pen_cylinder_side_roots */
    unsigned near; /* lanes that the scalar function refines; there t is within [least, most] */
    __m256d least, most;
};

/* The first half of pen_cylinder_side_roots: the distance of the ray's line from the axis. Returns
 * the lanes that it certainly misses, by more than refinement can change; parallel lanes are not
 * among them. */
static inline unsigned side_distance4(const struct trace *trace, const struct pen_cylinders4 *b,
                                      struct vec4 f, struct vec4 a, struct side4 *out)
{
    struct vec4 o = splat_vec4(trace->ray->permuted_o), q = permuted4(trace->ray, b->q);
    struct vec4 low = {difference_error4(o.x, q.x, f.x), difference_error4(o.y, q.y, f.y),
                       difference_error4(o.z, q.z, f.z)};
    struct vec4 rest3 = {_mm256_sub_pd(_mm256_mul_pd(low.y, a.z), _mm256_mul_pd(low.z, a.y)),
                         _mm256_sub_pd(_mm256_mul_pd(low.z, a.x), _mm256_mul_pd(low.x, a.z)),
                         _mm256_sub_pd(_mm256_mul_pd(low.x, a.y), _mm256_mul_pd(low.y, a.x))};
    struct vec4 m = cross4(splat_vec4(trace->ray->permuted_d), a), n = add3(cross4(f, a), rest3);
    out->mm = dot4(m, m);
    out->nn = dot4(n, n);
    out->inv = _mm256_div_pd(splat4(1), out->mm);
    out->tp = _mm256_mul_pd(neg4(dot4(m, n)), out->inv);
    struct vec4 l = along4(n, m, out->tp);
    out->lm = dot4(l, m);
    out->rr = _mm256_loadu_pd(b->rr);
    out->disc = _mm256_add_pd(_mm256_sub_pd(out->rr, dot4(l, l)), _mm256_loadu_pd(b->rr_low));
    return bits(_mm256_and_pd(LESS(splat4(0), out->mm),
                              LESS(out->disc, _mm256_mul_pd(splat4(-PEN_GRAZING), out->rr))));
}

/* The second half: the roots. */
static inline void side_roots4(const struct trace *trace, struct side4 *out)
{
    __m256d rest = _mm256_mul_pd(neg4(out->lm), out->inv), tp = out->tp;
    __m256d h = _mm256_sqrt_pd(_mm256_mul_pd(out->disc, out->inv));
    out->t0 = _mm256_add_pd(tp, _mm256_sub_pd(rest, h));
    out->t1 = _mm256_add_pd(tp, _mm256_add_pd(rest, h));
    out->near = refined_lanes(trace, tp, h, out->disc, out->rr);
    if (out->near) { /* the half chord is at most r / |m| */
        __m256d reach = _mm256_sqrt_pd(_mm256_mul_pd(_mm256_mul_pd(splat4(2), out->rr), out->inv));
        out->least = _mm256_sub_pd(tp, reach);
        out->most = _mm256_add_pd(tp, reach);
    }
}

/* The sum of the sizes of the products in a dot product. */
static inline __m256d size4(struct vec4 a, struct vec4 b)
{
    __m256d xy = _mm256_add_pd(abs4(_mm256_mul_pd(a.x, b.x)), abs4(_mm256_mul_pd(a.y, b.y)));
    return _mm256_add_pd(xy, abs4(_mm256_mul_pd(a.z, b.z)));
}

/* A superset of the lanes that the ray's origin touches, as pen_cylinder_touches; |a| < 2. */
static inline __m256d cylinder_touches4(const struct trace *trace, const struct pen_cylinders4 *b,
                                        __m256d nn, __m256d fa)
{
    __m256d size = _mm256_loadu_pd(b->size);
    __m256d bound =
        _mm256_add_pd(splat4(trace->origin->bound), _mm256_mul_pd(splat4(8 * PEN_U), size));
    __m256d off_side = abs4(_mm256_sub_pd(nn, _mm256_loadu_pd(b->rr)));
    __m256d off_base = abs4(_mm256_sub_pd(_mm256_loadu_pd(b->base), fa));
    __m256d off_top = abs4(_mm256_sub_pd(_mm256_loadu_pd(b->top), fa));
    __m256d twice = _mm256_mul_pd(splat4(2), bound);
    return _mm256_or_pd(LESS_EQUAL(off_side, _mm256_mul_pd(splat4(16), _mm256_mul_pd(size, bound))),
                        _mm256_or_pd(LESS_EQUAL(off_base, twice), LESS_EQUAL(off_top, twice)));
}

/* pen_cylinder_slab_loses. For tied rays, side4.near contains all lanes that count. */
static inline unsigned slab_loses4(const struct trace *trace, const struct pen_cylinders4 *b,
                                   struct vec4 f, struct vec4 a)
{
    const __m256d four = splat4(4);
    struct vec4 d = splat_vec4(trace->ray->permuted_d);
    __m256d top = _mm256_loadu_pd(b->top), fa = dot4(f, a), da = dot4(d, a);
    __m256d rest = abs4(_mm256_sub_pd(top, fa)), least = _mm256_min_pd(rest, abs4(fa));
    return bits(_mm256_or_pd(LESS(_mm256_mul_pd(four, least), size4(f, a)),
                             _mm256_or_pd(LESS(_mm256_mul_pd(four, rest), top),
                                          LESS(_mm256_mul_pd(four, abs4(da)), size4(d, a)))));
}

/* Offers the two ends of the ray's interval inside one cylinder. */
static inline bool offer_inside(struct trace *trace, const struct pen_cylinders4 *b, int lane,
                                const struct pen_interval *in, bool any)
{
    bool caps = !(b->open >> lane & 1);
    return ((caps || in->lo_part == PEN_PART_SIDE) &&
            offer(trace, b->prim[lane], in->lo, in->lo_part, any)) ||
           ((caps || in->hi_part == PEN_PART_SIDE) &&
            offer(trace, b->prim[lane], in->hi, in->hi_part, any));
}

/* The t-intervals in the slabs. `up`: lanes in which the ray goes from the base to the top. */
struct slab4 {
    __m256d lo, hi;
    unsigned up;
};

/* Clips the slabs' intervals to the sides', and offers their ends. */
static inline bool offer_sides(struct trace *trace, const struct pen_cylinders4 *b, unsigned lanes,
                               const struct slab4 *slab, const struct side4 *side, bool any)
{
    double s0[PEN_LANES], s1[PEN_LANES], l[PEN_LANES], h[PEN_LANES];
    _mm256_storeu_pd(s0, side->t0);
    _mm256_storeu_pd(s1, side->t1);
    _mm256_storeu_pd(l, slab->lo);
    _mm256_storeu_pd(h, slab->hi);
    for (; lanes; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        const double s[2] = {s0[lane], s1[lane]};
        struct pen_interval in = {l[lane], h[lane], PEN_PART_BASE, PEN_PART_TOP};
        if (!(slab->up >> lane & 1)) {
            in.lo_part = PEN_PART_TOP;
            in.hi_part = PEN_PART_BASE;
        }
        if (pen_interval_clip(&in, s) && offer_inside(trace, b, lane, &in, any))
            return true;
    }
    return false;
}

/* Lanes with t0 or t1 near the ray's origin: see may_pass_rim. */
static inline unsigned near4(const struct trace *trace, __m256d t0, __m256d t1)
{
    __m256d least = _mm256_min_pd(_mm256_mul_pd(t0, t0), _mm256_mul_pd(t1, t1));
    return bits(LESS_EQUAL(least, splat4(trace->near_sq)));
}

/* Lanes whose ends are certainly on the side, at side.t0 and side.t1, if the ends of the refined
 * slab are within `pad` of these. `first`: only the first end matters, if it is ahead. */
static inline unsigned ends_on_side4(const struct trace *trace, const struct side4 *side,
                                     const struct slab4 *slab, __m256d pad, bool first)
{
    const __m256d hi = _mm256_sub_pd(slab->hi, pad), after = splat4(trace->after.t);
    __m256d last = LESS(side->t1, hi);
    if (first)
        last = _mm256_or_pd(last, _mm256_and_pd(LESS(side->t0, hi), LESS(after, side->t0)));
    return bits(_mm256_and_pd(LESS(_mm256_add_pd(slab->lo, pad), side->t0), last));
}

static inline bool test_cylinders4(struct trace *trace, const struct pen_cylinders4 *b, bool any)
{
    unsigned inside;
    const unsigned entered = lanes_entered(trace, &b->boxes, any, &inside);
    if (!entered)
        return false;
    const __m256d zero = splat4(0);
    struct vec4 a = permuted4(trace->ray, b->a), o = splat_vec4(trace->ray->permuted_o);
    struct vec4 f = sub3(o, permuted4(trace->ray, b->q));
    struct side4 side;
    const unsigned missed = side_distance4(trace, b, f, a, &side);
    unsigned plain = entered & origin_lanes(trace, b->prim);
    const bool at_origin = trace->reaches_origin && inside & entered & ~plain;
    if (!at_origin && !(entered & ~missed) && !plain)
        return false;
    side_roots4(trace, &side);
    __m256d da = dot_guarded4(splat_vec4(trace->ray->permuted_d), a), fa = dot4(f, a);
    __m256d inv = _mm256_div_pd(splat4(1), da);
    __m256d base = _mm256_mul_pd(_mm256_sub_pd(_mm256_loadu_pd(b->base), fa), inv);
    __m256d top = _mm256_mul_pd(_mm256_sub_pd(_mm256_loadu_pd(b->top), fa), inv);
    __m256d forward = LESS(zero, da);
    const struct slab4 slab = {_mm256_blendv_pd(top, base, forward),
                               _mm256_blendv_pd(base, top, forward), bits(forward)};
    __m256d edge_on = splat4(PEN_EDGE_ON * fabs(trace->ray->permuted_d.z));
    plain |= entered &
             (bits(LESS_EQUAL(abs4(da), edge_on)) | bits(_mm256_cmp_pd(side.mm, zero, _CMP_EQ_OQ)));
    __m256d t0 = _mm256_max_pd(side.t0, slab.lo), t1 = _mm256_min_pd(side.t1, slab.hi);
    __m256d met = _mm256_and_pd(LESS(side.t0, side.t1), LESS(t0, t1));
    unsigned lanes = bits(met) & entered;
    side.near &= entered;
    if (side.near | (lanes & ~plain)) {
        /* More than the rounding of lo and hi. */
        __m256d size = _mm256_add_pd(size4(f, a), _mm256_loadu_pd(b->top));
        __m256d pad = _mm256_mul_pd(_mm256_mul_pd(splat4(0x1p-40), size), abs4(inv));
        if (side.near)
            plain |=
                side.near & overlaps4(trace, _mm256_max_pd(side.least, _mm256_sub_pd(slab.lo, pad)),
                                      _mm256_min_pd(side.most, _mm256_add_pd(slab.hi, pad)), any);
        lanes &= ~side.near;
        if (lanes & ~plain)
            plain |= lanes & slab_loses4(trace, b, f, a) &
                     ~ends_on_side4(trace, &side, &slab, pad, !any && !at_origin) &
                     overlaps4(trace, _mm256_sub_pd(t0, pad), _mm256_add_pd(t1, pad), any);
    }
    lanes &= useful_pairs(trace, t0, t1, any);
    if (at_origin)
        plain |= entered & (bits(cylinder_touches4(trace, b, side.nn, fa)) |
                            (b->open ? b->open & near4(trace, side.t0, side.t1) : 0) |
                            (bits(met) & near4(trace, t0, t1)));
    lanes &= ~plain;
    if (lanes && offer_sides(trace, b, lanes, &slab, &side, any))
        return true;
    return plain && test_lanes(trace, b->prim, plain, any);
}

static inline bool test_item(struct trace *trace, uint32_t item, bool any)
{
    uint32_t index = PEN_ITEM_INDEX(item);
    switch (PEN_ITEM_KIND(item)) {
    case PEN_BLOCK_TRIANGLES:
        return test_triangles4(trace, &trace->accel->triangles[index], any);
    case PEN_BLOCK_POLYGONS:
        return test_polygons4(trace, &trace->accel->polygons[index], any);
    case PEN_BLOCK_SPHERES:
        return test_spheres4(trace, &trace->accel->spheres[index], any);
    case PEN_BLOCK_CYLINDERS:
        return test_cylinders4(trace, &trace->accel->cylinders[index], any);
    case PEN_BLOCK_PLANES:
        return test_planes4(trace, &trace->accel->planes[index], any);
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return test_each(trace, item, any);
}

#endif

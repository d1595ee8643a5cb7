/* SPDX-License-Identifier: MIT */
/* Meshes in a query. A block's lanes are tested in binary32 with bounds (mesh_ray.h). Lanes that
 * are sure to be met narrow the query, and are tested exactly at its end, if they are still of use.
 * Other lanes that may be met are tested exactly at once. The exact test reads the block, whose
 * floats become the same doubles as the scene's, and computes the facet again. */
#ifndef PEN_ACCEL_INTERNAL_MESH_QUERY_H
#define PEN_ACCEL_INTERNAL_MESH_QUERY_H

#include "accel/internal/mesh_facet.h"
#include "accel/internal/mesh_ray.h"

/* A lane that the ray is sure to enter. */
struct mesh_candidate {
    float least;   /* a lower bound of its depth for boxes */
    uint32_t lane; /* four times the block's number, plus the lane's */
};

enum { MESH_CANDIDATES = 16 };

/* Depths are those for boxes. */
struct mesh_query {
    struct mesh_box box;
    const struct pen_mesh *mesh; /* that of the last block; NULL: none yet */
    bool several;                /* there are other meshes */
    bool opaque;                 /* it transmits no light */
    float after; /* nearest: lanes at most as deep may be before the query's interval */
    float limit; /* the largest depth that matters */
    int count;
    struct mesh_ray ray; /* for that mesh */
    struct mesh_candidate candidate[MESH_CANDIDATES];
};

/* Begins a query from t = `start` on; returns false if the ray does not come near the tree. */
static inline bool mesh_query_begin(struct mesh_query *q, struct trace *trace, double start,
                                    bool any)
{
    if (!mesh_box_make(&q->box, trace->ray, trace->accel->extent, trace->grow, trace->accel->mixed,
                       start))
        return false;
    q->mesh = NULL;
    q->several = trace->accel->prims->mesh_count > 1;
    q->count = 0;
    q->limit = mesh_box_depth(&q->box, any ? trace->shadow->tmax : trace->best.t);
    q->after = any || trace->after.t == 0 ? -INFINITY : mesh_box_depth(&q->box, trace->after.t);
    trace->meshes = q;
    return true;
}

/* Lowers the limit to the nearest intersection. */
static inline void mesh_query_narrow(const struct trace *trace)
{
    struct mesh_query *q = trace->meshes;
    const float depth = mesh_box_depth(&q->box, trace->best.t);
    q->limit = depth < q->limit ? depth : q->limit;
}

/* Prepares the ray for the mesh of a block. */
static __attribute__((noinline)) void mesh_query_enter(const struct trace *trace, uint32_t prim,
                                                       bool any)
{
    struct mesh_query *q = trace->meshes;
    const struct pen_prims *prims = trace->accel->prims;
    const struct pen_mesh *mesh = prims->mesh_count == 1 ? prims->mesh : pen_prim_mesh(prims, prim);
    const struct pen_mesh_frame *frame = &trace->accel->mesh_frames[mesh - prims->mesh];
    q->mesh = mesh;
    mesh_ray_make(&q->ray, mesh, frame, &q->box, (float)(4 * (trace->slack + trace->light_bound)));
    if (!any)
        return;
    const double depth = trace->shadow->tmax * q->box.scale - q->box.moved;
    q->ray.limit = pen_float_up(depth * frame->inv_unit - q->ray.moved);
    q->opaque = true;
    for (uint32_t i = 0; trace->shadow->see_through && i < mesh->slots; i++)
        q->opaque = q->opaque && !trace->shadow->see_through[mesh->slot + i];
}

/* The corners of a lane, as the scene has them: none is so small that it counts as 0 (see
 * pack_meshes.c). */
static inline void mesh_lane(const struct pen_accel *accel, const struct pen_mesh *mesh,
                             const struct pen_mesh4 *b, uint32_t lane, double4 v[3])
{
    const double unit = accel->mesh_frames[mesh - accel->prims->mesh].unit;
    const double4 *shift = (const double4 *)&mesh->shift.x;
    for (int i = 0; i < 3; i++) {
        const double4 f = {(double)b->v[i][0][lane], (double)b->v[i][1][lane],
                           (double)b->v[i][2][lane], 0};
        v[i] = unit * f + *shift;
    }
}

/* Whether an edge passes within the slack of the ray's origin; as edge_passes_origin4. */
static inline bool edge_passes_origin(const struct trace *trace, struct pen_sheared a,
                                      struct pen_sheared b)
{
    const double size = fabs(b.x - a.x) + fabs(b.y - a.y);
    return fabs(a.x * b.y - a.y * b.x) <= 16 * trace->slack * size;
}

/* The exact test of a lane whose inside the line enters, for a ray from free space. */
static inline bool mesh_offer_root(struct trace *trace, uint32_t prim, const double4 v[3], bool any)
{
    double t;
    if (!mesh_facet_root(v, trace->ray, &t))
        return test_reference(trace, prim, any);
    return t > 0 && offer(trace, prim, t, PEN_PART_SIDE, any);
}

static inline struct pen_sheared mesh_shear(const struct pen_ray *ray, const double4 *v)
{
    const struct pen_vec3 w = pen_vec3((*v)[0], (*v)[1], (*v)[2]);
    return pen_shear(ray, &w);
}

/* The exact test of a lane that may be met. */
static __attribute__((noinline)) bool
mesh_test_exactly(struct trace *trace, const struct pen_mesh4 *b, uint32_t lane, bool any)
{
    const struct pen_mesh *mesh = trace->meshes->mesh;
    const uint32_t prim = b->prim[lane];
    double4 v[3];
    mesh_lane(trace->accel, mesh, b, lane, v);
    const struct pen_sheared x = mesh_shear(trace->ray, &v[0]), y = mesh_shear(trace->ray, &v[1]),
                             z = mesh_shear(trace->ray, &v[2]);
    if (trace->reaches_origin &&
        (edge_passes_origin(trace, x, y) || edge_passes_origin(trace, y, z) ||
         edge_passes_origin(trace, z, x)))
        return test_reference(trace, prim, any);
    const double w = pen_edge(x, y), u = pen_edge(y, z), s = pen_edge(z, x);
    if (pen_edge_counts(x, y, w) + pen_edge_counts(y, z, u) + pen_edge_counts(z, x, s) == 0)
        return false;
    if (!trace->from_surface)
        return mesh_offer_root(trace, prim, v, any);
    struct pen_triangle tri;
    pen_mesh_triangle(mesh, prim - mesh->first, &tri);
    return offer_outline(trace, prim, &tri.facet, tri.v, 3, any);
}

/* Drops candidates that are beyond the limit; returns whether there is room for another one. */
static inline bool mesh_query_room(struct mesh_query *q)
{
    int kept = 0;
    if (q->count < MESH_CANDIDATES)
        return true;
    for (int i = 0; i < q->count; i++)
        if (q->candidate[i].least <= q->limit)
            q->candidate[kept++] = q->candidate[i];
    q->count = kept;
    return kept < MESH_CANDIDATES;
}

/* Tests the lanes of blocks, from number `block` on, for the nearest intersection. */
static inline void mesh_keep_lanes(struct trace *trace, uint32_t block, const struct mesh_lanes *in)
{
    struct mesh_query *q = trace->meshes;
    for (unsigned may = in->may; may; may &= may - 1) {
        const uint32_t bit = (uint32_t)__builtin_ctz(may), lane = bit % 4;
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[block + bit / 4];
        const float least = in->lo[bit], most = in->hi[bit];
        if (b->prim[lane] == trace->origin->prim || least > q->limit)
            continue;
        if (!(in->sure >> bit & 1) || !mesh_query_room(q)) {
            mesh_test_exactly(trace, b, lane, false);
            mesh_query_narrow(trace);
            continue;
        }
        if (most < q->limit && least > q->after)
            q->limit = most;
        q->candidate[q->count++] = (struct mesh_candidate){least, 4 * block + bit};
    }
}

/* Tests the lanes of blocks, from number `block` on, for any intersection. Returns the number of
 * the block that ends the query, or UINT32_MAX. */
static inline uint32_t mesh_block_ending(struct trace *trace, uint32_t block,
                                         const struct mesh_lanes *in)
{
    for (unsigned may = in->may; may; may &= may - 1) {
        const uint32_t bit = (uint32_t)__builtin_ctz(may), number = block + bit / 4, lane = bit % 4;
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[number];
        if (b->prim[lane] == trace->origin->prim)
            continue;
        if (trace->meshes->opaque && in->sure >> bit & 1) {
            trace->shadow->last_occluder = b->prim[lane];
            return number;
        }
        if (mesh_test_exactly(trace, b, lane, true))
            return number;
    }
    return UINT32_MAX;
}

/* Counts the triangles of blocks first to last, as if they had been tested one after the other. */
static inline void mesh_count(const struct trace *trace, uint32_t first, uint32_t last)
{
    for (; first <= last; first++)
        for (int lane = 0; lane < PEN_LANES; lane++)
            trace->accel->counts->primitives +=
                trace->accel->mesh_blocks[first].prim[lane] != PEN_NO_PRIM;
}

/* Tests blocks `block` to `last`. Returns true if an intersection ended the query. */
static inline __attribute__((always_inline)) bool
mesh_test_blocks(struct trace *trace, uint32_t block, uint32_t last, bool any)
{
    struct mesh_query *q = trace->meshes;
    const struct pen_mesh4 *blocks = trace->accel->mesh_blocks;
    if (!q->mesh)
        mesh_query_enter(trace, blocks[block].prim[0], any);
    while (block <= last) {
        const struct pen_mesh4 *b = &blocks[block];
        struct mesh_lanes in;
        bool two = MESH_BLOCKS == 2 && block < last;
        if (q->several) {
            if (b->prim[0] - q->mesh->first >= q->mesh->count)
                mesh_query_enter(trace, b->prim[0], any);
            two = two && b[1].prim[0] - q->mesh->first < q->mesh->count;
        }
        mesh_ray_test(&q->ray, b, b + two, q->limit, any, &in);
        in.may &= two ? 255 : 15;
        const uint32_t end = any && in.may ? mesh_block_ending(trace, block, &in) : UINT32_MAX;
        if (COUNTING)
            mesh_count(trace, block, end < block + two ? end : block + two);
        if (end != UINT32_MAX)
            return true;
        if (!any && in.may)
            mesh_keep_lanes(trace, block, &in);
        block += 1 + (uint32_t)two;
    }
    return false;
}

/* Ends a query for the nearest intersection: tests the candidates that are left. The last one is
 * the most likely to be the nearest. */
static inline void mesh_query_finish(struct trace *trace)
{
    const struct mesh_query *q = trace->meshes;
    for (int i = q->count - 1; i >= 0; i--) {
        const struct mesh_candidate *c = &q->candidate[i];
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[c->lane / 4];
        double4 v[3];
        if (c->least > q->limit)
            continue;
        const struct pen_mesh *mesh = q->mesh;
        if (b->prim[0] - mesh->first >= mesh->count)
            mesh = pen_prim_mesh(trace->accel->prims, b->prim[0]);
        mesh_lane(trace->accel, mesh, b, c->lane % 4, v);
        mesh_offer_root(trace, b->prim[c->lane % 4], v, false);
        mesh_query_narrow(trace);
    }
}

#endif

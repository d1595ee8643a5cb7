/* SPDX-License-Identifier: MIT */
/* Meshes in a query. A block's lanes are tested in binary32 with bounds (mesh_ray.h). Lanes that
 * are sure to be met narrow the query, and are tested exactly at its end, if they are still of use.
 * Other lanes that may be met are tested exactly at once. The exact test reads the block, whose
 * floats become the same doubles as the scene's, and computes the facet again. */
#ifndef PEN_ACCEL_INTERNAL_MESH_QUERY_H
#define PEN_ACCEL_INTERNAL_MESH_QUERY_H

#include "accel/internal/mesh_ray.h"
#include "geom/triangle_plane.h"

/* A lane that the ray is sure to enter. */
struct mesh_candidate {
    double least; /* a lower bound of its t */
    uint32_t block;
    int lane;
};

enum { MESH_CANDIDATES = 16 };

struct mesh_query {
    const struct pen_mesh *mesh; /* that of the last block; NULL: none yet */
    bool opaque;                 /* it transmits no light */
    double off;                  /* for mesh_ray_make */
    double most;                 /* nearest: an upper bound of t of the nearest intersection */
    float limit;                 /* the largest depth that matters, for that mesh */
    int count;
    struct mesh_ray ray; /* for that mesh */
    struct mesh_candidate candidate[MESH_CANDIDATES];
};

static inline void mesh_query_begin(struct mesh_query *q, struct trace *trace)
{
    q->mesh = NULL;
    q->count = 0;
    q->most = INFINITY;
    q->off = 4 * (trace->slack + trace->light_bound);
    trace->meshes = q;
}

/* The largest t that matters to a query for the nearest intersection. */
static inline double mesh_query_end(const struct trace *trace)
{
    const double most = trace->meshes->most;
    return most < trace->best.t ? most : trace->best.t;
}

/* Sets the limit. */
static inline void mesh_query_narrow(struct trace *trace, bool any)
{
    struct mesh_query *q = trace->meshes;
    const double end = any ? trace->shadow->tmax : mesh_query_end(trace);
    if (q->mesh)
        q->limit = pen_float_up(end * q->ray.scale - q->ray.moved);
}

/* Prepares the ray for the mesh of a block. */
static __attribute__((noinline)) void mesh_query_enter(struct trace *trace, uint32_t prim, bool any)
{
    struct mesh_query *q = trace->meshes;
    const struct pen_prims *prims = trace->accel->prims;
    const struct pen_mesh *mesh = prims->mesh_count == 1 ? prims->mesh : pen_prim_mesh(prims, prim);
    q->mesh = mesh;
    q->opaque = true;
    for (uint32_t i = 0; trace->shadow && trace->shadow->see_through && i < mesh->slots; i++)
        q->opaque = q->opaque && !trace->shadow->see_through[mesh->slot + i];
    mesh_ray_make(&q->ray, mesh, &trace->accel->mesh_frames[mesh - prims->mesh], trace->ray,
                  q->off);
    mesh_query_narrow(trace, any);
}

/* The corners of a lane, as the scene has them. */
static inline void mesh_lane(const struct pen_accel *accel, const struct pen_mesh *mesh,
                             const struct pen_mesh4 *b, int lane, struct pen_vec3 v[3])
{
    const double unit = accel->mesh_frames[mesh - accel->prims->mesh].unit;
    for (int i = 0; i < 3; i++)
        v[i] = pen_without_less(pen_vec3(fma(unit, (double)b->v[i][0][lane], mesh->shift.x),
                                         fma(unit, (double)b->v[i][1][lane], mesh->shift.y),
                                         fma(unit, (double)b->v[i][2][lane], mesh->shift.z)),
                                PEN_LEAST);
}

/* Whether an edge passes within the slack of the ray's origin; as edge_passes_origin4. */
static inline bool edge_passes_origin(const struct trace *trace, struct pen_sheared a,
                                      struct pen_sheared b)
{
    const double size = fabs(b.x - a.x) + fabs(b.y - a.y);
    return fabs(a.x * b.y - a.y * b.x) <= 16 * trace->slack * size;
}

/* The exact test of a lane whose inside the line enters, for a ray from free space. */
static inline bool mesh_offer_root(struct trace *trace, uint32_t prim, const struct pen_vec3 v[3],
                                   bool any)
{
    double t;
    if (!pen_triangle_plane_root(v, trace->ray, &t))
        return test_reference(trace, prim, any);
    return t > 0 && offer(trace, prim, t, PEN_PART_SIDE, any);
}

/* The exact test of a lane that may be met. */
static __attribute__((noinline)) bool
mesh_test_exactly(struct trace *trace, const struct pen_mesh4 *b, int lane, bool any)
{
    const struct pen_mesh *mesh = trace->meshes->mesh;
    const uint32_t prim = b->prim[lane];
    struct pen_triangle tri;
    mesh_lane(trace->accel, mesh, b, lane, tri.v);
    const struct pen_sheared x = pen_shear(trace->ray, &tri.v[0]),
                             y = pen_shear(trace->ray, &tri.v[1]),
                             z = pen_shear(trace->ray, &tri.v[2]);
    if (trace->reaches_origin &&
        (edge_passes_origin(trace, x, y) || edge_passes_origin(trace, y, z) ||
         edge_passes_origin(trace, z, x)))
        return test_reference(trace, prim, any);
    const double w = pen_edge(x, y), u = pen_edge(y, z), s = pen_edge(z, x);
    if (pen_edge_counts(x, y, w) + pen_edge_counts(y, z, u) + pen_edge_counts(z, x, s) == 0)
        return false;
    if (!trace->from_surface)
        return mesh_offer_root(trace, prim, tri.v, any);
    pen_mesh_triangle(mesh, prim - mesh->first, &tri);
    return offer_outline(trace, prim, &tri.facet, tri.v, 3, any);
}

/* Drops candidates that are beyond the end; returns whether there is room for another one. */
static inline bool mesh_query_room(struct trace *trace)
{
    struct mesh_query *q = trace->meshes;
    const double end = mesh_query_end(trace);
    int kept = 0;
    for (int i = 0; q->count == MESH_CANDIDATES && i < q->count; i++)
        if (q->candidate[i].least <= end)
            q->candidate[kept++] = q->candidate[i];
    if (q->count == MESH_CANDIDATES)
        q->count = kept;
    return q->count < MESH_CANDIDATES;
}

/* Tests the lanes of blocks, from number `block` on, for the nearest intersection. */
static inline void mesh_keep_lanes(struct trace *trace, uint32_t block, const struct mesh_lanes *in)
{
    struct mesh_query *q = trace->meshes;
    for (unsigned may = in->may; may; may &= may - 1) {
        const uint32_t bit = (uint32_t)__builtin_ctz(may), number = block + bit / 4;
        const int lane = (int)bit % 4;
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[number];
        const double least = ((double)in->lo[bit] + q->ray.moved) * q->ray.inv_scale,
                     most = ((double)in->hi[bit] + q->ray.moved) * q->ray.inv_scale;
        if (b->prim[lane] == trace->origin->prim || least > mesh_query_end(trace))
            continue;
        if (!(in->sure >> bit & 1) || !mesh_query_room(trace)) {
            mesh_test_exactly(trace, b, lane, false);
            mesh_query_narrow(trace, false);
            continue;
        }
        if (least > trace->after.t && most < q->most) {
            q->most = most;
            mesh_query_narrow(trace, false);
        }
        q->candidate[q->count++] = (struct mesh_candidate){least, number, lane};
    }
}

/* Tests the lanes of blocks, from number `block` on, for any intersection. Returns the number of
 * the block that ends the query, or UINT32_MAX. */
static inline uint32_t mesh_block_ending(struct trace *trace, uint32_t block,
                                         const struct mesh_lanes *in)
{
    for (unsigned may = in->may; may; may &= may - 1) {
        const uint32_t bit = (uint32_t)__builtin_ctz(may), number = block + bit / 4;
        const int lane = (int)bit % 4;
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[number];
        if (b->prim[lane] == trace->origin->prim)
            continue;
        if (trace->meshes->opaque && in->before >> bit & 1) {
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
static inline bool mesh_test_blocks(struct trace *trace, uint32_t block, uint32_t last, bool any)
{
    struct mesh_query *q = trace->meshes;
    while (block <= last) {
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[block];
        struct mesh_lanes in;
        if (!q->mesh || b->prim[0] - q->mesh->first >= q->mesh->count)
            mesh_query_enter(trace, b->prim[0], any);
        const bool two =
            MESH_BLOCKS == 2 && block < last && b[1].prim[0] - q->mesh->first < q->mesh->count;
        if (!q->ray.misses)
            mesh_ray_test(&q->ray, b, b + two, q->limit, &in);
        else
            in.may = 0;
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

/* Ends a query for the nearest intersection: tests the candidates that are left. */
static inline void mesh_query_finish(struct trace *trace)
{
    const struct mesh_query *q = trace->meshes;
    for (int i = 0; i < q->count; i++) {
        const struct mesh_candidate *c = &q->candidate[i];
        const struct pen_mesh4 *b = &trace->accel->mesh_blocks[c->block];
        struct pen_vec3 v[3];
        if (c->least > mesh_query_end(trace))
            continue;
        const struct pen_mesh *mesh = q->mesh;
        if (b->prim[0] - mesh->first >= mesh->count)
            mesh = pen_prim_mesh(trace->accel->prims, b->prim[0]);
        mesh_lane(trace->accel, mesh, b, c->lane, v);
        mesh_offer_root(trace, b->prim[c->lane], v, false);
    }
}

#endif

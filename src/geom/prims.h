/* SPDX-License-Identifier: MIT */
/* The primitives of a frozen scene: one typed array per kind, in the local frame (coordinates about
 * 1). A primitive's number is its place in the document, depth first; it decides ties.
 *
 * geom/kind.h lists the kinds. The header of a kind holds its struct, its constructor, and its hot
 * functions, static inline. These are the intersections with a ray's line, projection of a computed
 * hit point on the surface, and bounds. src/geom/README.md states the conventions, the numerics and
 * the self-intersection rule, which pen_prim_intersect applies. */
#ifndef PEN_GEOM_PRIMS_H
#define PEN_GEOM_PRIMS_H

#include <stdint.h>

#include "geom/cone.h"
#include "geom/cylinder.h"
#include "geom/infinite_cylinder.h"
#include "geom/kind.h"
#include "geom/mesh.h"
#include "geom/plane.h"
#include "geom/polygon.h"
#include "geom/ray.h"
#include "geom/sphere.h"
#include "geom/triangle.h"
#include "math/box.h"

/* Where a primitive is stored. The triangles of meshes are not stored. Their indices follow those
 * of the stored triangles, mesh by mesh. */
struct pen_prim_ref {
    uint32_t kind : 4; /* enum pen_prim_kind */
    uint32_t index : 28;
};

/* All primitives of a scene.
 *
 * What is the same for all triangles of a mesh of one material is stored once. So the primitives
 * have slots: a primitive outside meshes has one, and a mesh has one for each of its materials.
 * Slots have the order of the numbers, and arrays of data by primitive are arrays by slot. Without
 * meshes, a primitive's slot is its number.
 * Owns: nothing; the arrays belong to the scene's arena. */
struct pen_prims {
    uint32_t count;
    uint32_t mesh_count;
    const struct pen_mesh *mesh;    /* in the order of their numbers; none is empty */
    const struct pen_prim_ref *ref; /* by slot; not used for meshes */
    union {                         /* the array of each kind: by name, or by enum pen_prim_kind */
        struct {
#define KIND(NAME, name, ...) const struct pen_##name *name;
            PEN_KINDS(KIND)
#undef KIND
        };
        const void *array[PEN_PRIM_KIND_COUNT];
    };
    uint32_t kind_count[PEN_PRIM_KIND_COUNT]; /* of stored primitives */
};

#define KIND(NAME, name, ...)                                                                      \
    _Static_assert(offsetof(struct pen_prims, name) ==                                             \
                       offsetof(struct pen_prims, array) + PEN_PRIM_##NAME * sizeof(void *),       \
                   "both views of the arrays agree");
PEN_KINDS(KIND)
#undef KIND

/* The last mesh whose numbers begin at `prim` or before it; NULL if there is none. */
const struct pen_mesh *pen_mesh_before(const struct pen_prims *prims, uint32_t prim);

/* Sets *n, the unit normal at p towards the viewer, to the shading normal there: the unit vector
 * along the mix of the unit normals of the triangle's corners, by p's barycentric coordinates, on
 * the side of *n. *n stays if a corner has no normal or one of length 0, and if the mix is zero or
 * perpendicular to *n. Returns false if the primitive is in no mesh with normals. */
bool pen_prim_shading_normal(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p,
                             struct pen_vec3 *n);

/* The functions below, for scenes with meshes. */
uint32_t pen_mesh_slot_of_prim(const struct pen_prims *prims, uint32_t prim);
struct pen_prim_ref pen_mesh_ref_of_prim(const struct pen_prims *prims, uint32_t prim);
const struct pen_triangle *pen_mesh_triangle_of_index(const struct pen_prims *prims, uint32_t index,
                                                      struct pen_triangle *room);

/* The mesh of a primitive; NULL if it is in none. */
static inline const struct pen_mesh *pen_prim_mesh(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_mesh *mesh = prims->mesh_count ? pen_mesh_before(prims, prim) : NULL;
    return mesh && prim - mesh->first < mesh->count ? mesh : NULL;
}

/* The slot of a primitive. */
static inline uint32_t pen_prim_slot(const struct pen_prims *prims, uint32_t prim)
{
    return prims->mesh_count ? pen_mesh_slot_of_prim(prims, prim) : prim;
}

/* The number of slots. */
static inline uint32_t pen_prim_slots(const struct pen_prims *prims)
{
    return prims->count ? pen_prim_slot(prims, prims->count) : 0;
}

/* Where a primitive is stored. */
static inline struct pen_prim_ref pen_prim_ref(const struct pen_prims *prims, uint32_t prim)
{
    return prims->mesh_count ? pen_mesh_ref_of_prim(prims, prim) : prims->ref[prim];
}

/* Its enum pen_prim_kind. */
static inline uint32_t pen_prim_kind(const struct pen_prims *prims, uint32_t prim)
{
    return pen_prim_ref(prims, prim).kind;
}

/* The triangle of this index. One of a mesh is made in `room`. */
static inline const struct pen_triangle *
pen_prim_triangle(const struct pen_prims *prims, uint32_t index, struct pen_triangle *room)
{
    if (!prims->mesh_count || index < prims->kind_count[PEN_PRIM_TRIANGLE])
        return &prims->triangle[index];
    return pen_mesh_triangle_of_index(prims, index, room);
}

/* The table's row for a primitive. */
static inline const struct pen_kind *pen_prim_row(const struct pen_prims *prims, uint32_t prim)
{
    return &pen_kinds[pen_prim_kind(prims, prim)];
}

/* The primitive itself, a struct of its kind. A triangle of a mesh is made in `room`, which must
 * live as long as the result is used. */
static inline const void *pen_prim_self(const struct pen_prims *prims, uint32_t prim,
                                        struct pen_triangle *room)
{
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    if (ref.kind == PEN_PRIM_TRIANGLE)
        return pen_prim_triangle(prims, ref.index, room);
    return (const char *)prims->array[ref.kind] + ref.index * pen_kinds[ref.kind].bytes;
}

/* The outline of a primitive; empty if it has none. `room` as above. */
static inline struct pen_outline pen_prim_outline(const struct pen_prims *prims, uint32_t prim,
                                                  struct pen_triangle *room)
{
    const struct pen_mesh *mesh = pen_prim_mesh(prims, prim);
    const struct pen_kind_functions *fn = pen_prim_row(prims, prim)->fn;
    if (!fn->outline)
        return (struct pen_outline){NULL, 0, 0};
    if (mesh)
        pen_mesh_outline(mesh, prim - mesh->first, room);
    return fn->outline(mesh ? room : pen_prim_self(prims, prim, room));
}

/* The polygon, if the primitive is a polygon that is cut into triangles; else NULL. */
static inline const struct pen_polygon *pen_prim_cut(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    if (ref.kind != PEN_PRIM_POLYGON || !prims->polygon[ref.index].piece)
        return NULL;
    return &prims->polygon[ref.index];
}

/* All intersections of the ray's line with primitive `prim`, for a ray that starts in free space.
 */
void pen_prim_intersect_line(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, struct pen_intersections *out);

/* The parts of a round primitive that p lies on, up to `bound` and the primitive's own rounding, as
 * bits 1 << part. */
unsigned pen_prim_touches(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p,
                          double bound);

/* All intersections of the ray with primitive `prim`, without those that the self-intersection rule
 * drops. This is the reference: every accelerator must agree with it bit for bit. */
void pen_prim_intersect(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin, struct pen_intersections *out);

/* Outward unit normal at a point of the surface. */
struct pen_vec3 pen_prim_normal(const struct pen_prims *prims, struct pen_hit hit,
                                struct pen_vec3 p);

/* The same for shading a point that is seen along d: at the apex of a cone, the normal of the side
 * that faces the viewer. */
struct pen_vec3 pen_prim_normal_seen(const struct pen_prims *prims, struct pen_hit hit,
                                     struct pen_vec3 p, struct pen_vec3 d);

/* The hit point: o + t d, projected onto the surface. */
struct pen_vec3 pen_prim_point(const struct pen_prims *prims, struct pen_hit hit,
                               const struct pen_ray *ray);

/* Moves p, the point of a hit, to the border of its outline if it is outside; o is the ray's
 * origin. A line that is seen to pass just inside, within the rounding of ray space, may meet the
 * plane outside the outline. The distance is that rounding over the sine of the angle between line
 * and plane. Only needed where |sine| < PEN_POINT_STEEP; above that, the bounds allow for it. */
struct pen_vec3 pen_prim_point_in_outline(const struct pen_prims *prims, struct pen_hit hit,
                                          struct pen_vec3 o, struct pen_vec3 p, double sine);

#define PEN_POINT_STEEP 0.125

/* Bounds in double precision. If any ray has an intersection at t, o + t d lies inside them to
 * within a relative error of 2^-24 of t. Only for finite kinds. */
struct pen_box pen_prim_bounds(const struct pen_prims *prims, uint32_t prim);

/* The length that is proportional to the primitive's own rounding near p. */
double pen_prim_scale(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p);

/* The curvature of a surface at p: 1 over its radius there; 0 where it is flat, INFINITY at an
 * apex. */
static inline double pen_prim_curvature(const struct pen_prims *prims, struct pen_hit hit,
                                        struct pen_vec3 p)
{
    struct pen_triangle room;
    if (pen_prim_flat(pen_prim_kind(prims, hit.prim)))
        return 0;
    return pen_prim_row(prims, hit.prim)
        ->fn->curvature(pen_prim_self(prims, hit.prim, &room), hit.part, p);
}

/* The rounding bound for rays that start at p: 16u (|p|_1 + pen_prim_scale). */
double pen_prim_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p);

/* The origin surface of a ray that starts at p and continues on the side from which `ray` arrived.
 * p is the point of `hit`, and `ray` itself started on `left`.
 *  - toward, before: from p back to the starts of rays of the path. `before` is of the last ray
 *    that went farther than rounding reaches, else of the longest, because a long ray decides sides
 *    best.
 *  - bound: before its projection, p = o + t d misses its surface by the rounding of the sum. It
 *    may miss other surfaces there by the same distance. 16u covers the products, t and the sum. If
 *    the ray has hardly moved, p is also off by the bound of o. */
static inline struct pen_origin_surface pen_origin_at(const struct pen_prims *prims,
                                                      const struct pen_ray *ray,
                                                      const struct pen_origin_surface *left,
                                                      struct pen_hit hit, struct pen_vec3 p)
{
    struct pen_origin_surface origin = {.prim = hit.prim,
                                        .part = hit.part,
                                        .toward_bound = left->toward_bound,
                                        .before_bound = left->before_bound,
                                        .bound = pen_prim_rounding(prims, hit.prim, p)};
    double nearby = PEN_NEARBY * left->bound;
    origin.bound += 16 * PEN_U * pen_norm1(ray->o);
    if (hit.t * hit.t <= nearby * nearby * ray->inv_dd) {
        origin.bound += left->bound;
    }
    const struct pen_vec3 back = pen_sub(ray->o, p);
    origin.before = pen_add(left->before, back);
    if (hit.t > PEN_LAST_LAYER_T) {
        origin.toward = back;
        origin.toward_bound = left->bound;
        if (pen_norm1(left->toward) > nearby || pen_norm1(left->toward) > pen_norm1(left->before)) {
            origin.before = pen_add(left->toward, back);
            origin.before_bound = left->toward_bound;
        }
    } else {
        origin.toward = pen_add(left->toward, back);
    }
    return origin;
}

/* The side of the surface at p, the point of `hit`, that is seen along v, as the sign of a product
 * with its outward normal. If v runs along the surface within rounding, it is the side on which the
 * path began. `origin` is the origin surface of rays from p. */
double pen_prim_viewer_side(const struct pen_prims *prims, struct pen_hit hit, struct pen_vec3 p,
                            struct pen_vec3 v, const struct pen_origin_surface *origin);

/* Whether two intersections of a ray, a before b, are one place where two surfaces coincide, so
 * that they are layers. `bound` is the rounding of a's point. */
bool pen_prim_layers(const struct pen_prims *prims, const struct pen_ray *ray, struct pen_hit a,
                     struct pen_hit b, double bound);

/* The largest t at which an intersection can be a layer of a. */
double pen_prim_layers_end(const struct pen_prims *prims, const struct pen_ray *ray,
                           struct pen_hit a, double bound);

/* Whether two parts of primitives, hit.part, coincide somewhere. May be true for parts that do not,
 * but is false for flat outlines that are neighbours. */
bool pen_prim_may_coincide(const struct pen_prims *prims, struct pen_hit a, struct pen_hit b);

/* Whether an intersection is the ray's point at t_end, up to `bound` and the intersection's own
 * rounding. A ray that ends in a light does not count the surface that contains the light. An
 * intersection that counts at the ray's origin never is its end. So a ray from a wall's foot along
 * the floor is stopped there, even if the light is on the floor. */
bool pen_prim_ends_ray(const struct pen_prims *prims, struct pen_hit hit, const struct pen_ray *ray,
                       double t_end, double bound);

#endif

/* SPDX-License-Identifier: MIT */
/* Closed and open surfaces to shoot at, and ways of counting what a ray meets. */
#ifndef TESTS_PROPERTY_PRIMITIVES_H
#define TESTS_PROPERTY_PRIMITIVES_H

#include "property/row.h"
#include "support/world.h"

/* A folded sheet of triangles, squares, concave Ls and other polygons that share all corners:
 * [0, 12] x [0, 8] as seen from above. bodies_sheet_point is the corner at (x, y), multiples of a
 * half. */
void bodies_sheet(struct world *w, struct random *r, struct pen_vec3 at);
struct pen_vec3 bodies_sheet_point(double x, double y, struct pen_vec3 at);

/* Crossings with t > 0 of a ray from free space, over all primitives; -1 for no ray. The nearest
 * goes to *first (prim PEN_NO_PRIM without one). */
int bodies_crossings(const struct world *w, struct pen_vec3 o, struct pen_vec3 d,
                     struct pen_hit *first);

/* A world with its trees; the same arrays, built once. */
struct bodies_tree {
    struct pen_arena *arena;
    const struct pen_accel *accel;
};

/* Builds; frees what was there before. The first by the surface-area heuristic. */
void bodies_plant(struct bodies_tree *tree, const struct pen_prims *prims);
void bodies_plant_kind(struct bodies_tree *tree, const struct pen_prims *prims,
                       enum pen_accelerator kind);

/* The nearest intersection by the tree; *alike: whether both compiled variants say the same. */
struct pen_hit bodies_nearest(const struct bodies_tree *tree, const struct pen_ray *ray,
                              const struct pen_origin_surface *origin, double tmax, bool *alike);

/* How many intersections the ray has by the tree, walked from one to the next; at most `most`. */
int bodies_walk(const struct bodies_tree *tree, const struct pen_ray *ray, int most);

/* More triangles than a world holds. */
struct bodies_mesh {
    struct pen_prims prims;
    struct pen_triangle *triangle;
    struct pen_prim_ref *ref;
};
void bodies_mesh_begin(struct bodies_mesh *mesh, uint32_t capacity);
void bodies_mesh_end(struct bodies_mesh *mesh);
/* Triangles without area are left out. */
void bodies_mesh_add(struct bodies_mesh *mesh, struct pen_vec3 a, struct pen_vec3 b,
                     struct pen_vec3 c);
/* n x n squares of a square grid, split one way or the other: point (i, j) is at(i, j). */
typedef struct pen_vec3 bodies_grid_fn(double i, double j, const void *user);
void bodies_mesh_grid(struct bodies_mesh *mesh, int n, bodies_grid_fn *at, const void *user);

/* The ray of a case from argument `at` on; false for none. */
bool bodies_ray(const struct row_case *c, int at, struct pen_ray *ray);

/* Fails unless a count of intersections is what is wanted. */
void bodies_require(struct row_verdict *v, int count, int wanted);

#endif

/* SPDX-License-Identifier: MIT */
/* Closed and open surfaces to shoot at, and ways of counting what a ray meets. */
#ifndef TESTS_PROPERTY_PRIMITIVES_H
#define TESTS_PROPERTY_PRIMITIVES_H

#include "property/row.h"
#include "support/world.h"

/* A folded sheet of triangles, squares, concave Ls and other polygons that share all corners:
 * [0, 12] x [0, 8] as seen from above. primitives_sheet_point is the corner at (x, y), multiples of
 * a half. */
void primitives_sheet(struct world *w, struct random *r, struct pen_vec3 at);
struct pen_vec3 primitives_sheet_point(double x, double y, struct pen_vec3 at);

/* Intersections with t > 0 of a ray from free space, over all primitives; -1 for no ray. The
 * nearest goes to *first (prim PEN_NO_PRIM without one). */
int primitives_intersections(const struct world *w, struct pen_vec3 o, struct pen_vec3 d,
                             struct pen_hit *first);

/* A world with its trees; the same arrays, built once. */
struct primitives_tree {
    struct pen_arena *arena;
    const struct pen_accel *accel;
};

/* Builds; frees what was there before. The first by the surface-area heuristic. */
void primitives_build(struct primitives_tree *tree, const struct pen_prims *prims);
void primitives_build_kind(struct primitives_tree *tree, const struct pen_prims *prims,
                           enum pen_accelerator kind);

/* The nearest intersection by the tree; *alike: whether all instruction sets say the same. */
struct pen_hit primitives_nearest(const struct primitives_tree *tree, const struct pen_ray *ray,
                                  const struct pen_origin_surface *origin, double tmax,
                                  bool *alike);

/* How many intersections the ray has by the tree, walked from one to the next; at most `most`. */
int primitives_walk(const struct primitives_tree *tree, const struct pen_ray *ray, int most);

/* More triangles than a world holds. */
struct primitives_mesh {
    struct pen_prims prims;
    struct pen_triangle *triangle;
    struct pen_prim_ref *ref;
};
void primitives_mesh_begin(struct primitives_mesh *mesh, uint32_t capacity);
void primitives_mesh_end(struct primitives_mesh *mesh);
/* Triangles without area are left out. */
void primitives_mesh_add(struct primitives_mesh *mesh, struct pen_vec3 a, struct pen_vec3 b,
                         struct pen_vec3 c);
/* n x n squares of a square grid, split one way or the other: point (i, j) is at(i, j). */
typedef struct pen_vec3 primitives_grid_fn(double i, double j, const void *user);
void primitives_mesh_grid(struct primitives_mesh *mesh, int n, primitives_grid_fn *at,
                          const void *user);

/* The ray of a case from argument `at` on; false for none. */
bool primitives_ray(const struct row_case *c, int at, struct pen_ray *ray);

/* Fails unless a count of intersections is what is wanted. */
void primitives_require(struct row_verdict *v, int count, int wanted);

#endif

/* SPDX-License-Identifier: MIT */
/* Closed and open surfaces to shoot at, and ways to count intersections. */
#ifndef TESTS_PROPERTY_PRIMITIVES_H
#define TESTS_PROPERTY_PRIMITIVES_H

#include "property/row.h"
#include "support/world.h"

/* A folded sheet of triangles, squares, concave Ls and other polygons that share all corners:
 * [0, 12] x [0, 8] as seen from above. primitives_sheet_point is the corner at (x, y), multiples of
 * a half. */
void primitives_sheet(struct world *w, struct random *r, struct pen_vec3 at);
struct pen_vec3 primitives_sheet_point(double x, double y, struct pen_vec3 at);

/* Counts intersections with t > 0 of a ray from free space, over all primitives; -1 for no ray.
 * *first is the nearest (prim PEN_NO_PRIM if there is none). */
int primitives_intersections(const struct world *w, struct pen_vec3 o, struct pen_vec3 d,
                             struct pen_hit *first);

/* A world with its trees; the same arrays, built once. */
struct primitives_tree {
    struct pen_arena *arena;
    const struct pen_accel *accel;
};

/* Builds the trees, the first by the surface-area heuristic; frees the former ones. */
void primitives_build(struct primitives_tree *tree, const struct pen_prims *prims);
void primitives_build_kind(struct primitives_tree *tree, const struct pen_prims *prims,
                           enum pen_accelerator kind);

/* Finds the nearest intersection by the tree. *alike: all instruction sets give the same. */
struct pen_hit primitives_nearest(const struct primitives_tree *tree, const struct pen_ray *ray,
                                  const struct pen_origin_surface *origin, double tmax,
                                  bool *alike);

/* Counts the ray's intersections by the tree, walking from one to the next; at most `most`. */
int primitives_walk(const struct primitives_tree *tree, const struct pen_ray *ray, int most);

/* A mesh of more triangles than a world has. */
struct primitives_mesh {
    struct pen_prims prims;
    struct pen_triangle *triangle;
    struct pen_prim_ref *ref;
};
void primitives_mesh_begin(struct primitives_mesh *mesh, uint32_t capacity);
void primitives_mesh_end(struct primitives_mesh *mesh);
/* Adds a triangle, unless it has no area. */
void primitives_mesh_add(struct primitives_mesh *mesh, struct pen_vec3 a, struct pen_vec3 b,
                         struct pen_vec3 c);
/* n x n squares of a square grid, split one way or the other: point (i, j) is at(i, j). */
typedef struct pen_vec3 primitives_grid_fn(double i, double j, const void *user);
void primitives_mesh_grid(struct primitives_mesh *mesh, int n, primitives_grid_fn *at,
                          const void *user);

/* Reads the ray of a case from argument `at` on; returns false if it is none. */
bool primitives_ray(const struct row_case *c, int at, struct pen_ray *ray);

/* Fails unless a count of intersections is the wanted count. */
void primitives_require(struct row_verdict *v, int count, int wanted);

#endif

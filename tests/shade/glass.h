/* SPDX-License-Identifier: MIT */
/* A bench for rays in glass: solids, and a screen that shows where a ray ends. In one channel the
 * screen's emission is a gradient from 0 to 1, in another it is 1. The ratio of both is the place,
 * for any part of the light that passes the glass. The second channel is this part. */
#ifndef TESTS_SHADE_GLASS_H
#define TESTS_SHADE_GLASS_H

#include <math.h>

#include <check.h>

#include "shade/optics.h"
#include "support/kit.h"
#include "support/random.h"

struct glass_screen {
    struct pen_vec3 point, n, along; /* along: unit, in the screen */
    double width;
};

/* Where a ray meets the screen, measured from its point along `along`, and the part of the
 * light. */
struct landing {
    double at, weight;
    struct pen_ray_counts rays;
};

static inline struct pen_material glass_of(double ior)
{
    struct pen_material m = kit_matte(0);
    m.kt = pen_vec3(1, 1, 1);
    m.ior = ior;
    return m;
}

static inline int glass_material(struct kit *kit, double ior)
{
    return kit_material(kit, glass_of(ior));
}

/* Begins an empty bench in the dark; paths have at most `surfaces` surfaces. */
static inline void glass_begin(struct kit *kit, int surfaces)
{
    kit_init(kit);
    kit->settings.max_depth = surfaces;
    kit->settings.min_contribution = 0;
}

static inline void glass_look(struct kit *kit, struct pen_vec3 eye, struct pen_vec3 direction)
{
    const bool steep = fabs(direction.y) > 0.9 * pen_length(direction);
    kit->view.camera.position = eye;
    kit->view.camera.direction = direction;
    kit->view.camera.up = steep ? pen_vec3(1, 0, 0) : pen_vec3(0, 1, 0);
}

static inline struct pen_vec3 glass_beside(struct random *r, struct pen_vec3 n)
{
    return pen_normalize(pen_cross(n, random_direction(r)));
}

/* Adds a screen; a scene may have one. */
static inline struct pen_object_desc *glass_add_screen(struct kit *kit,
                                                       const struct glass_screen *screen)
{
    static struct pen_pattern pattern;
    static struct pen_patterns patterns;
    pattern = (struct pen_pattern){.a = {0, 1, 0}, .b = {1, 1, 0}};
    pattern.from = pen_along(screen->point, screen->along, -screen->width);
    pattern.to = pen_along(screen->point, screen->along, screen->width);
    patterns = (struct pen_patterns){.of = {&pattern}};
    struct pen_material m = kit_glow(0.5, 1, 0);
    m.patterns = &patterns;
    return kit_plane(kit, screen->point, screen->n, kit_material(kit, m));
}

/* Returns where the pixel's ray meets the screen, which is already in the scene. */
static inline struct landing glass_landed(struct kit *kit, const struct glass_screen *screen)
{
    struct landing l;
    const struct pen_vec3 c = kit_pixel(kit, 0, 0, &l.rays);
    l.at = (2 * c.x / c.y - 1) * screen->width;
    l.weight = c.y;
    return l;
}

/* Adds the screen, renders the pixel, and takes the screen away again. */
static inline struct landing glass_land(struct kit *kit, const struct glass_screen *screen)
{
    glass_add_screen(kit, screen);
    const struct landing l = glass_landed(kit, screen);
    kit->desc.object_count--;
    kit->desc.primitive_count--;
    kit->desc.material_count--;
    return l;
}

/* Returns where a ray ends by the equations. */
static inline double glass_truth(const struct glass_screen *screen, const struct quad_ray *ray)
{
    const struct quad3 point = quad3(screen->point);
    const quad t = quad_plane(point, quad3(screen->n), ray);
    const struct quad3 end = quad_sub(quad_along(ray->o, ray->d, t), point);
    return (double)quad_dot(end, quad3(screen->along));
}

/* Adds a solid whose faces are lists of vertex numbers. A negative number ends a face, two end the
 * list. Also makes the same solid in 113 bits, if asked for. */
static inline void glass_solid(struct kit *kit, const struct pen_vec3 *v, const int *faces,
                               struct pen_vec3 inner, int material, struct convex *truth)
{
    if (truth)
        truth->count = 0;
    while (*faces >= 0) {
        struct pen_vec3 corner[8];
        uint32_t count = 0;
        for (; *faces >= 0; faces++)
            corner[count++] = v[*faces];
        faces++;
        kit_polygon(kit, corner, count, material);
        if (truth)
            convex_add(truth, corner, inner);
    }
}

/* A box around a centre, with half-edges along three axes. */
static inline void glass_box(struct kit *kit, struct pen_vec3 centre, const struct pen_vec3 half[3],
                             int material, struct convex *truth)
{
    static const int faces[] = {0, 1, 3, 2,  -1, 4, 6, 7, 5,  -1, 0, 4, 5, 1,  -1, 2,
                                3, 7, 6, -1, 0,  2, 6, 4, -1, 1,  5, 7, 3, -1, -1};
    struct pen_vec3 v[8];
    for (int i = 0; i < 8; i++) {
        v[i] = centre;
        for (int k = 0; k < 3; k++)
            v[i] = pen_along(v[i], half[k], i >> k & 1 ? 1 : -1);
    }
    glass_solid(kit, v, faces, centre, material, truth);
}

/* Three axes at right angles, of unit length, in any orientation. */
static inline void glass_axes(struct random *r, struct pen_vec3 axis[3])
{
    axis[0] = random_direction(r);
    axis[1] = glass_beside(r, axis[0]);
    axis[2] = pen_cross(axis[0], axis[1]);
}

#endif

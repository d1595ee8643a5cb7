/* SPDX-License-Identifier: MIT */
/* Evaluates patterns. */
#include "shade/internal/patterns.h"

/* A point in an object's own coordinates, and the rounding of each. */
struct own_point {
    double at[3], off[3];
};

static struct own_point own_point(const struct pen_own_space *space, struct pen_vec3 p,
                                  double bound)
{
    struct own_point own;
    for (int i = 0; i < 3; i++) {
        const double *m = space->from_local.m[i];
        own.at[i] = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
        own.off[i] = space->reach[i] * bound + space->rounding[i];
    }
    return own;
}

/* Whether p is in a cell of colour b. A coordinate within its rounding of a cell's boundary belongs
 * to the upper cell. So a face along the cells' boundaries has one colour. */
static bool in_odd_cell(const struct pen_pattern *pattern, const struct own_point *p)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        const double cell = floor((p->at[i] + p->off[i]) / pattern->size);
        sum += cell - 2 * floor(0.5 * cell);
    }
    return sum == 1 || sum == 3;
}

/* The position between `from` and `to`: 0 at `from` and before it, 1 at `to` and beyond. */
static double share_of_way(const struct pen_pattern *pattern, const struct own_point *p)
{
    const struct pen_vec3 way = pen_sub(pattern->to, pattern->from);
    const struct pen_vec3 gone = pen_sub(pen_vec3(p->at[0], p->at[1], p->at[2]), pattern->from);
    const double share = pen_dot(gone, way) / pen_dot(way, way);
    return share > 0 ? (share < 1 ? share : 1) : 0;
}

static struct pen_vec3 colour_at(const struct pen_pattern *pattern, const struct own_point *p)
{
    if (pattern->checker)
        return in_odd_cell(pattern, p) ? pattern->b : pattern->a;
    const double share = share_of_way(pattern, p);
    if (share >= 1)
        return pattern->b;
    return pen_along(pattern->a, pen_sub(pattern->b, pattern->a), share);
}

struct pen_material pen_material_at(const struct pen_scene *scene, uint32_t prim, struct pen_vec3 p,
                                    double bound)
{
    struct pen_material m = *pen_scene_material(scene, prim);
    if (!m.patterns)
        return m;
    const struct own_point own = own_point(
        &scene->own_spaces[scene->prim_space[pen_prim_slot(&scene->prims, prim)]], p, bound);
    for (int i = 0; i < PEN_MATERIAL_COLOURS; i++)
        if (m.patterns->of[i])
            *pen_material_colour(&m, i) = colour_at(m.patterns->of[i], &own);
    return m;
}

struct pen_vec3 pen_filter_at(const struct pen_scene *scene, const struct pen_ray *ray,
                              const struct pen_origin_surface *origin, struct pen_hit hit)
{
    const struct pen_material *m = pen_scene_material(scene, hit.prim);
    if (!m->patterns || !m->patterns->of[PEN_COLOUR_KT])
        return m->kt;
    const struct pen_vec3 p = pen_prim_point(&scene->prims, hit, ray);
    const double bound = pen_origin_at(&scene->prims, ray, origin, hit, p).bound;
    return pen_material_at(scene, hit.prim, p, bound).kt;
}

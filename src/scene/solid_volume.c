/* SPDX-License-Identifier: MIT */
#include "scene/internal/solid_volume.h"

#include <math.h>
#include <string.h>

#include "scene/internal/vec.h"

static const double PI = 3.141592653589793;

/* The volume of a sphere, a cylinder or a cone. */
static double round_volume(enum pen_prim_kind kind, const double length[PEN_LENGTHS])
{
    const double r = length[PEN_RADIUS], top = length[PEN_TOP_RADIUS], h = length[PEN_HEIGHT];
    if (kind == PEN_PRIM_SPHERE)
        return 4 * PI / 3 * r * r * r;
    if (kind == PEN_PRIM_CYLINDER)
        return PI * h * r * r;
    return PI / 3 * h * (r * r + r * top + top * top);
}

/* Six times the contribution of a loop to the volume of a body: tetrahedra from a point to a fan of
 * its triangles. */
static double loop_volume(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 from)
{
    const struct pen_vec3 a = pen_sub(v[0], from);
    double sum = 0;
    for (uint32_t i = 1; i + 1 < count; i++)
        sum += pen_dot(a, pen_cross(pen_sub(v[i], from), pen_sub(v[i + 1], from)));
    return sum;
}

/* The factor by which a map increases volumes. */
static double growth(const struct pen_transform *f)
{
    const struct pen_vec3 x = pen_vec3(f->m[0][0], f->m[1][0], f->m[2][0]);
    const struct pen_vec3 y = pen_vec3(f->m[0][1], f->m[1][1], f->m[2][1]);
    const struct pen_vec3 z = pen_vec3(f->m[0][2], f->m[1][2], f->m[2][2]);
    return fabs(pen_dot(x, pen_cross(y, z)));
}

void pen_solid_volume_add(struct solid_volume *volume, const struct pen_scene_prim *prim,
                          bool turned)
{
    const struct pen_transform identity = pen_transform_identity();
    const struct pen_transform *moved_by = prim->moved_by ? prim->moved_by : &identity;
    const uint32_t count = prim->from.count;
    if (!pen_prim_outlined(prim->kind)) {
        volume->round = round_volume(prim->kind, prim->from.length);
        return;
    }
    if (!volume->begun) {
        volume->begun = true;
        volume->from = prim->own[0];
        volume->moved_from = prim->from.vertices[0];
        volume->moved_by = *moved_by;
    }
    volume->mixed = volume->mixed || memcmp(moved_by, &volume->moved_by, sizeof *moved_by) != 0;
    /* A mirror has reversed the order of the vertices, so that the outside stays outside. */
    const double side = turned ? -1 : 1;
    volume->own += side * loop_volume(prim->own, count, volume->from);
    volume->moved += side * loop_volume(prim->from.vertices, count, volume->moved_from);
}

double pen_solid_volume(const struct solid_volume *volume)
{
    if (!volume->begun)
        return volume->round;
    if (volume->mixed)
        return fabs(volume->moved) / 6;
    return fabs(volume->own) / 6 * growth(&volume->moved_by);
}

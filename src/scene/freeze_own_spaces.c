/* SPDX-License-Identifier: MIT */
/* The own coordinates of patterned primitives: the inverse of the transforms of the enclosing
 * groups, after the local frame. Consecutive primitives with the same transforms share one space.
 */
#include <string.h>

#include "math/exact.h"
#include "scene/internal/freeze.h"

struct spaces {
    uint32_t *of_slot;
    struct pen_own_space *space; /* NULL while they are counted */
    struct pen_transform last;   /* the transform of the last space */
    uint32_t slot, count;
};

static struct pen_vec3 column_of(const struct pen_transform *f, int j)
{
    return pen_vec3(f->m[0][j], f->m[1][j], f->m[2][j]);
}

/* Row i of the inverse of a map's linear part: perpendicular to the other two columns, and 1 along
 * column i. */
static struct pen_vec3 inverse_row(const struct pen_transform *f, int i)
{
    const struct pen_vec3 axis = pen_vec3(i == 0, i == 1, i == 2);
    const struct pen_vec3 across = pen_transform_normal(f, axis);
    return pen_scale(across, 1 / pen_dot2(across, column_of(f, i)));
}

/* p_own = inverse (center + 2^exponent p_local - moved). The sums of the offset are compensated but
 * rounded once each. center and `moved` are as exact as the document's numbers; 8u of their sizes
 * covers that. The products and sums of a point are covered by 4u |row| |p|, which is within the
 * point's own bound of at least 16u |p|. Twice the bound covers both. */
static struct pen_own_space space_of(const struct pen_freezer *f, const struct pen_transform *moved)
{
    struct pen_own_space s;
    const struct pen_vec3 by = column_of(moved, 3), offset = pen_sub(f->frame.center, by);
    const double size = pen_norm1(f->frame.center) + pen_norm1(by);
    for (int i = 0; i < 3; i++) {
        const struct pen_vec3 row = inverse_row(moved, i);
        const double local = pen_scale2(1, f->frame.exponent);
        s.from_local.m[i][0] = row.x * local;
        s.from_local.m[i][1] = row.y * local;
        s.from_local.m[i][2] = row.z * local;
        s.from_local.m[i][3] = pen_dot2(row, offset);
        s.reach[i] = 2 * pen_norm1(row) * local;
        s.rounding[i] = 8 * PEN_U * pen_norm1(row) * size;
    }
    return s;
}

static void add_slot(struct pen_freezer *f, const struct pen_scene_prim *scene_prim,
                     struct spaces *a)
{
    const struct pen_transform identity = pen_transform_identity();
    const struct pen_transform *moved = scene_prim->moved_by ? scene_prim->moved_by : &identity;
    const uint32_t slot = a->slot++;
    const struct pen_patterns *patterns =
        f->scene->materials[f->scene->prim_material[slot]].patterns;
    if (!patterns)
        return;
    f->scene->patterned_glass = f->scene->patterned_glass || patterns->of[PEN_COLOUR_KT];
    if (a->count == 0 || memcmp(moved, &a->last, sizeof *moved) != 0) {
        a->last = *moved;
        a->count++;
        if (a->space)
            a->space[a->count - 1] = space_of(f, moved);
    }
    if (a->space)
        a->of_slot[slot] = a->count - 1;
}

static bool add_primitive(struct pen_freezer *f, const struct pen_scene_prim *scene_prim,
                          void *user)
{
    const uint32_t slots = scene_prim->mesh ? scene_prim->mesh->material_count : 1;
    for (uint32_t i = 0; i < slots; i++)
        add_slot(f, scene_prim, user);
    return true;
}

static bool has_patterns(const struct pen_scene *scene)
{
    for (uint32_t i = 0; i < pen_prim_slots(&scene->prims); i++)
        if (scene->materials[scene->prim_material[i]].patterns)
            return true;
    return false;
}

bool pen_freeze_own_spaces(struct pen_freezer *f)
{
    struct pen_scene *scene = f->scene;
    struct spaces counted = {0}, a = {0};
    if (!has_patterns(scene))
        return true;
    if (!pen_freeze_each(f, add_primitive, &counted))
        return false;
    a.of_slot = pen_arena_alloc(scene->arena, pen_prim_slots(&scene->prims), sizeof *a.of_slot);
    a.space = pen_arena_alloc(scene->arena, counted.count, sizeof *a.space);
    if (!a.of_slot || !a.space)
        return pen_freeze_no_memory(f);
    if (!pen_freeze_each(f, add_primitive, &a))
        return false;
    scene->prim_space = a.of_slot;
    scene->own_spaces = a.space;
    return true;
}

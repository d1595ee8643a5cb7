/* SPDX-License-Identifier: MIT */
/* Finds the solids that contain the eyes of the views, and those that may contain points of their
 * lenses. */
#include "scene/internal/freeze.h"
#include "scene/solid.h"

/* An eye is on a surface if steps in these directions, of this part of the coordinates, do not all
 * lead to the same side of the surface. There is one direction in each octant, and none is along a
 * plane that is common in scenes. */
enum { STEPS = 8 };
static const struct pen_vec3 direction[STEPS] = {
    {0.5377, 0.7193, 0.4397},   {-0.4397, 0.5377, 0.7193},  {0.7193, -0.4397, 0.5377},
    {0.5377, 0.4397, -0.7193},  {-0.7193, -0.5377, 0.4397}, {-0.5377, 0.7193, -0.4397},
    {0.4397, -0.7193, -0.5377}, {-0.7193, -0.4397, -0.5377}};
static const double STEP = 0x1p-36;

/* A step contains this many u of the coordinates in the document, so that rounding leaves a part of
 * it. */
static const double ROUNDINGS = 32;

static bool overlaps_ball(const struct pen_box *b, struct pen_vec3 c, double r)
{
    return b->lo.x <= c.x + r && b->hi.x >= c.x - r && b->lo.y <= c.y + r && b->hi.y >= c.y - r &&
           b->lo.z <= c.z + r && b->hi.z >= c.z - r;
}

static double extent(const struct pen_box *b)
{
    return pen_norm1(pen_sub(b->hi, b->lo));
}

/* The step for an eye within one step of the box of a solid; 0 for any other eye. */
static double step_at(const struct pen_freezer *f, uint32_t solid, struct pen_vec3 eye)
{
    const struct pen_box *box = &f->scene->solids.at[solid].box;
    const double document =
        pen_norm1(f->frame.center) + pen_scale2(pen_norm1(eye), f->frame.exponent);
    const double step = STEP * (pen_norm1(eye) + extent(box)) +
                        ROUNDINGS * PEN_U * pen_scale2(document, -f->frame.exponent);
    return overlaps_ball(box, eye, step) ? step : 0;
}

/* The steps of an eye that lead into a solid, as bits. */
static unsigned steps_into(const struct pen_scene *scene, uint32_t solid, struct pen_vec3 eye,
                           double step)
{
    unsigned in = 0;
    for (int k = 0; k < STEPS; k++)
        in |= (unsigned)pen_solid_contains(&scene->prims, &scene->solids, solid,
                                           pen_along(eye, direction[k], step))
              << k;
    return in;
}

/* Moves an eye that is exactly on surfaces of solids off them, to the outside of all if possible.
 * Then each ray of the camera starts on the side of them that is recorded for the eye. */
static void leave_surfaces(const struct pen_freezer *f, struct pen_scene_view *view)
{
    const struct pen_vec3 eye = pen_local_point(&f->frame, view->frame.eye);
    unsigned inside = 0;
    double farthest = 0;
    for (uint32_t i = 0; i < f->scene->solids.count; i++) {
        const double step = step_at(f, i, eye);
        const unsigned in = step > 0 ? steps_into(f->scene, i, eye, step) : 0;
        if (in == 0 || in == (1U << STEPS) - 1)
            continue;
        inside |= in;
        farthest = pen_larger(farthest, step);
    }
    if (inside == 0)
        return;
    int k = 0;
    while (k + 1 < STEPS && inside >> k & 1)
        k++;
    view->frame.eye =
        pen_along(view->frame.eye, direction[k], pen_scale2(farthest, f->frame.exponent));
}

static bool find_view(const struct pen_freezer *f, struct pen_scene_view *view)
{
    const struct pen_scene *scene = f->scene;
    const struct pen_solids *solids = &scene->solids;
    uint32_t *list[2];
    for (int i = 0; i < 2; i++)
        if (!(list[i] = pen_arena_alloc(scene->arena, solids->count, sizeof *list[i])))
            return false;
    leave_surfaces(f, view);
    const struct pen_vec3 eye = pen_local_point(&f->frame, view->frame.eye);
    const double lens = pen_local_length(&f->frame, view->camera.aperture_radius);
    for (uint32_t i = 0; i < solids->count; i++) {
        if (!overlaps_ball(&solids->at[i].box, eye, lens))
            continue;
        if (lens > 0 && solids->at[i].closed)
            list[1][view->maybe.count++] = i;
        else if (pen_solid_contains(&scene->prims, solids, i, eye))
            list[0][view->inside.count++] = i;
    }
    view->inside.solid = list[0];
    view->maybe.solid = list[1];
    return true;
}

bool pen_freeze_eyes(struct pen_freezer *f)
{
    for (uint32_t i = 0; i < f->scene->view_count; i++)
        if (!find_view(f, &f->views[i]))
            return false;
    return true;
}

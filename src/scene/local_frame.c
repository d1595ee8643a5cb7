/* SPDX-License-Identifier: MIT */
/* The local frame is computed from two separate parts: the bounds of the anchor points of
 * primitives (centres, bases, vertices), and the largest of their radii and heights. A sum of the
 * two for each primitive would round differently when a scene is moved, and the frame would not
 * move with it. */
#include "scene/internal/local_frame.h"

#include "scene/internal/vec.h"

struct pen_prim_summary pen_prim_summary_empty(void)
{
    return (struct pen_prim_summary){.finite = pen_box_empty(), .infinite = pen_box_empty()};
}

void pen_prim_summary_add(struct pen_prim_summary *summary, const struct pen_scene_prim *scene_prim)
{
    const struct pen_prim_source *from = &scene_prim->from;
    summary->kind_count[scene_prim->kind]++;
    summary->total++;
    summary->slots++;
    if (pen_kinds[scene_prim->kind].fn->keeps_vertices)
        summary->kept_vertices += from->count;
    double reach = pen_larger(from->length[PEN_RADIUS], from->length[PEN_TOP_RADIUS]) +
                   from->length[PEN_HEIGHT];
    if (pen_prim_infinite(scene_prim->kind)) {
        summary->infinite = pen_box_add_point(summary->infinite, from->point);
        summary->infinite_reach = pen_larger(summary->infinite_reach, reach);
        return;
    }
    summary->finite_reach = pen_larger(summary->finite_reach, reach);
    if (from->count == 0)
        summary->finite = pen_box_add_point(summary->finite, from->point);
    for (uint32_t i = 0; i < from->count; i++)
        summary->finite = pen_box_add_point(summary->finite, from->vertices[i]);
}

/* The multiple of 2^exponent nearest to x. Halves are rounded upward. Unlike rounding to even, the
 * result moves with x when x moves by any multiple. */
static double nearest_multiple(double x, int exponent)
{
    double steps = pen_scale2(x, -exponent);
    if (!(fabs(steps) < 0x1p52))
        return x; /* x is a multiple */
    double low = floor(steps);
    return pen_scale2(steps - low >= 0.5 ? low + 1 : low, exponent);
}

bool pen_local_frame_make(const struct pen_prim_summary *summary,
                          const struct pen_camera_frame *cameras, uint32_t camera_count,
                          struct pen_local_frame *frame)
{
    struct pen_box box = summary->finite;
    double reach = summary->finite_reach;
    if (!(box.lo.x <= box.hi.x)) {
        box = summary->infinite;
        reach = summary->infinite_reach;
        for (uint32_t i = 0; i < camera_count; i++)
            box = pen_box_add_point(box, cameras[i].eye);
    }
    double extent = vec_max_abs(pen_sub(box.hi, box.lo)) + 2 * reach;
    if (extent == 0)
        extent = pen_larger(vec_max_abs(box.lo), 1);
    if (!isfinite(extent))
        return false;
    struct pen_vec3 middle = pen_box_center(box);
    frame->exponent = pen_exponent(extent);
    frame->center = pen_vec3(nearest_multiple(middle.x, frame->exponent),
                             nearest_multiple(middle.y, frame->exponent),
                             nearest_multiple(middle.z, frame->exponent));
    return true;
}

struct pen_vec3 pen_local_point(const struct pen_local_frame *frame, struct pen_vec3 p)
{
    return vec_scale2_down(pen_sub(p, frame->center), frame->exponent);
}

double pen_local_length(const struct pen_local_frame *frame, double length)
{
    return pen_scale2(length, -frame->exponent);
}

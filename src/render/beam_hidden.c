/* SPDX-License-Identifier: MIT */
/* Things that no beam meets because a primitive is in front of them.
 *
 * A primitive hides the bounds of a thing if it is convex and opaque, and is the first that the
 * rays to their corners meet. These rays start at the eye, or at the corners of the part of the
 * lens from which the bounds are seen. The rays of a point that meet a convex body are a convex
 * cone, and so are the lines from it back to the lens. So all rays of the beam between these rays
 * meet the body. The farthest point of a convex body that is seen through a rectangle is seen at a
 * corner. So the body is in front of the thing if it is so at the corners. */
#include <fenv.h>
#include <math.h>
#include <stdatomic.h>

#include "render/internal/beam_bounds.h"
#include "render/internal/kernel_input.h"

/* Whether a primitive is convex and opaque. */
static bool is_screen(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_prims *prims = &scene->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    if (pen_scene_see_through(scene, prim))
        return false;
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
    case PEN_PRIM_PLANE:
    case PEN_PRIM_TRIANGLE:
    case PEN_PRIM_INFINITE_CYLINDER:
        return true;
    case PEN_PRIM_POLYGON:
        return prims->polygon[ref.index].convex;
    case PEN_PRIM_CYLINDER:
        return prims->cylinder[ref.index].caps;
    case PEN_PRIM_CONE:
        return prims->cone[ref.index].hull.caps;
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return false;
}

/* Whether a ray comes to a primitive from outside. From inside a convex body, the farthest point is
 * not at the corners. */
static bool is_outside(const struct pen_prims *prims, struct pen_hit hit, const struct pen_ray *ray)
{
    const struct pen_vec3 p = pen_prim_point(prims, hit, ray);
    return pen_prim_flat(pen_prim_kind(prims, hit.prim)) ||
           pen_dot(pen_prim_normal(prims, hit, p), ray->d) < 0;
}

/* The first primitive on the ray through a point of the image and of the lens, and its depth in
 * lengths of the pinhole's `middle`. Returns false if it cannot hide anything. */
static bool first_on(const struct pen_kernel_input *input, struct pen_point2 at,
                     struct pen_point2 lens, uint32_t *prim, double *depth)
{
    const struct pen_pinhole *p = &input->pinhole;
    const struct pen_t_interval all = {pen_after_start, INFINITY};
    struct pen_vec3 o = p->eye, d = pen_along(pen_along(p->middle, p->dx, at.x - p->half_width),
                                              p->dy, at.y - p->half_height);
    struct pen_ray ray;
    struct pen_hit hit;
    if (input->lens.open) {
        const struct pen_vec3 aside =
            pen_along(pen_scale(input->lens.right, lens.x), input->lens.up, lens.y);
        o = pen_add(o, aside);
        d = pen_sub(pen_scale(d, input->lens.focus), aside);
    }
    if (!pen_ray_make(&ray, o, d) ||
        !input->trace->nearest(input->scene->accel, &ray, &pen_origin_none, &all, &hit) ||
        !is_screen(input->scene, hit.prim) || !is_outside(&input->scene->prims, hit, &ray))
        return false;
    *prim = hit.prim;
    *depth = hit.t * (input->lens.open ? input->lens.focus : 1);
    return true;
}

float pen_beam_depth(const struct pen_kernel_input *input, struct pen_box box)
{
    static const double room = 1 - 1e-6;
    const struct pen_vec3 middle = input->pinhole.middle;
    const struct pen_box b = {pen_sub(box.lo, input->pinhole.eye),
                              pen_sub(box.hi, input->pinhole.eye)};
    const double least = pen_smaller(b.lo.x * middle.x, b.hi.x * middle.x) +
                         pen_smaller(b.lo.y * middle.y, b.hi.y * middle.y) +
                         pen_smaller(b.lo.z * middle.z, b.hi.z * middle.z);
    return (float)(room * least / pen_dot(middle, middle));
}

/* The depth of a primitive that hides all of the bounds, which begin at pixel (x, y); INFINITY if
 * none does. */
static double hidden_from(const struct pen_kernel_input *input, const struct bounds *b, int x,
                          int y)
{
    uint32_t screen = PEN_NO_PRIM, prim;
    double most = 0, depth;
    for (int i = 0; i < (input->lens.open ? 16 : 4); i++) {
        const struct pen_point2 lens = {i & 4 ? b->lens_hi.x : b->lens_lo.x,
                                        i & 8 ? b->lens_hi.y : b->lens_lo.y};
        const double u = i & 1, v = i >> 1 & 1;
        const struct pen_point2 at = {
            x + b->corner.x + u * b->a.x + v * b->b.x + b->shear.x * lens.x,
            y + b->corner.y + u * b->a.y + v * b->b.y + b->shear.y * lens.y};
        if (!first_on(input, at, lens, &prim, &depth) || (i > 0 && prim != screen))
            return INFINITY;
        screen = prim;
        most = pen_larger(most, depth);
    }
    return most;
}

/* The work of threads, block by block. */
struct pass {
    struct pen_beams *beams;
    const struct pen_kernel_input *input;
    int across, count;
    atomic_int next;
};

/* The bounds of a whole rectangle of pixels, seen from the whole lens. */
static struct bounds whole(int side)
{
    return (struct bounds){.a = {side, 0}, .b = {0, side}, .lens_lo = {-1, -1}, .lens_hi = {1, 1}};
}

/* Removes hidden things from a pixel: those at `depth` or beyond. */
static void hide_in_pixel(const struct pass *pass, int x, int y, double depth)
{
    struct pen_beams *beams = pass->beams;
    const size_t pixel = (size_t)y * (size_t)beams->width + (size_t)x;
    const struct bounds all = whole(1);
    const uint32_t first = beams->first[pixel], end = beams->first[pixel + 1];
    if (first < end)
        depth = pen_smaller(depth, hidden_from(pass->input, &all, x, y));
    for (uint32_t i = first; i < end; i++) {
        struct bounds *b = &beams->bounds[i];
        if ((double)b->near > depth || (double)b->near > hidden_from(pass->input, b, x, y))
            b->share = 0;
    }
}

static void hide_in_block(const struct pass *pass, int left, int top)
{
    const struct pen_beams *beams = pass->beams;
    const int right = left + PEN_BLOCK_SIDE < beams->width ? left + PEN_BLOCK_SIDE : beams->width,
              end = top + PEN_BLOCK_SIDE < beams->height ? top + PEN_BLOCK_SIDE : beams->height;
    uint32_t things = 0;
    for (int y = top; y < end; y++) {
        const size_t row = (size_t)y * (size_t)beams->width;
        things += beams->first[row + (size_t)right] - beams->first[row + (size_t)left];
    }
    if (things == 0)
        return;
    const struct bounds block = whole(PEN_BLOCK_SIDE);
    const double depth = hidden_from(pass->input, &block, left, top);
    for (int y = top; y < end; y++)
        for (int x = left; x < right; x++)
            hide_in_pixel(pass, x, y, depth);
}

static void hide(void *user, int thread)
{
    struct pass *pass = user;
    fenv_t caller;
    int i;
    (void)thread;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    while ((i = atomic_fetch_add_explicit(&pass->next, 1, memory_order_relaxed)) < pass->count)
        hide_in_block(pass, i % pass->across * PEN_BLOCK_SIDE, i / pass->across * PEN_BLOCK_SIDE);
    fesetenv(&caller);
}

void pen_beam_hide(struct pen_beams *beams, const struct pen_kernel_input *input,
                   struct pen_thread_pool *pool)
{
    const int side = PEN_BLOCK_SIDE, across = (beams->width + side - 1) / side;
    struct pass pass = {.beams = beams,
                        .input = input,
                        .across = across,
                        .count = across * ((beams->height + side - 1) / side)};
    const int threads = pen_render_threads(pool, input->settings);
    pen_thread_pool_run(pool, threads < pass.count ? threads : pass.count, hide, &pass);
}

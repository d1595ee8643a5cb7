/* SPDX-License-Identifier: MIT */
/* Surfaces that close: rays aimed at vertices, edges and points of edges that are exact in binary.
 * A ray from inside a closed surface crosses it an odd number of times, and a ray from above
 * crosses a sheet once. Only the surface itself is needed to judge that. */
#include "property/gen.h"
#include "property/primitives.h"
#include "property/rows.h"

static struct world world;
static struct primitives_tree tree;
static double built[2] = {-1, -1}; /* what the world holds: scene number, offset */

typedef void make_fn(struct world *w, struct random *r, vec3 at);

static void make_once(make_fn *make, uint64_t salt, double scene, double offset)
{
    double key = scene + 0x1p32 * (double)salt;
    if (built[0] == key && built[1] == offset)
        return;
    struct random r = {(uint64_t)scene * 0x9e3779b97f4a7c15u + salt, 0};
    make(&world, &r, gen_offset3(offset));
    primitives_build(&tree, &world.prims);
    built[0] = key;
    built[1] = offset;
}

/* Cases of one scene follow each other, so that each is built once. */
static const double offsets[] = {0, 1e6, 1e9};

static void draw_scene(struct row_draw *d, struct row_case *c)
{
    uint64_t scene = d->index / 512;
    row_fixed(c, (double)scene);
    row_fixed(c, offsets[scene % 3]);
}

/* A point of an edge of the surface. */
static vec3 surface_point(struct random *r)
{
    uint32_t prim = random_below(r, world.prims.count);
    const struct pen_prim_ref ref = world.ref[prim];
    const vec3 *v = world.triangle[ref.index].v;
    uint32_t count = 3;
    if (ref.kind == PEN_PRIM_POLYGON) {
        v = world.polygon[ref.index].v;
        count = world.polygon[ref.index].count;
    }
    uint32_t i = random_below(r, count);
    return gen_on_edge(r, v[i], v[(i + 1) % count]);
}

static void draw_bumpy(struct row_draw *d, struct row_case *c)
{
    draw_scene(d, c);
    make_once(world_bumpy, 38, c->arg[0], c->arg[1]);
    vec3 at = gen_offset3(c->arg[1]);
    vec3 o = pen_along(at, random_direction(&d->random), .5);
    row_arg3(c, o);
    row_arg3(c, gen_toward(&d->random, o, surface_point(&d->random)));
}

static void require_tree_agrees(struct row_verdict *v, vec3 o, vec3 d, struct pen_hit first)
{
    struct pen_ray ray;
    bool alike;
    if (!pen_ray_make(&ray, o, d))
        return;
    struct pen_hit hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    if (!alike || hit.prim != first.prim || (hit.prim != PEN_NO_PRIM && hit.t != first.t))
        row_fail(v, "the tree meets %u, trying all meets %u", hit.prim, first.prim);
}

static void judge_bumpy(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double scene = row_next(c, &at), offset = row_next(c, &at);
    vec3 o = row_next3(c, &at), d = row_next3(c, &at);
    struct pen_hit first;
    /* Only from inside is the number odd; a smaller case may have moved out. */
    if (!(pen_length(pen_sub(o, gen_offset3(offset))) < .75)) {
        row_skip(v);
        return;
    }
    make_once(world_bumpy, 38, scene, offset);
    int count = primitives_intersections(&world, o, d, &first);
    if (count < 0) {
        row_skip(v);
        return;
    }
    row_tally(v, count == 1 ? "crossed once" : "crossed three times or more");
    if (count == 0)
        row_fail(v, "leak");
    else if (count % 2 == 0)
        row_fail(v, "%d intersections: double hit", count);
    require_tree_agrees(v, o, d, first);
}

void rows_bumpy(struct pen_row_run *run)
{
    row_each(run, draw_bumpy, judge_bumpy);
}

/* From above, over the inner part of the sheet, so that moved points stay over it. */
static void draw_sheet(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    draw_scene(d, c);
    vec3 at = gen_offset3(c->arg[1]);
    double x = 1 + random_below(r, 20) / 2., y = 1 + random_below(r, 12) / 2.;
    vec3 to = primitives_sheet_point(x, y, at);
    uint32_t along = random_below(r, 3);
    vec3 next = primitives_sheet_point(x + .5 * (along != 1), y + .5 * (along != 0), at);
    if (random_below(r, 3))
        to = pen_along(to, pen_sub(next, to),
                       random_below(r, 2) ? random_unit(r) : random_below(r, 17) / 16.);
    vec3 up = random_below(r, 4) ? random_vec(r, 3) : gen_dyadic3(r, 3);
    vec3 o = pen_add(to, pen_add(pen_vec3(0, 0, 30), up));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, gen_nudged(r, to)));
}

/* Whether the ray goes down through the sheet well within its border. */
static bool over_sheet(vec3 o, vec3 d, vec3 at)
{
    vec3 f = pen_sub(o, at);
    if (!(d.z < 0 && f.z > 10 && f.z < 100))
        return false;
    for (int i = 0; i < 2; i++) { /* at both heights that the sheet has */
        double t = (i * 4 - f.z) / d.z;
        double y = f.y + t * d.y, x = f.x + t * d.x - .125 * y;
        if (!(x > .5 && x < 11.5 && y > .5 && y < 7.5))
            return false;
    }
    return true;
}

static void judge_sheet(const struct row_case *c, struct row_verdict *v)
{
    int i = 0;
    double scene = row_next(c, &i), offset = row_next(c, &i);
    vec3 at = gen_offset3(offset), o = row_next3(c, &i), d = row_next3(c, &i);
    struct pen_hit first;
    if (!over_sheet(o, d, at)) {
        row_skip(v);
        return;
    }
    make_once(primitives_sheet, 50, scene, offset);
    int count = primitives_intersections(&world, o, d, &first);
    if (count != 1)
        row_fail(v, count ? "%d intersections: double hit" : "leak", count);
    require_tree_agrees(v, o, d, first);
}

void rows_sheet(struct pen_row_run *run)
{
    row_each(run, draw_sheet, judge_sheet);
}

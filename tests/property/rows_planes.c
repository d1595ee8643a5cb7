/* SPDX-License-Identifier: MIT */
/* The stored boxes of a structure, checked directly. Rays are tested with so much slack that a box
 * that is a little too small may hide nothing from any ray. */
#include <math.h>

#include "accel/internal/structure.h"
#include "property/gen.h"
#include "property/rows.h"
#include "support/world.h"

static struct world world;

enum { PRIMITIVES = 24 };

/* The extent of a primitive along an axis, from its definition. */
struct extent {
    long double lo, hi;
};

static struct extent extent_of_points(const vec3 *v, uint32_t count, int axis)
{
    struct extent e = {INFINITY, -INFINITY};
    for (uint32_t i = 0; i < count; i++) {
        double x = pen_component(v[i], axis);
        e.lo = x < e.lo ? x : e.lo;
        e.hi = x > e.hi ? x : e.hi;
    }
    return e;
}

/* Both discs reach r sqrt(1 - a^2) along the axis; what rounding may add to that is taken off. */
static struct extent extent_of_cylinder(const struct pen_cylinder *c, int axis)
{
    const struct pen_cylinder_side *s = &c->round;
    long double aa = 0;
    for (int k = 0; k < 3; k++)
        aa += (long double)pen_component(s->a, k) * pen_component(s->a, k);
    long double a = pen_component(s->a, axis) / sqrtl(aa), q = pen_component(s->q, axis);
    long double across = a * a < 1 ? s->r * sqrtl(1 - a * a) : 0, top = q + a * c->h;
    long double rounding = 0x1p-50L * (s->r + c->h + fabsl(q));
    return (struct extent){(q < top ? q : top) - across + rounding,
                           (q > top ? q : top) + across - rounding};
}

static struct extent extent_of(uint32_t prim, int axis)
{
    const struct pen_prim_ref ref = world.prims.ref[prim];
    const struct pen_sphere *s = &world.sphere[ref.index];
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return (struct extent){(long double)pen_component(s->c, axis) - s->r,
                               (long double)pen_component(s->c, axis) + s->r};
    case PEN_PRIM_CYLINDER:
        return extent_of_cylinder(&world.cylinder[ref.index], axis);
    case PEN_PRIM_TRIANGLE:
        return extent_of_points(world.triangle[ref.index].v, 3, axis);
    case PEN_PRIM_POLYGON:
    case PEN_PRIM_CONE: /* the scenes of these rows have no cones and nothing infinite */
    case PEN_PRIM_PLANE:
    case PEN_PRIM_INFINITE_CYLINDER:
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return extent_of_points(world.polygon[ref.index].v, world.polygon[ref.index].count, axis);
}

/* A box around a child: its planes are `step` floats apart. */
struct cover {
    const float *plane;
    int step;
};

static void judge_prim(struct row_verdict *v, struct cover box, uint32_t prim)
{
    for (int axis = 0; prim != PEN_NO_PRIM && axis < 3; axis++) {
        struct extent e = extent_of(prim, axis);
        long double lo = box.plane[axis * box.step], hi = box.plane[(axis + 3) * box.step];
        if (!(lo <= e.lo && e.hi <= hi))
            row_fail(v,
                     "axis %d of primitive %u: it reaches from %La to %La, its box from %La to %La",
                     axis, prim, e.lo, e.hi, lo, hi);
    }
}

static const uint32_t *block_prims(const struct pen_accel *a, uint32_t item)
{
    uint32_t index = PEN_ITEM_INDEX(item);
    switch (PEN_ITEM_KIND(item)) {
    case PEN_BLOCK_TRIANGLES:
        return a->triangles[index].prim;
    case PEN_BLOCK_POLYGONS:
        return a->polygons[index].prim;
    case PEN_BLOCK_SPHERES:
        return a->spheres[index].prim;
    case PEN_BLOCK_CYLINDERS:
        return a->cylinders[index].prim;
    case PEN_BLOCK_GENERIC:
        return a->generic[index].prim;
    case PEN_BLOCK_MESH: /* the rows' scenes have none */
    case PEN_BLOCK_PLANES:
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return NULL;
}

static int judge_leaf(struct row_verdict *v, const struct pen_accel *a, struct cover box,
                      uint32_t first)
{
    int seen = 0;
    for (const uint32_t *item = &a->items[first];; item++) {
        const uint32_t *prim = block_prims(a, *item);
        if (PEN_ITEM_KIND(*item) == PEN_BLOCK_SINGLE) {
            judge_prim(v, box, PEN_ITEM_INDEX(*item));
            seen++;
        }
        for (int lane = 0; prim && lane < PEN_LANES; lane++) {
            judge_prim(v, box, prim[lane]);
            seen += prim[lane] != PEN_NO_PRIM;
        }
        if (*item & PEN_ITEM_LAST)
            return seen;
    }
}

static int judge_child(struct row_verdict *v, const struct pen_accel *a, struct cover box,
                       uint32_t child);

/* All lanes of a node of a tree or a list, or of a pair. */
static int judge_node(struct row_verdict *v, const struct pen_accel *a, uint32_t number)
{
    bool pair = a->shape == PEN_SHAPE_PAIRS, more = true;
    int seen = 0, lanes = pair ? 2 : PEN_WIDE;
    for (; more; number++) {
        const float *plane = pair ? a->pairs[number].plane[0] : a->nodes[number].plane[0];
        const uint32_t *child = pair ? a->pairs[number].child : a->nodes[number].child;
        more = a->shape == PEN_SHAPE_LISTS && child[0] & PEN_CHILD_MORE;
        for (int lane = 0; lane < lanes; lane++)
            if (child[lane] != PEN_CHILD_LEAF)
                seen += judge_child(v, a, (struct cover){plane + lane, lanes}, child[lane]);
    }
    return seen;
}

static bool inside(struct cover inner, struct cover outer)
{
    for (int i = 0; i < 6; i++) {
        float a = inner.plane[i * inner.step], b = outer.plane[i * outer.step];
        if (!(i < 3 ? b <= a : a <= b))
            return false;
    }
    return true;
}

static int judge_child(struct row_verdict *v, const struct pen_accel *a, struct cover box,
                       uint32_t child)
{
    if (a->shape == PEN_SHAPE_LISTS)
        child &= ~PEN_CHILD_MORE;
    if (child & PEN_CHILD_LEAF)
        return judge_leaf(v, a, box, child & ~PEN_CHILD_LEAF);
    int lanes = a->shape == PEN_SHAPE_PAIRS ? 2 : PEN_WIDE;
    const float *plane = lanes == 2 ? a->pairs[child].plane[0] : a->nodes[child].plane[0];
    const uint32_t *inner = lanes == 2 ? a->pairs[child].child : a->nodes[child].child;
    for (int lane = 0; lane < lanes; lane++)
        if (inner[lane] != PEN_CHILD_LEAF)
            row_require(v, inside((struct cover){plane + lane, lanes}, box),
                        "a box reaches out of the one around it");
    return judge_node(v, a, child);
}

/* Arguments: what the primitives are drawn from, how far they are from the origin. */
static void draw_planes(struct row_draw *d, struct row_case *c)
{
    static const double offsets[] = {0, 1, 1e3, 1e6};
    row_fixed(c, (double)random_below(&d->random, 1u << 31));
    row_fixed(c, offsets[d->index % 4]);
}

static void add_primitive(struct random *r, vec3 at, int i)
{
    vec3 p = pen_add(at, random_vec(r, 2)), e = random_vec(r, 1), f = random_vec(r, 1);
    vec3 v[4] = {p, pen_add(p, e), pen_add(pen_add(p, e), f), pen_add(p, f)};
    switch (i % 4) {
    case 0:
        world_sphere(&world, p, random_in(r, .01, 1));
        break;
    case 1:
        world_cylinder(&world, p, i % 8 == 1 ? pen_vec3(0, 0, 1) : random_direction(r),
                       random_in(r, .01, 1), random_in(r, .01, 1), true);
        break;
    case 2:
        world_triangle(&world, v[0], v[1], v[3]);
        break;
    default:
        world_polygon(&world, v, 4);
    }
}

static void judge_planes(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double seed = row_next(c, &at), offset = row_next(c, &at);
    struct random r = {(uint64_t)seed, 0};
    vec3 away = gen_offset3(offset);
    world_clear(&world);
    for (int i = 0; i < PRIMITIVES; i++)
        add_primitive(&r, away, i);
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++) {
        struct pen_status st;
        struct pen_arena *arena = pen_arena_new(0);
        const struct pen_accel *a =
            pen_accel_build(&world.prims, (enum pen_accelerator)kind, arena, &st);
        int beside = a->list ? judge_leaf(&(struct row_verdict){.failed = false}, a,
                                          (struct cover){(const float[6]){0}, 1}, a->list)
                             : 0;
        int seen = a->shape == PEN_SHAPE_NONE ? 0 : judge_node(v, a, 0);
        row_require(v, kind == PEN_ACCEL_NONE || seen + beside == PRIMITIVES,
                    "not every primitive is in the structure once");
        pen_arena_free(arena);
    }
}

void rows_planes(struct pen_row_run *run)
{
    row_each(run, draw_planes, judge_planes);
}

/* SPDX-License-Identifier: MIT */
/* Finds the primitives that may coincide with others, so that paths look for layers only there. An
 * unnecessary pair costs time and changes no picture.
 *
 * A surface (a part of a primitive) is a box of seven dimensions: its bounds, the bounds of the
 * sizes of a direction's components, and the bounds of a size. Coincident surfaces share the
 * direction and the size. For flat surfaces these are the normal and the distance from the origin,
 * for cylinders the axis and the radius. Only surfaces of one class whose boxes overlap can
 * coincide. Sorted by size, most surfaces have few or no neighbours. In larger runs, pairs are
 * found by halving at a value: the surfaces left of it, those right of it, and in both halves those
 * that it cuts. */
#include <stdlib.h>
#include <string.h>

#include "math/scale.h"
#include "scene/internal/freeze.h"
#include "scene/internal/layers_in_mesh.h"

enum {
    DIRECTION = 3, /* the first dimension of the normal or axis */
    SIZE = 6,
    DIMENSIONS = 7,
    FEW = 16,        /* this number of surfaces is compared one by one */
    MANY = 2048,     /* more surfaces that no halving separates are assumed to coincide */
    SOME = 15,       /* a list is halved at the median of this number of its surfaces, */
    SOME_MOST = 127, /* and a long list at that of a sixteenth of them, but at most this number */
    DEPTH = 48,
    PLACES = 16 /* of one primitive: for its first partners one each, and one for all others */
};

/* Surfaces of different classes never coincide. */
enum class { FLAT, SPHERE, ROUND };

struct surface {
    double lo[DIMENSIONS], hi[DIMENSIONS];
    struct pen_hit part;
    enum class class;
    const struct pen_mesh *mesh; /* NULL: it is in none */
};

/* The begin of a surface along an axis. */
struct begin {
    enum class class;
    uint32_t surface;
    double lo;
};

/* A place in the list of its primitive. */
struct place {
    struct pen_layer_place there;
    uint32_t next;
};

static const uint32_t NO_PLACE = UINT32_MAX;

struct finder {
    const struct pen_prims *prims;
    struct pen_layers_others *others; /* what triangles of meshes may come near */
    struct surface *surface;
    uint32_t *list;      /* of surfaces */
    struct begin *begin; /* of the surfaces that are compared */
    uint32_t count;
    uint32_t *first;     /* by primitive: its first place; they are in the order of partners */
    struct place *place; /* all places that the scene will keep, and no others */
    size_t places, room, most;
    bool no_memory;
};

static double component(struct pen_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/* The sizes of a unit vector's components. */
static void bound_direction(struct surface *s, struct pen_vec3 n, double off)
{
    for (int axis = 0; axis < 3; axis++) {
        s->lo[DIRECTION + axis] = fabs(component(n, axis)) - off;
        s->hi[DIRECTION + axis] = fabs(component(n, axis)) + off;
    }
}

/* Bounds the normal, to the precision that the primitive's own size gives it. A part that lies
 * across an axis is thin along it. The distance from the origin is as uncertain as that of a point
 * of the box when the plane turns by that precision. */
static void bound_flat(struct surface *s, struct pen_vec3 n, struct pen_vec3 q, double off,
                       double reach)
{
    for (int axis = 0; axis < 3; axis++) {
        double across = component(n, (axis + 1) % 3), other = component(n, (axis + 2) % 3);
        if (fabs(across) + fabs(other) < 0x1p-50 && s->hi[axis] < INFINITY)
            s->lo[axis] = s->hi[axis] = component(q, axis);
    }
    bound_direction(s, n, off);
    double distance = fabs(pen_dot(n, q));
    s->lo[SIZE] = distance - 2 * off * reach;
    s->hi[SIZE] = distance + 2 * off * reach;
}

static const struct pen_cylinder_side *cylinder_side(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    return ref.kind == PEN_PRIM_CYLINDER            ? &prims->cylinder[ref.index].round
           : ref.kind == PEN_PRIM_INFINITE_CYLINDER ? &prims->infinite_cylinder[ref.index].round
                                                    : NULL;
}

/* Bounds the radius and the axis of a cylinder. The side of a cone has any radius, and may coincide
 * with a cylinder if it is steep. */
static void bound_round(struct surface *s, const struct pen_prims *prims, struct pen_vec3 p,
                        double off)
{
    const struct pen_cylinder_side *side = cylinder_side(prims, s->part.prim);
    uint32_t kind = pen_prim_kind(prims, s->part.prim);
    s->class = kind == PEN_PRIM_SPHERE ? SPHERE : ROUND;
    s->lo[SIZE] = -INFINITY;
    s->hi[SIZE] = INFINITY;
    if (kind == PEN_PRIM_CONE)
        return;
    double radius = 1 / pen_prim_curvature(prims, s->part, p);
    s->lo[SIZE] = radius * (1 - 0x1p-16);
    s->hi[SIZE] = radius * (1 + 0x1p-16);
    if (side)
        bound_direction(s, pen_scale(side->a, 1 / side->length), off);
}

/* Adds a surface with bounds whose margin is far above rounding, also that of rays from afar. */
static void add_surface(struct finder *f, uint32_t prim, uint8_t part)
{
    struct pen_triangle room;
    const struct pen_kind *kind = pen_prim_row(f->prims, prim);
    const void *self = pen_prim_self(f->prims, prim, &room);
    struct pen_box b = {pen_vec3(-INFINITY, -INFINITY, -INFINITY),
                        pen_vec3(INFINITY, INFINITY, INFINITY)};
    struct pen_vec3 p = pen_vec3(0, 0, 0), half = pen_vec3(1, 1, 1);
    if (!pen_prim_infinite(pen_prim_kind(f->prims, prim))) {
        b = pen_prim_bounds(f->prims, prim);
        p = pen_box_center(b);
        half = pen_sub(b.hi, p);
    }
    double rounding = 64 * pen_prim_rounding(f->prims, prim, p), margin = rounding + 0x1p-40;
    struct surface *s = &f->surface[f->count++];
    *s = (struct surface){{b.lo.x, b.lo.y, b.lo.z},
                          {b.hi.x, b.hi.y, b.hi.z, 1, 1, 1},
                          {0, prim, part},
                          FLAT,
                          pen_prim_mesh(f->prims, prim)};
    if (kind->shape == PEN_KIND_FLAT || part != PEN_PART_SIDE) {
        struct pen_vec3 q = kind->fn->project(self, part, p);
        bound_flat(s, kind->fn->normal(self, part, p), q,
                   0x1p-16 + rounding / pen_norm1(pen_sub(b.hi, b.lo)),
                   pen_norm1(q) + pen_norm1(half) + 0x1p-40);
    } else
        bound_round(s, f->prims, p, 0x1p-16 + margin / pen_norm1(half));
    for (int axis = 0; axis < DIMENSIONS; axis++) {
        s->lo[axis] -= margin;
        s->hi[axis] += margin;
    }
}

static uint8_t last_part(uint32_t kind)
{
    switch ((enum pen_prim_kind)kind) {
    case PEN_PRIM_CYLINDER:
    case PEN_PRIM_CONE:
        return PEN_PART_TOP;
    case PEN_PRIM_SPHERE:
    case PEN_PRIM_PLANE:
    case PEN_PRIM_TRIANGLE:
    case PEN_PRIM_POLYGON:
    case PEN_PRIM_INFINITE_CYLINDER:
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return PEN_PART_SIDE;
}

/* Makes room for a place. There are at most PLACES places for a primitive, and at most as many as
 * the scene has memory for. */
static bool make_room(struct finder *f)
{
    if (f->places < f->room)
        return true;
    size_t room = 2 * f->room + 64;
    room = room < f->most ? room : f->most;
    struct place *more = f->places < room ? realloc(f->place, room * sizeof *more) : NULL;
    if (!more)
        return false;
    f->place = more;
    f->room = room;
    return true;
}

/* Adds a place to the list of its primitive. Each partner has one place; those after the first
 * PLACES - 1 partners share the last one. A partner that is not among the first of those found so
 * far is not among the first of all. So the order in which pairs are found does not matter. */
static void add_place(struct finder *f, uint32_t prim, struct pen_layer_place there)
{
    uint32_t last = NO_PLACE, count = 0;
    for (uint32_t at = f->first[prim]; at != NO_PLACE; at = f->place[at].next, count++) {
        struct pen_layer_place *here = &f->place[at].there;
        if (here->partner == there.partner || count == PLACES - 1) {
            here->box = pen_box_union(here->box, there.box);
            here->partner = here->partner == there.partner ? here->partner : PEN_NO_PRIM;
            return;
        }
        if (there.partner < here->partner) {
            const struct pen_layer_place later = *here;
            *here = there;
            there = later;
        }
        last = at;
    }
    if (!make_room(f)) {
        f->no_memory = true;
        return;
    }
    *(last == NO_PLACE ? &f->first[prim] : &f->place[last].next) = (uint32_t)f->places;
    f->place[f->places++] = (struct place){there, NO_PLACE};
}

/* Adds the common box of two surfaces as a place of both primitives. */
static void mark(struct finder *f, const struct surface *a, const struct surface *b)
{
    double lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        lo[k] = pen_larger(a->lo[k], b->lo[k]);
        hi[k] = -pen_larger(-a->hi[k], -b->hi[k]);
    }
    struct pen_box common = {pen_vec3(lo[0], lo[1], lo[2]), pen_vec3(hi[0], hi[1], hi[2])};
    uint32_t p = a->part.prim, q = b->part.prim;
    add_place(f, p, (struct pen_layer_place){common, p == q ? PEN_NO_PRIM : q});
    if (p != q)
        add_place(f, q, (struct pen_layer_place){common, p});
}

static bool overlap(const struct surface *a, const struct surface *b)
{
    for (int k = 0; k < DIMENSIONS; k++)
        if (!(a->lo[k] <= b->hi[k] && b->lo[k] <= a->hi[k]))
            return false;
    const struct pen_mesh *mesh = a->mesh;
    return a->part.prim != b->part.prim && !(mesh && mesh == b->mesh);
}

static void compare_pair(struct finder *f, const struct surface *a, const struct surface *b)
{
    if (overlap(a, b) && pen_prim_may_coincide(f->prims, a->part, b->part))
        mark(f, a, b);
}

static int compare_begins(const void *a, const void *b)
{
    const struct begin *p = a, *q = b;
    if (p->class != q->class)
        return p->class < q->class ? -1 : 1;
    return (p->lo > q->lo) - (p->lo < q->lo);
}

/* Sorts a list by class and by the begins of the surfaces along an axis, into f->begin. */
static void sort_begins(struct finder *f, const uint32_t *list, uint32_t count, int axis)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct surface *s = &f->surface[list[i]];
        f->begin[i] = (struct begin){s->class, list[i], s->lo[axis]};
    }
    qsort(f->begin, count, sizeof *f->begin, compare_begins);
}

/* Compares all pairs that overlap along the first axis. */
static void compare_many(struct finder *f, const uint32_t *list, uint32_t count)
{
    sort_begins(f, list, count, 0);
    for (uint32_t i = 0; i < count; i++) {
        const struct surface *a = &f->surface[f->begin[i].surface];
        for (uint32_t k = i + 1; k < count && f->begin[k].lo <= a->hi[0]; k++)
            compare_pair(f, a, &f->surface[f->begin[k].surface]);
    }
}

/* Compares all pairs of a list. If there are too many, assumes that all coincide. */
static void compare(struct finder *f, const uint32_t *list, uint32_t count)
{
    if (count > FEW && count <= MANY) {
        compare_many(f, list, count);
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        const struct surface *s = &f->surface[list[i]];
        if (count > MANY)
            mark(f, s, s);
        for (uint32_t k = i + 1; k < count && count <= FEW; k++)
            compare_pair(f, s, &f->surface[list[k]]);
    }
}

/* The middle of a surface; 0 for a plane without end. */
static double middle(const struct surface *s, int axis)
{
    return s->hi[axis] < INFINITY ? 0.5 * s->lo[axis] + 0.5 * s->hi[axis] : 0;
}

/* The median of the middles of some of the list. */
static double median_of(const struct finder *f, const uint32_t *list, uint32_t count, int axis)
{
    double some[SOME_MOST];
    uint32_t n = count < SOME             ? count
                 : count / 16 < SOME      ? SOME
                 : count / 16 < SOME_MOST ? count / 16
                                          : SOME_MOST;
    for (uint32_t i = 0; i < n; i++) {
        double m = middle(&f->surface[list[(uint64_t)i * count / n]], axis);
        uint32_t at = i;
        for (; at > 0 && m < some[at - 1]; at--)
            some[at] = some[at - 1];
        some[at] = m;
    }
    return some[n / 2];
}

/* -1: left of the value, 1: right of it, 0: cut by it. */
static int side_of(const struct surface *s, int axis, double value)
{
    return s->hi[axis] < value ? -1 : s->lo[axis] > value;
}

/* Moves the surfaces of one side to the front and returns their number. */
static uint32_t to_front(const struct finder *f, uint32_t *list, uint32_t count, int axis,
                         double value, int side)
{
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = list[i];
        if (side_of(&f->surface[at], axis, value) == side) {
            list[i] = list[front];
            list[front++] = at;
        }
    }
    return front;
}

/* The axis whose median separates best; false if a half would keep more than three fifths. */
static bool choose_axis(const struct finder *f, const uint32_t *list, uint32_t count, int *axis,
                        double *value)
{
    uint32_t least = count - count / 5 * 2;
    bool chosen = false;
    for (int k = 0; k < DIMENSIONS; k++) {
        double median = median_of(f, list, count, k);
        uint32_t left = 0, right = 0;
        for (uint32_t i = 0; i < count; i++) {
            int side = side_of(&f->surface[list[i]], k, median);
            left += side < 0;
            right += side > 0;
        }
        uint32_t most = count - (left < right ? left : right);
        if (most < least) {
            least = most;
            *axis = k;
            *value = median;
            chosen = true;
        }
        if (least <= count / 2 + count / 16)
            break;
    }
    return chosen;
}

/* Marks all pairs of a list, which are of one class. */
static void find_pairs(struct finder *f, uint32_t *list, uint32_t count, int depth)
{
    int axis;
    double value;
    if (count <= FEW || depth == DEPTH || !choose_axis(f, list, count, &axis, &value)) {
        compare(f, list, count);
        return;
    }
    uint32_t right = to_front(f, list, count, axis, value, 1);
    find_pairs(f, list + right, count - right, depth + 1); /* left, and cut */
    uint32_t cut = to_front(f, list + right, count - right, axis, value, 0);
    find_pairs(f, list, right + cut, depth + 1);
}

/* Marks all pairs. Sorted by class and size, surfaces that may coincide are in one run of a class
 * whose sizes overlap. */
static void find_in_runs(struct finder *f)
{
    for (uint32_t i = 0; i < f->count; i++)
        f->list[i] = i;
    sort_begins(f, f->list, f->count, SIZE);
    for (uint32_t i = 0; i < f->count; i++)
        f->list[i] = f->begin[i].surface;
    for (uint32_t i = 0, end = 0; i < f->count; i = end) {
        const struct surface *first = &f->surface[f->list[i]];
        double hi = first->hi[SIZE];
        for (end = i + 1; end < f->count; end++) {
            const struct surface *s = &f->surface[f->list[end]];
            if (s->class != first->class || s->lo[SIZE] > hi)
                break;
            hi = s->hi[SIZE] > hi ? s->hi[SIZE] : hi;
        }
        if (end > i + 1)
            find_pairs(f, f->list + i, end - i, 0);
    }
}

/* Marks two equal triangles of a mesh. */
static void mark_equal(void *user, uint32_t a, uint32_t b)
{
    struct finder *f = user;
    const uint32_t count = f->count;
    add_surface(f, a, PEN_PART_SIDE);
    add_surface(f, b, PEN_PART_SIDE);
    mark(f, &f->surface[count], &f->surface[count + 1]);
    f->count = count;
}

/* Adds the surfaces of all primitives outside meshes, and of the triangles of meshes that come near
 * another primitive. Returns their number. If f->surface is NULL, only counts. */
static size_t add_surfaces(struct finder *f)
{
    const struct pen_prims *prims = f->prims;
    size_t count = 0;
    for (uint32_t i = 0, m = 0; i < prims->count; i++) {
        const struct pen_mesh *mesh = m < prims->mesh_count ? &prims->mesh[m] : NULL;
        if (mesh && i == mesh->first + mesh->count)
            mesh = ++m < prims->mesh_count ? &prims->mesh[m] : NULL;
        if (mesh && i >= mesh->first && !pen_mesh_comes_near(prims, f->others, m, i - mesh->first))
            continue;
        for (uint8_t part = 0; part <= last_part(pen_prim_kind(prims, i)); part++, count++)
            if (f->surface)
                add_surface(f, i, part);
    }
    return count;
}

static bool alloc_finder(struct finder *f)
{
    f->first = malloc(((size_t)f->prims->count + 1) * sizeof *f->first);
    f->others = pen_layers_others(f->prims);
    if (!f->first || !f->others)
        return false;
    memset(f->first, 0xff, f->prims->count * sizeof *f->first); /* NO_PLACE */
    const size_t count = add_surfaces(f);
    f->surface = malloc((count + 2) * sizeof *f->surface);
    f->list = malloc((count + 1) * sizeof *f->list);
    f->begin = malloc((count + 1) * sizeof *f->begin);
    return f->surface && f->list && f->begin;
}

static bool find(struct finder *f)
{
    for (uint32_t m = 0; m < f->prims->mesh_count; m++)
        if (!pen_mesh_find_equal(&f->prims->mesh[m], mark_equal, f))
            return false;
    add_surfaces(f);
    find_in_runs(f);
    return true;
}

/* The scene keeps the places only if there are any. */
static bool keep(struct pen_freezer *f, const struct finder *finder)
{
    const uint32_t prims = finder->prims->count;
    uint32_t count = 0;
    if (finder->places == 0)
        return true;
    uint32_t *first = pen_arena_alloc(f->scene->arena, (size_t)prims + 1, sizeof *first);
    struct pen_layer_place *place = pen_arena_alloc(f->scene->arena, finder->places, sizeof *place);
    if (!first || !place)
        return false;
    for (uint32_t i = 0; i < prims; i++) {
        first[i] = count;
        for (uint32_t at = finder->first[i]; at != NO_PLACE; at = finder->place[at].next)
            place[count++] = finder->place[at].there;
    }
    first[prims] = count;
    f->scene->layer_first = first;
    f->scene->layer_place = place;
    return true;
}

/* The number of places that the scene's memory has room for. */
static size_t places_most(const struct pen_freezer *f)
{
    const size_t left = f->cap_bytes ? f->cap_bytes - pen_arena_used(f->scene->arena) : SIZE_MAX;
    const size_t most = left / sizeof(struct pen_layer_place);
    return most < NO_PLACE ? most : NO_PLACE;
}

bool pen_freeze_layers(struct pen_freezer *f)
{
    struct finder finder = {.prims = &f->scene->prims, .most = places_most(f)};
    bool ok = alloc_finder(&finder);
    ok = ok && find(&finder) && !finder.no_memory && keep(f, &finder);
    void *own[] = {finder.surface, finder.list, finder.begin, finder.first, finder.place};
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
        free(own[i]);
    free(finder.others);
    return ok || pen_freeze_no_memory(f);
}

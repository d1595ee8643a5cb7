/* SPDX-License-Identifier: MIT */
/* Finds the solids of a scene that refracts, numbers them, and tells which of them the eyes are in.
 */
#include <stdlib.h>
#include <string.h>

#include "scene/internal/freeze.h"
#include "scene/internal/solid_faces.h"

/* A solid before it is numbered. */
struct found {
    struct pen_solid solid;
    double volume;  /* of the bounding box */
    uint32_t first; /* its first primitive */
};

struct finder {
    struct pen_scene *scene;
    uint32_t *same; /* by material: the first material that is equal */
    struct solid_face *face;
    uint32_t faces;
    struct found *found;
    uint32_t *found_of; /* by primitive: its place in `found`, or PEN_NO_SOLID */
    uint32_t *number;   /* by place in `found`: the solid's number */
    uint32_t count;
    uint8_t *turned; /* by primitive */
};

/* A material with its number, to sort materials by what they are. */
struct numbered {
    const struct pen_material *material;
    uint32_t number;
};

static int compare_patterns(const struct pen_patterns *a, const struct pen_patterns *b)
{
    const struct pen_patterns none = {{0}};
    a = a ? a : &none;
    b = b ? b : &none;
    for (int i = 0; i < PEN_MATERIAL_COLOURS; i++) {
        const struct pen_pattern *p = a->of[i], *q = b->of[i];
        if (p == q)
            continue;
        if (!p || !q)
            return p ? 1 : -1;
        if (p->checker != q->checker)
            return p->checker ? 1 : -1;
        const int numbers = memcmp(&p->a, &q->a, sizeof *p - offsetof(struct pen_pattern, a));
        if (numbers != 0)
            return numbers;
    }
    return 0;
}

static int compare_materials(const void *a, const void *b)
{
    const struct numbered *p = a, *q = b;
    const int numbers = memcmp(p->material, q->material, offsetof(struct pen_material, patterns));
    if (numbers != 0)
        return numbers;
    return compare_patterns(p->material->patterns, q->material->patterns);
}

static int compare_numbered(const void *a, const void *b)
{
    const struct numbered *p = a, *q = b;
    const int materials = compare_materials(a, b);
    return materials != 0 ? materials : (p->number > q->number) - (p->number < q->number);
}

/* Finds equal materials. */
static bool find_same(struct finder *f)
{
    const uint32_t count = f->scene->material_count;
    struct numbered *sorted = malloc(count * sizeof *sorted);
    f->same = malloc(count * sizeof *f->same);
    if (!sorted || !f->same) {
        free(sorted);
        return false;
    }
    for (uint32_t i = 0; i < count; i++)
        sorted[i] = (struct numbered){&f->scene->materials[i], i};
    qsort(sorted, count, sizeof *sorted, compare_numbered);
    for (uint32_t i = 0; i < count; i++) {
        const bool new = i == 0 || compare_materials(&sorted[i - 1], &sorted[i]) != 0;
        f->same[sorted[i].number] = new ? sorted[i].number : f->same[sorted[i - 1].number];
    }
    free(sorted);
    return true;
}

/* Whether a primitive is a solid, or a side of one. */
static bool is_solid(const struct pen_scene *scene, uint32_t prim)
{
    return scene->materials[scene->prim_material[prim]].ior != 1 &&
           !pen_prim_infinite(scene->prims.ref[prim].kind);
}

/* Adds a primitive to the solid at a place in `found`, which may be a new one. */
static void add_to_solid(struct finder *f, uint32_t prim, uint32_t place, bool closed)
{
    struct found *to = &f->found[place];
    if (place == f->count) {
        f->count++;
        *to = (struct found){.first = prim};
        to->solid.ior = f->scene->materials[f->scene->prim_material[prim]].ior;
        to->solid.box = pen_box_empty();
        to->solid.closed = closed;
    }
    to->solid.count++;
    to->solid.box = pen_box_union(to->solid.box, pen_prim_bounds(&f->scene->prims, prim));
    f->found_of[prim] = place;
}

/* Makes the solids in the order of their first primitives. */
static bool find_solids(struct finder *f)
{
    const struct pen_scene *scene = f->scene;
    const struct pen_prims *prims = &scene->prims;
    uint32_t next = 0;
    for (uint32_t i = 0; i < prims->count; i++) {
        f->found_of[i] = PEN_NO_SOLID;
        if (is_solid(scene, i) && pen_prim_outlined(prims->ref[i].kind))
            f->face[f->faces++] =
                (struct solid_face){.prim = i, .material = f->same[scene->prim_material[i]]};
    }
    if (!pen_solid_faces_join(prims, f->face, f->faces))
        return false;
    for (uint32_t i = 0; i < prims->count; i++) {
        if (!is_solid(scene, i))
            continue;
        if (!pen_prim_outlined(prims->ref[i].kind)) {
            add_to_solid(f, i, f->count, true);
            continue;
        }
        const struct solid_face *face = &f->face[next++];
        const uint32_t first = f->face[face->solid].prim;
        add_to_solid(f, i, first == i ? f->count : f->found_of[first], face->closed);
        f->turned[i] = face->turned;
    }
    return true;
}

static int compare_found(const void *a, const void *b)
{
    const struct found *p = a, *q = b;
    if (p->volume != q->volume)
        return p->volume > q->volume ? -1 : 1;
    return (p->first > q->first) - (p->first < q->first);
}

/* Numbers the solids, and lists their primitives. */
static bool number_solids(struct finder *f)
{
    struct pen_arena *arena = f->scene->arena;
    const uint32_t prims = f->scene->prims.count;
    struct pen_solid *solid = pen_arena_alloc(arena, f->count, sizeof *solid);
    uint32_t *of_prim = pen_arena_alloc(arena, prims, sizeof *of_prim);
    uint32_t *prim = pen_arena_alloc(arena, prims, sizeof *prim);
    if (!solid || !of_prim || !prim)
        return false;
    for (uint32_t i = 0; i < f->count; i++) {
        const struct pen_vec3 size = pen_sub(f->found[i].solid.box.hi, f->found[i].solid.box.lo);
        f->found[i].volume = size.x * size.y * size.z;
        f->found[i].solid.first = i; /* its place, until it is numbered */
    }
    qsort(f->found, f->count, sizeof *f->found, compare_found);
    for (uint32_t i = 0, first = 0; i < f->count; i++) {
        f->number[f->found[i].solid.first] = i;
        solid[i] = f->found[i].solid;
        solid[i].first = first;
        first += solid[i].count;
        solid[i].count = 0;
    }
    for (uint32_t i = 0; i < prims; i++) {
        of_prim[i] = f->found_of[i] == PEN_NO_SOLID ? PEN_NO_SOLID : f->number[f->found_of[i]];
        if (of_prim[i] != PEN_NO_SOLID) {
            struct pen_solid *s = &solid[of_prim[i]];
            prim[s->first + s->count++] = i;
        }
    }
    f->scene->solids = (struct pen_solids){f->count, solid, prim, of_prim, f->turned};
    return true;
}

static bool overlaps_ball(const struct pen_box *b, struct pen_vec3 c, double r)
{
    return b->lo.x <= c.x + r && b->hi.x >= c.x - r && b->lo.y <= c.y + r && b->hi.y >= c.y - r &&
           b->lo.z <= c.z + r && b->hi.z >= c.z - r;
}

/* Which solids a view's eye is in, and which its lens may be in. */
static bool find_view(struct finder *f, struct pen_scene_view *view, struct pen_vec3 eye,
                      double lens)
{
    const struct pen_solids *solids = &f->scene->solids;
    uint32_t *list[2];
    for (int i = 0; i < 2; i++)
        if (!(list[i] = pen_arena_alloc(f->scene->arena, solids->count, sizeof *list[i])))
            return false;
    for (uint32_t i = 0; i < solids->count; i++) {
        if (!solids->at[i].closed || !overlaps_ball(&solids->at[i].box, eye, lens))
            continue;
        if (lens > 0)
            list[1][view->maybe.count++] = i;
        else if (pen_solid_contains(&f->scene->prims, solids, i, eye))
            list[0][view->inside.count++] = i;
    }
    view->inside.solid = list[0];
    view->maybe.solid = list[1];
    return true;
}

static bool find_views(struct pen_freezer *freezer, struct finder *f)
{
    for (uint32_t i = 0; i < freezer->scene->view_count; i++) {
        struct pen_scene_view *view = &freezer->views[i];
        if (!find_view(f, view, pen_local_point(&freezer->frame, view->frame.eye),
                       pen_local_length(&freezer->frame, view->camera.aperture_radius)))
            return false;
    }
    return true;
}

static bool find_all(struct pen_freezer *freezer, struct finder *f)
{
    const size_t prims = freezer->scene->prims.count;
    f->face = malloc(prims * sizeof *f->face);
    f->found = malloc(prims * sizeof *f->found);
    f->found_of = malloc(prims * sizeof *f->found_of);
    f->number = malloc(prims * sizeof *f->number);
    f->turned = pen_arena_alloc(freezer->scene->arena, prims, sizeof *f->turned);
    return f->face && f->found && f->found_of && f->number && f->turned && find_same(f) &&
           find_solids(f) && number_solids(f) && find_views(freezer, f);
}

bool pen_freeze_solids(struct pen_freezer *freezer)
{
    struct finder f = {.scene = freezer->scene};
    if (!(freezer->scene->effects & PEN_FX_REFRACTION))
        return true;
    const bool ok = find_all(freezer, &f) || pen_freeze_no_memory(freezer);
    free(f.same);
    free(f.face);
    free(f.found);
    free(f.found_of);
    free(f.number);
    return ok;
}

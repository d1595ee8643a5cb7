/* SPDX-License-Identifier: MIT */
/* Finds the solids of a scene that refracts, and numbers them. */
#include <stdlib.h>
#include <string.h>

#include "scene/internal/freeze.h"
#include "scene/internal/solid_faces.h"
#include "scene/internal/solid_volume.h"

/* Volumes with a relative difference below this are equal: they may be of copies that groups have
 * moved, turned or mirrored. */
static const double SAME_VOLUME = 1e-12;

/* A solid before it is numbered. */
struct found {
    struct pen_solid solid;
    uint32_t first; /* its first primitive */
    struct solid_volume volume;
    double size; /* that volume; the same number for volumes that count as equal */
};

struct finder {
    struct pen_scene *scene;
    uint32_t *same; /* by material: the first material that is equal */
    struct solid_face *face;
    uint32_t faces;
    struct pen_vec3 *kept,
        *vertex; /* vertices of faces that the scene leaves out or does not store; the next free one
                  */
    struct found *found;
    uint32_t *found_of; /* by primitive: its place in `found`, or PEN_NO_SOLID */
    uint32_t *number;   /* by place in `found`: the solid's number */
    uint32_t count;
    uint8_t *turned; /* by primitive */
    uint32_t prim;   /* the next primitive of a pass */
};

/* A material with its number, to sort materials by their values. */
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
    if (p->material->ior_written != q->material->ior_written)
        return p->material->ior_written ? 1 : -1;
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

/* Whether a round primitive is open. For open ones the reader refuses an ior other than 1. It
 * accepts 1, which makes no solid of them. */
static bool is_open(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    return (ref.kind == PEN_PRIM_CYLINDER && !prims->cylinder[ref.index].caps) ||
           (ref.kind == PEN_PRIM_CONE && !prims->cone[ref.index].hull.caps);
}

/* Whether a primitive is a solid, or a side of one. */
static bool is_solid(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_material *m = pen_scene_material(scene, prim);
    return pen_material_is_solid(m) && !pen_prim_infinite(pen_prim_kind(&scene->prims, prim)) &&
           (m->ior != 1 || !is_open(&scene->prims, prim));
}

/* Adds a primitive to the solid at a place in `found`, which may be new. */
static void add_to_solid(struct finder *f, uint32_t prim, uint32_t place, bool closed)
{
    struct found *to = &f->found[place];
    if (place == f->count) {
        f->count++;
        *to = (struct found){.first = prim};
        to->solid.ior = pen_scene_material(f->scene, prim)->ior;
        to->solid.box = pen_box_empty();
        to->solid.closed = closed;
    }
    to->solid.count++;
    to->solid.box = pen_box_union(to->solid.box, pen_prim_bounds(&f->scene->prims, prim));
    f->found_of[prim] = place;
}

/* Adds a triangle or polygon without area. */
static bool add_left_out(struct pen_freezer *freezer, const struct pen_scene_prim *prim, void *user)
{
    struct finder *f = user;
    const uint32_t material =
        prim->material < 0 ? f->scene->material_count - 1 : (uint32_t)prim->material;
    struct pen_vec3 *v = f->vertex;
    if (!pen_material_is_solid(&f->scene->materials[material]))
        return true;
    for (uint32_t i = 0; i < prim->from.count; i++)
        v[i] = pen_freeze_vertex(freezer, prim->from.vertices[i]);
    f->vertex += prim->from.count;
    f->face[f->faces++] = (struct solid_face){
        .line = {v, prim->from.count, 0}, .prim = PEN_NO_PRIM, .material = f->same[material]};
    return true;
}

/* Makes the solids in the order of their first primitives. */
static bool find_solids(struct pen_freezer *freezer, struct finder *f)
{
    const struct pen_scene *scene = f->scene;
    const struct pen_prims *prims = &scene->prims;
    uint32_t next = 0;
    f->vertex = f->kept;
    for (uint32_t i = 0; i < prims->count; i++) {
        f->found_of[i] = PEN_NO_SOLID;
        if (!is_solid(scene, i) || !pen_prim_outlined(pen_prim_kind(prims, i)))
            continue;
        struct pen_triangle room;
        struct pen_outline line = pen_prim_outline(prims, i, &room);
        if (line.v == room.v) { /* of a mesh */
            line.v = memcpy(f->vertex, room.v, sizeof room.v);
            f->vertex += 3;
        }
        f->face[f->faces++] = (struct solid_face){
            .line = line, .prim = i, .material = f->same[pen_scene_material_of(scene, i)]};
    }
    if (!pen_freeze_each_left_out(freezer, add_left_out, f) ||
        !pen_solid_faces_join(f->face, f->faces))
        return false;
    for (uint32_t i = 0; i < prims->count; i++) {
        if (!is_solid(scene, i))
            continue;
        if (!pen_prim_outlined(pen_prim_kind(prims, i))) {
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

/* A tree over the boxes of solids, without pointers. The middle box of the range begin to end - 1
 * is its root; the boxes before and behind it are its branches. */
struct box_tree {
    struct pen_box *box, *all; /* of a root: its own, and that of its range */
};

static double middle_of(const struct pen_box *b, int axis)
{
    return pen_component(b->lo, axis) + pen_component(b->hi, axis);
}

/* Puts the median of a range along an axis in its middle, and lesser boxes before it.
 * Source: Hoare's selection. */
static void select_median(struct pen_box *box, uint32_t begin, uint32_t end, int axis)
{
    const uint32_t middle = begin + (end - begin) / 2;
    while (end - begin > 1) {
        const double pivot = middle_of(&box[begin + (end - begin) / 2], axis);
        uint32_t i = begin, k = end - 1;
        while (i <= k) {
            while (middle_of(&box[i], axis) < pivot)
                i++;
            while (middle_of(&box[k], axis) > pivot)
                k--;
            if (i > k)
                break;
            const struct pen_box moved = box[i];
            box[i++] = box[k];
            box[k] = moved;
            if (k == 0)
                break;
            k--;
        }
        if (middle <= k && k + 1 < end)
            end = k + 1;
        else if (middle >= i)
            begin = i;
        else
            return;
    }
}

static struct pen_box tree_build(struct box_tree *t, uint32_t begin, uint32_t end)
{
    const uint32_t middle = begin + (end - begin) / 2;
    struct pen_box all = pen_box_empty();
    if (begin == end)
        return all;
    for (uint32_t i = begin; i < end; i++)
        all = pen_box_union(all, t->box[i]);
    const struct pen_vec3 size = pen_sub(all.hi, all.lo);
    select_median(t->box, begin, end,
                  size.x >= size.y && size.x >= size.z ? 0
                  : size.y >= size.z                   ? 1
                                                       : 2);
    tree_build(t, begin, middle);
    tree_build(t, middle + 1, end);
    return t->all[middle] = all;
}

static bool boxes_meet(const struct pen_box *a, const struct pen_box *b)
{
    return a->lo.x <= b->hi.x && a->hi.x >= b->lo.x && a->lo.y <= b->hi.y && a->hi.y >= b->lo.y &&
           a->lo.z <= b->hi.z && a->hi.z >= b->lo.z;
}

static bool tree_meets(const struct box_tree *t, uint32_t begin, uint32_t end,
                       const struct pen_box *b)
{
    const uint32_t middle = begin + (end - begin) / 2;
    return begin < end && boxes_meet(&t->all[middle], b) &&
           (boxes_meet(&t->box[middle], b) || tree_meets(t, begin, middle, b) ||
            tree_meets(t, middle + 1, end, b));
}

/* Makes the tree of all solids with an index other than 1.
 * Owns: free tree->box. */
static bool tree_make(struct box_tree *tree, const struct finder *f, uint32_t count)
{
    tree->box = malloc((2 * (size_t)count + 1) * sizeof *tree->box);
    if (!tree->box)
        return false;
    tree->all = tree->box + count;
    for (uint32_t i = 0, at = 0; i < f->count; i++)
        if (f->found[i].solid.ior != 1)
            tree->box[at++] = f->found[i].solid.box;
    tree_build(tree, 0, count);
    return true;
}

/* Drops solids with an index of 1 that change nothing: those that do not close, since exporters
 * write the key everywhere, and those whose boxes meet no box of a solid with another index. */
static bool drop_ones(struct finder *f)
{
    uint32_t others = 0, kept = 0;
    for (uint32_t i = 0; i < f->count; i++)
        others += f->found[i].solid.ior != 1;
    if (others == f->count)
        return true;
    struct box_tree tree;
    if (!tree_make(&tree, f, others))
        return false;
    for (uint32_t i = 0; i < f->count; i++) {
        const struct found found = f->found[i];
        const bool keep = found.solid.ior != 1 ||
                          (found.solid.closed && tree_meets(&tree, 0, others, &found.solid.box));
        f->number[i] = keep ? kept : PEN_NO_SOLID;
        f->found[kept] = found;
        kept += keep;
    }
    for (uint32_t i = 0; i < f->scene->prims.count; i++)
        if (f->found_of[i] != PEN_NO_SOLID)
            f->found_of[i] = f->number[f->found_of[i]];
    f->count = kept;
    free(tree.box);
    return true;
}

/* The same for all triangles of a mesh. */
static void add_mesh_volume(struct finder *f, const struct pen_scene_prim *mesh)
{
    for (uint32_t i = 0; i < mesh->mesh->triangle_count; i++) {
        const uint32_t number = f->prim++, place = f->found_of[number];
        struct pen_vec3 own[3], moved[3];
        struct pen_scene_prim prim = *mesh;
        if (place == PEN_NO_SOLID)
            continue;
        pen_mesh_desc_triangle(mesh->mesh, i, own);
        const bool mirrored = prim.moved_by && pen_transform_orientation(prim.moved_by) < 0;
        for (int k = 0; k < 3; k++)
            moved[mirrored ? 2 - k : k] =
                prim.moved_by ? pen_transform_point(prim.moved_by, own[k]) : own[k];
        prim.own = own;
        prim.from = (struct pen_prim_source){.count = 3, .vertices = moved};
        pen_solid_volume_add(&f->found[place].volume, &prim, f->turned[number]);
    }
}

static bool add_volume(struct pen_freezer *freezer, const struct pen_scene_prim *prim, void *user)
{
    struct finder *f = user;
    if (prim->mesh) {
        add_mesh_volume(f, prim);
        return true;
    }
    const uint32_t number = f->prim++, place = f->found_of[number];
    (void)freezer;
    if (place != PEN_NO_SOLID)
        pen_solid_volume_add(&f->found[place].volume, prim, f->turned[number]);
    return true;
}

/* The volume of the box of an open solid, in the document's units. */
static double box_volume(const struct pen_box *box, int exponent)
{
    const struct pen_vec3 size = pen_sub(box->hi, box->lo);
    return pen_scale2(pen_scale2(pen_scale2(size.x * size.y * size.z, exponent), exponent),
                      exponent);
}

static int compare_found(const void *a, const void *b)
{
    const struct found *p = a, *q = b;
    if (p->size != q->size)
        return p->size > q->size ? -1 : 1;
    return (p->first > q->first) - (p->first < q->first);
}

/* Sorts the solids: the largest first. Of those that are equal up to rounding, the first in the
 * document is first. */
static bool sort_found(struct pen_freezer *freezer, struct finder *f)
{
    f->prim = 0;
    if (!pen_freeze_each(freezer, add_volume, f))
        return false;
    for (uint32_t i = 0; i < f->count; i++) {
        struct found *found = &f->found[i];
        found->size = found->solid.closed ? pen_solid_volume(&found->volume)
                                          : box_volume(&found->solid.box, freezer->frame.exponent);
        found->solid.first = i; /* its place, until it is numbered */
    }
    qsort(f->found, f->count, sizeof *f->found, compare_found);
    for (uint32_t i = f->count; i-- > 1;) /* the smallest of the equal sizes replaces all of them */
        if (f->found[i - 1].size <= f->found[i].size * (1 + SAME_VOLUME))
            f->found[i - 1].size = f->found[i].size;
    qsort(f->found, f->count, sizeof *f->found, compare_found);
    return true;
}

/* Numbers the solids, and lists their primitives. */
static bool number_solids(struct pen_freezer *freezer, struct finder *f)
{
    struct pen_arena *arena = f->scene->arena;
    const uint32_t prims = f->scene->prims.count;
    struct pen_solid *solid = pen_arena_alloc(arena, f->count, sizeof *solid);
    uint32_t *of_prim = pen_arena_alloc(arena, prims, sizeof *of_prim);
    uint32_t *prim = pen_arena_alloc(arena, prims, sizeof *prim);
    if (!solid || !of_prim || !prim)
        return false;
    if (!sort_found(freezer, f))
        return false;
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

static bool find_all(struct pen_freezer *freezer, struct finder *f)
{
    const size_t prims = freezer->scene->prims.count;
    f->face = malloc((prims + freezer->desc->left_out_count) * sizeof *f->face);
    uint64_t kept = freezer->desc->left_out_vertices + 1;
    for (uint32_t i = 0; i < freezer->scene->prims.mesh_count; i++)
        kept += 3 * (uint64_t)freezer->scene->prims.mesh[i].count;
    f->kept = malloc(kept * sizeof *f->kept);
    f->found = malloc(prims * sizeof *f->found);
    f->found_of = malloc(prims * sizeof *f->found_of);
    f->number = malloc(prims * sizeof *f->number);
    f->turned = pen_arena_alloc(freezer->scene->arena, prims, sizeof *f->turned);
    return f->face && f->kept && f->found && f->found_of && f->number && f->turned &&
           find_same(f) && find_solids(freezer, f) && drop_ones(f) && number_solids(freezer, f) &&
           pen_freeze_eyes(freezer);
}

/* Whether light is refracted somewhere. If all solids have an index of 1, it is not. */
static bool scene_refracts(const struct pen_scene *scene)
{
    for (uint32_t i = 0; i < pen_prim_slots(&scene->prims); i++) {
        const struct pen_material *m = &scene->materials[scene->prim_material[i]];
        if (m->ior != 1 && color_is_lit(m->kt))
            return true;
    }
    return false;
}

bool pen_freeze_solids(struct pen_freezer *freezer)
{
    struct finder f = {.scene = freezer->scene};
    if (!scene_refracts(freezer->scene))
        return true;
    const bool ok = find_all(freezer, &f) || pen_freeze_no_memory(freezer);
    free(f.same);
    free(f.face);
    free(f.kept);
    free(f.found);
    free(f.found_of);
    free(f.number);
    return ok;
}

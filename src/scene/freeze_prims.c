/* SPDX-License-Identifier: MIT */
/* The typed arrays of a frozen scene, one per kind, filled in document order, in local coordinates.
 * Also the data of each primitive for kernels: its material, and whether it transmits light. */
#include "math/frame.h"
#include "scene/internal/freeze.h"

/* The arrays while they are filled; for the scene they are then constant. */
struct filler {
    struct pen_prim_ref *ref;
    void *array[PEN_PRIM_KIND_COUNT];
    struct pen_vec3 *kept;   /* vertices that primitives keep: the next free one */
    struct pen_vec3 *passed; /* room for the vertices of one primitive that does not keep them */
    uint32_t *material;
    uint8_t *see_through;
    struct pen_mesh *mesh;
    struct pen_prims prims; /* the counts so far */
    uint32_t slots;
    uint32_t mesh_triangles;
};

/* The most vertices of a kind that does not keep them: a triangle's. */
enum { PASSED_MAX = 3 };

static bool alloc_arrays(struct pen_freezer *f, struct filler *a)
{
    struct pen_arena *arena = f->scene->arena;
    size_t slots = f->summary.slots;
    a->ref = pen_arena_alloc(arena, slots, sizeof *a->ref);
    a->material = pen_arena_alloc(arena, slots, sizeof *a->material);
    a->see_through = pen_arena_alloc(arena, slots, sizeof *a->see_through);
    a->mesh = pen_arena_alloc(arena, f->mesh_count, sizeof *a->mesh);
    bool ok = a->ref && a->material && a->see_through && a->mesh;
    for (int kind = 0; kind < PEN_PRIM_KIND_COUNT; kind++) {
        a->array[kind] = pen_arena_alloc(arena, f->summary.kind_count[kind], pen_kinds[kind].bytes);
        ok = ok && a->array[kind];
    }
    a->kept = pen_arena_alloc(arena, f->summary.kept_vertices, sizeof *a->kept);
    return (ok && a->kept) || pen_freeze_no_memory(f);
}

static const struct pen_vec3 *local_vertices(const struct pen_freezer *f, struct filler *a,
                                             const struct pen_scene_prim *scene_prim)
{
    bool keeps = pen_kinds[scene_prim->kind].fn->keeps_vertices;
    struct pen_vec3 *v = keeps ? a->kept : a->passed;
    if (keeps)
        a->kept += scene_prim->from.count;
    for (uint32_t i = 0; i < scene_prim->from.count && (keeps || i < PASSED_MAX); i++)
        v[i] = pen_freeze_vertex(f, scene_prim->from.vertices[i]);
    return v;
}

/* Makes a triangle or polygon whose vertices rounding has put on one line, for example where a
 * group moves a needle. It stays a primitive; its normal is any vector across that line. Its area
 * is zero, and a ray meets it only within the rounding of its vertices. */
static bool make_without_area(const struct pen_kind *kind, struct pen_prim_source *from, void *prim)
{
    struct pen_vec3 longest = {0, 0, 0};
    for (uint32_t i = 1; i < from->count; i++) {
        struct pen_vec3 edge = pen_sub(from->vertices[i], from->vertices[0]);
        if (vec_max_abs(edge) > vec_max_abs(longest))
            longest = edge;
    }
    if (!(vec_max_abs(longest) > 0 && isfinite(vec_max_abs(longest))))
        return false;
    from->direction = pen_across(vec_normalize(longest)).u;
    return kind->fn->make(prim, from);
}

/* u of a point's coordinates in the document, as a local length. Numbers for one place, such as a
 * cylinder's end and the floor it stands on, may have been rounded to values this far apart. */
static double rounding_of(const struct pen_local_frame *frame, struct pen_vec3 p)
{
    return pen_local_length(frame, PEN_U * fabs(p.x) + PEN_U * fabs(p.y) + PEN_U * fabs(p.z));
}

/* Makes primitive number `index` of its kind. Returns false if its numbers are beyond the range of
 * the kind. */
static bool fill_shape(struct pen_freezer *f, struct filler *a,
                       const struct pen_scene_prim *scene_prim, uint32_t index)
{
    const struct pen_kind *kind = &pen_kinds[scene_prim->kind];
    struct pen_vec3 passed[PASSED_MAX];
    struct pen_prim_source from = scene_prim->from;
    from.rounding = rounding_of(&f->frame, from.point);
    from.point = pen_local_point(&f->frame, from.point);
    for (int i = 0; i < PEN_LENGTHS; i++)
        from.length[i] = pen_local_length(&f->frame, from.length[i]);
    a->passed = passed;
    from.vertices = local_vertices(f, a, scene_prim);
    void *prim = (char *)a->array[scene_prim->kind] + index * kind->bytes;
    return pen_freeze_in_range(from.point) &&
           (kind->fn->make(prim, &from) ||
            (pen_prim_outlined(scene_prim->kind) && make_without_area(kind, &from, prim)));
}

/* Completes primitive number `index` of its kind. */
static bool cut_shape(struct pen_freezer *f, const struct filler *a, uint32_t kind, uint32_t index)
{
    const struct pen_kind *row = &pen_kinds[kind];
    void *prim = (char *)a->array[kind] + index * row->bytes;
    return !f->rays || !row->fn->cut || row->fn->cut(prim, f->scene->arena) ||
           pen_freeze_no_memory(f);
}

/* Fills a slot. material: index, -1: default. */
static void fill_slot(struct pen_freezer *f, struct filler *a, struct pen_prim_ref ref,
                      int material)
{
    const uint32_t slot = a->slots++;
    a->ref[slot] = ref;
    a->material[slot] = material >= 0 ? (uint32_t)material : f->desc->material_count;
    a->see_through[slot] =
        !f->desc->opaque_shadows && color_is_lit(f->scene->materials[a->material[slot]].kt);
    f->scene->any_see_through = f->scene->any_see_through || a->see_through[slot];
}

static bool fail_range(struct pen_freezer *f)
{
    return pen_fail(f->st, PEN_INVALID,
                    "is too large, too small or too far away beside the rest of the scene");
}

static bool fill_mesh(struct pen_freezer *f, const struct pen_scene_prim *scene_prim,
                      struct filler *a)
{
    struct pen_mesh *mesh = &a->mesh[a->prims.mesh_count++];
    *mesh = f->mesh[f->mesh_next++];
    mesh->first = a->prims.count;
    mesh->slot = a->slots;
    mesh->index = f->summary.kind_count[PEN_PRIM_TRIANGLE] + a->mesh_triangles;
    a->prims.count += mesh->count;
    a->mesh_triangles += mesh->count;
    const struct pen_prim_ref ref = {.kind = PEN_PRIM_TRIANGLE};
    for (uint32_t i = 0; i < mesh->slots; i++)
        fill_slot(f, a, ref, scene_prim->mesh->material[i]);
    return pen_freeze_mesh_end(f, mesh) || fail_range(f);
}

static bool fill_primitive(struct pen_freezer *f, const struct pen_scene_prim *scene_prim,
                           void *user)
{
    struct filler *a = user;
    if (scene_prim->mesh)
        return fill_mesh(f, scene_prim, a);
    uint32_t index = a->prims.kind_count[scene_prim->kind]++;
    a->prims.count++;
    fill_slot(f, a,
              (struct pen_prim_ref){.kind = scene_prim->kind & 0xF, .index = index & 0xFFFFFFF},
              scene_prim->material);
    if (!fill_shape(f, a, scene_prim, index))
        return fail_range(f);
    return cut_shape(f, a, scene_prim->kind, index);
}

bool pen_freeze_prims(struct pen_freezer *f)
{
    struct filler a = {0};
    if (!alloc_arrays(f, &a) || !pen_freeze_each(f, fill_primitive, &a))
        return false;
    f->scene->prims = a.prims;
    f->scene->prims.ref = a.ref;
    f->scene->prims.mesh = a.mesh;
    for (int kind = 0; kind < PEN_PRIM_KIND_COUNT; kind++)
        f->scene->prims.array[kind] = a.array[kind];
    f->scene->prim_material = a.material;
    f->scene->see_through = a.see_through;
    return true;
}

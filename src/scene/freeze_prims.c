/* SPDX-License-Identifier: MIT */
/* The typed arrays of a frozen scene: one per kind, filled in document order, in local
 * coordinates, with what kernels ask about a primitive beside its shape: its material, and whether
 * light passes through it. */
#include "scene/internal/freeze.h"

/* The arrays while they are filled; the scene sees them as constant afterwards. */
struct filler {
    struct pen_prim_ref *ref;
    void *array[PEN_PRIM_KIND_COUNT];
    struct pen_vec3 *kept;   /* vertices that primitives keep: the next free one */
    struct pen_vec3 *passed; /* room for those of one primitive that does not keep them */
    uint32_t *material;
    uint8_t *see_through;
    struct pen_prims prims; /* the counts so far */
};

/* Vertices of a kind that does not keep them: a triangle's. */
enum { PASSED_MAX = 3 };

static bool alloc_arrays(struct pen_freezer *f, struct filler *a)
{
    struct pen_arena *arena = f->scene->arena;
    size_t total = f->survey.total;
    a->ref = pen_arena_alloc(arena, total, sizeof *a->ref);
    a->material = pen_arena_alloc(arena, total, sizeof *a->material);
    a->see_through = pen_arena_alloc(arena, total, sizeof *a->see_through);
    bool ok = a->ref && a->material && a->see_through;
    for (int kind = 0; kind < PEN_PRIM_KIND_COUNT; kind++) {
        a->array[kind] = pen_arena_alloc(arena, f->survey.kind_count[kind], pen_kinds[kind].bytes);
        ok = ok && a->array[kind];
    }
    a->kept = pen_arena_alloc(arena, f->survey.kept_vertices, sizeof *a->kept);
    return (ok && a->kept) || pen_freeze_no_memory(f);
}

/* The vertices in the local frame. What is lost to PEN_LEAST is far below what the frame's own
 * extent resolves. */
static const struct pen_vec3 *local_vertices(const struct pen_freezer *f, struct filler *a,
                                             const struct pen_placed *placed)
{
    bool keeps = pen_kinds[placed->kind].fn->keeps_vertices;
    struct pen_vec3 *v = keeps ? a->kept : a->passed;
    if (keeps)
        a->kept += placed->from.count;
    for (uint32_t i = 0; i < placed->from.count && (keeps || i < PASSED_MAX); i++)
        v[i] = pen_without_less(pen_local_point(&f->frame, placed->from.vertices[i]), PEN_LEAST);
    return v;
}

/* Makes primitive number `index` of its kind. False if its numbers are beyond what geometry
 * takes. */
static bool fill_shape(struct pen_freezer *f, struct filler *a, const struct pen_placed *placed,
                       uint32_t index)
{
    const struct pen_kind *kind = &pen_kinds[placed->kind];
    struct pen_vec3 passed[PASSED_MAX];
    struct pen_prim_source from = placed->from;
    from.point = pen_local_point(&f->frame, from.point);
    for (int i = 0; i < PEN_LENGTHS; i++)
        from.length[i] = pen_local_length(&f->frame, from.length[i]);
    a->passed = passed;
    from.vertices = local_vertices(f, a, placed);
    return pen_freeze_in_range(from.point) &&
           kind->fn->make((char *)a->array[placed->kind] + index * kind->bytes, &from);
}

static bool fill_primitive(struct pen_freezer *f, const struct pen_placed *placed, void *user)
{
    struct filler *a = user;
    uint32_t prim = a->prims.count++;
    uint32_t index = a->prims.kind_count[placed->kind]++;
    a->ref[prim] = (struct pen_prim_ref){.kind = placed->kind & 0xF, .index = index & 0xFFFFFFF};
    a->material[prim] =
        placed->material >= 0 ? (uint32_t)placed->material : f->desc->material_count;
    a->see_through[prim] = color_is_lit(f->scene->materials[a->material[prim]].kt);
    f->scene->any_see_through = f->scene->any_see_through || a->see_through[prim];
    if (!fill_shape(f, a, placed, index))
        return pen_fail(f->st, PEN_INVALID,
                        "is too large, too small or too far away beside the rest of the scene");
    return true;
}

bool pen_freeze_prims(struct pen_freezer *f)
{
    struct filler a = {0};
    if (!alloc_arrays(f, &a) || !pen_freeze_each(f, fill_primitive, &a))
        return false;
    f->scene->prims = a.prims;
    f->scene->prims.ref = a.ref;
    for (int kind = 0; kind < PEN_PRIM_KIND_COUNT; kind++)
        f->scene->prims.array[kind] = a.array[kind];
    f->scene->prim_material = a.material;
    f->scene->see_through = a.see_through;
    return true;
}

/* SPDX-License-Identifier: MIT */
/* State shared by the steps of freezing: the scene while it is being filled. */
#ifndef PEN_SCENE_INTERNAL_FREEZE_H
#define PEN_SCENE_INTERNAL_FREEZE_H

#include "scene/internal/local_frame.h"
#include "scene/internal/scene_prim.h"
#include "scene/internal/vec.h"
#include "scene/scene.h"

/* The largest local coordinate. Beyond it squares may overflow, and a pixel covers more than the
 * whole scene. */
#define FREEZE_LOCAL_MAX 0x1p400

struct pen_freezer {
    const struct pen_scene_desc *desc;
    struct pen_scene *scene;
    struct pen_status *st;
    size_t cap_bytes; /* of the scene's arena; 0: none */
    bool rays;        /* will be traced; false: data that only rays need is left out */
    struct pen_prim_summary summary;
    struct pen_local_frame frame;
    struct pen_camera_frame *cameras; /* by view, scene units */
    struct pen_scene_view *views;     /* those of the scene */
    struct pen_vec3 *buffer; /* malloced: the transformed vertices of the current primitive */
    uint32_t buffer_capacity;
    /* malloced: the meshes, in document order, in the document's units until they have numbers */
    struct pen_mesh *mesh;
    uint32_t mesh_count, mesh_next;
};

static inline bool pen_freeze_no_memory(struct pen_freezer *f)
{
    return pen_fail(f->st, PEN_NO_MEMORY, "the scene does not fit into its memory limit");
}

static inline bool pen_freeze_in_range(struct pen_vec3 local)
{
    return fabs(local.x) <= FREEZE_LOCAL_MAX && fabs(local.y) <= FREEZE_LOCAL_MAX &&
           fabs(local.z) <= FREEZE_LOCAL_MAX;
}

/* Calls fn for every primitive, in scene units and document order, until fn returns false. Adds the
 * primitive's JSON Pointer to the status of an error. Returns whether all calls returned true. */
typedef bool pen_freeze_primitive(struct pen_freezer *f, const struct pen_scene_prim *scene_prim,
                                  void *user);
bool pen_freeze_each(struct pen_freezer *f, pen_freeze_primitive *fn, void *user);

/* The same for objects that are left out. */
bool pen_freeze_each_left_out(struct pen_freezer *f, pen_freeze_primitive *fn, void *user);

/* A vertex in the local frame. Coordinates below PEN_LEAST become 0; this is far below the
 * resolution of doubles at the frame's extent. */
static inline struct pen_vec3 pen_freeze_vertex(const struct pen_freezer *f, struct pen_vec3 v)
{
    return pen_without_less(pen_local_point(&f->frame, v), PEN_LEAST);
}

/* Makes a mesh in the document's units and adds it to the summary. */
bool pen_freeze_mesh_begin(struct pen_freezer *f, const struct pen_scene_prim *prim);

/* Moves a mesh to the local frame. Returns false if it leaves its range. */
bool pen_freeze_mesh_end(const struct pen_freezer *f, struct pen_mesh *mesh);

/* Fills the typed arrays of the primitives; needs f->summary and f->frame. */
bool pen_freeze_prims(struct pen_freezer *f);

/* Makes the own spaces of patterned primitives, in document order. */
bool pen_freeze_own_spaces(struct pen_freezer *f);

/* Finds where primitives may coincide: scene->layer_box; needs the typed arrays. */
bool pen_freeze_layers(struct pen_freezer *f);

/* Finds the solids of a scene that refracts; needs the typed arrays. */
bool pen_freeze_solids(struct pen_freezer *f);

/* Finds the solids that contain the eyes, and moves an eye that is on the surface of a solid off
 * it. Called by pen_freeze_solids.
 * Fails: returns false when out of memory. */
bool pen_freeze_eyes(struct pen_freezer *f);

/* Builds the accelerator `manual`; needs the typed arrays.
 * Fails: as pen_accel_build. */
struct pen_accel *pen_freeze_manual(struct pen_freezer *f);

#endif

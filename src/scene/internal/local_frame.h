/* SPDX-License-Identifier: MIT */
/* The local frame of a scene (see scene/scene.h), and the summary of primitives that determines it.
 */
#ifndef PEN_SCENE_INTERNAL_LOCAL_FRAME_H
#define PEN_SCENE_INTERNAL_LOCAL_FRAME_H

#include "math/box.h"
#include "scene/internal/scene_prim.h"

/* Bounds and counts of primitives in scene units, collected one by one. */
struct pen_prim_summary {
    struct pen_box finite, infinite; /* bounds of the anchor points of primitives */
    double finite_reach; /* the largest distance that a finite primitive extends from its anchor */
    double infinite_reach;
    uint32_t kind_count[PEN_PRIM_KIND_COUNT];
    uint64_t kept_vertices; /* vertices of kinds whose primitives refer to them */
    uint64_t total, slots;  /* of primitives; of pen_prim_slot */
};

struct pen_prim_summary pen_prim_summary_empty(void);
void pen_prim_summary_add(struct pen_prim_summary *summary,
                          const struct pen_scene_prim *scene_prim);

/* p_local = (p - center) * 2^-exponent. */
struct pen_local_frame {
    struct pen_vec3 center;
    int exponent;
};

/* Computes the local frame of the finite primitives. If there are none, it is the frame of the
 * anchors of the infinite ones and of the eyes of all views.
 * Fails: returns false if the extent overflows a double. */
bool pen_local_frame_make(const struct pen_prim_summary *summary,
                          const struct pen_camera_frame *cameras, uint32_t camera_count,
                          struct pen_local_frame *frame);

struct pen_vec3 pen_local_point(const struct pen_local_frame *frame, struct pen_vec3 p);
double pen_local_length(const struct pen_local_frame *frame, double length);

#endif

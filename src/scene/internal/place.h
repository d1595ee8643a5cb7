/* SPDX-License-Identifier: MIT */
/* Primitives placed in the scene: the transforms of their groups applied, once, in double. */
#ifndef PEN_SCENE_INTERNAL_PLACE_H
#define PEN_SCENE_INTERNAL_PLACE_H

#include "geom/prims.h"
#include "math/box.h"
#include "scene/internal/desc_iter.h"

struct pen_placed {
    enum pen_prim_kind kind;
    int material;
    struct pen_prim_source from; /* vertices are in the caller's buffer, or the document's own */
};

/* Places a primitive. `buffer` has room for its vertices. Mirrors keep the outside: a quadric's by
 * itself, a plane's normal by the inverse transpose, a loop by running the other way round.
 * Fails: PEN_INVALID, without a pointer (a quadric under something else than a similarity, or a
 * transform that leaves the range of doubles). */
bool pen_place_primitive(const struct pen_desc_iter_item *item, struct pen_vec3 *buffer,
                         struct pen_placed *placed, struct pen_status *st);

/* What the local frame is made from, gathered primitive by primitive in scene units. */
struct pen_survey {
    struct pen_box finite, infinite; /* of the points that primitives are anchored at */
    double finite_reach; /* how far a finite primitive reaches from its anchor, at most */
    double infinite_reach;
    uint32_t kind_count[PEN_PRIM_KIND_COUNT];
    uint64_t kept_vertices; /* of kinds that keep those they are made from */
    uint64_t total;
};

struct pen_survey pen_survey_empty(void);
void pen_survey_add(struct pen_survey *survey, const struct pen_placed *placed);

/* p_local = (p - center) * 2^-exponent */
struct pen_local_frame {
    struct pen_vec3 center;
    int exponent;
};

/* The local frame of the primitives; where all are infinite, of their anchors and the eyes of the
 * views. Returns false if the scene is larger than a double can say. */
bool pen_local_frame_make(const struct pen_survey *survey, const struct pen_camera_frame *cameras,
                          uint32_t camera_count, struct pen_local_frame *frame);

struct pen_vec3 pen_local_point(const struct pen_local_frame *frame, struct pen_vec3 p);
double pen_local_length(const struct pen_local_frame *frame, double length);

#endif

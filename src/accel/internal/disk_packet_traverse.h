/* SPDX-License-Identifier: MIT */
/* Traverses the tree once for a disk packet and collects the primitives that some ray may hit. A
 * box is skipped if it does not overlap the box around all rays. It is also skipped if it is beyond
 * one of four planes through the origin that enclose the cone of rays. Both tests are widened by
 * the packet's delta and by the rounding of floats. */
#ifndef PEN_ACCEL_INTERNAL_DISK_PACKET_TRAVERSE_H
#define PEN_ACCEL_INTERNAL_DISK_PACKET_TRAVERSE_H

#include "accel/internal/disk_candidate.h"
#include "accel/internal/floats8.h"
#include "accel/internal/prim_test.h"

/* A plane that encloses the rays: a box is beyond it if n.x > off for all points of the box. */
struct disk_packet_plane {
    float n[3], off;
    int row[3]; /* rows of struct pen_node's planes: the end of the box at which n.x is least */
};

struct disk_packet_box {
    float lo[3], hi[3];
    struct disk_packet_plane plane[4];
};

static inline void disk_packet_box_axis(struct disk_packet_box *box, int axis,
                                        const struct pen_disk_packet *packet)
{
    double o = pen_component(packet->o, axis), c = pen_component(packet->c, axis);
    double u = pen_component(packet->u, axis), v = pen_component(packet->v, axis);
    double half = sqrt(u * u + v * v), low = c - half, high = c + half;
    if (!packet->to_point) {
        low = low < 0 ? -INFINITY : 0;
        high = high > 0 ? INFINITY : 0;
    }
    double margin = packet->delta + 0x1p-40 * (fabs(o) + packet->reach);
    box->lo[axis] = pen_float_down(o + (low < 0 ? low : 0) - margin);
    box->hi[axis] = pen_float_up(o + (high > 0 ? high : 0) + margin);
}

static inline struct disk_packet_plane disk_packet_plane_of(const struct pen_disk_packet *packet,
                                                            struct pen_vec3 across)
{
    struct pen_vec3 n =
        pen_along(pen_scale(across, packet->cone_cos), packet->axis, -packet->cone_sin);
    struct disk_packet_plane plane;
    for (int axis = 0; axis < 3; axis++) {
        plane.n[axis] = pen_float_near(pen_component(n, axis));
        plane.row[axis] = axis + (plane.n[axis] < 0 ? 3 : 0);
    }
    plane.off =
        pen_float_up(pen_dot(n, packet->o) + packet->delta + 0x1p-22 * pen_norm1(packet->o));
    return plane;
}

static inline void disk_packet_box_make(struct disk_packet_box *box,
                                        const struct pen_disk_packet *packet)
{
    double radius = pen_length(packet->u), inv = radius > 0 ? 1 / radius : 0;
    struct pen_vec3 u = pen_scale(packet->u, inv), v = pen_scale(packet->v, inv);
    for (int axis = 0; axis < 3; axis++)
        disk_packet_box_axis(box, axis, packet);
    box->plane[0] = disk_packet_plane_of(packet, u);
    box->plane[1] = disk_packet_plane_of(packet, pen_neg(u));
    box->plane[2] = disk_packet_plane_of(packet, v);
    box->plane[3] = disk_packet_plane_of(packet, pen_neg(v));
}

/* The node's boxes that some ray may enter, as bits. */
static inline unsigned disk_packet_enter_node(const struct pen_node *node,
                                              const struct disk_packet_box *box)
{
    mask8 in = {-1, -1, -1, -1, -1, -1, -1, -1};
    for (int axis = 0; axis < 3; axis++) {
        const float8 *lo = (const float8 *)node->plane[axis];
        const float8 *hi = (const float8 *)node->plane[axis + 3];
        in &= (*lo <= box->hi[axis]) & (*hi >= box->lo[axis]);
    }
    for (int i = 0; i < 4; i++) {
        const struct disk_packet_plane *plane = &box->plane[i];
        float8 x = *(const float8 *)node->plane[plane->row[0]];
        float8 y = *(const float8 *)node->plane[plane->row[1]];
        float8 z = *(const float8 *)node->plane[plane->row[2]];
        float8 least = plane->n[0] * x + plane->n[1] * y + plane->n[2] * z;
        in &= least - 0x1p-20f * (ABS8(x) + ABS8(y) + ABS8(z)) <= plane->off;
    }
    return mask8_bits(&in);
}

/* Adds a primitive's candidate. Returns false if that ends the traversal. */
static inline bool disk_packet_add(const struct pen_accel *accel, struct pen_disk_packet *packet,
                                   uint32_t prim, bool generic,
                                   enum pen_disk_visibility *visibility)
{
    enum pen_disk_candidate_verdict sign = pen_disk_candidate_make(
        packet, accel->prims, prim, generic, &packet->candidate[packet->candidate_count]);
    if (sign == PEN_DISK_CANDIDATE_NEVER)
        return true;
    if (sign == PEN_DISK_CANDIDATE_ALWAYS) {
        packet->last_occluder = prim;
        *visibility = PEN_DISK_ALL_OCCLUDED;
        return false;
    }
    if (!packet->candidate[packet->candidate_count].opaque &&
        packet->transmissive_count < PEN_DISK_TRANSMISSIVE)
        packet->transmissive[packet->transmissive_count++] = (uint8_t)packet->candidate_count;
    else if (!packet->candidate[packet->candidate_count].opaque)
        packet->candidate[packet->candidate_count].kind = PEN_DISK_CANDIDATE_FALLBACK;
    if (++packet->candidate_count < PEN_DISK_CANDIDATES)
        return true;
    *visibility = PEN_DISK_NOT_POSSIBLE;
    return false;
}

static inline bool disk_packet_add_leaf(const struct pen_accel *accel,
                                        struct pen_disk_packet *packet, uint32_t first,
                                        enum pen_disk_visibility *visibility)
{
    uint32_t items[PEN_LEAF_BLOCKS_MAX];
    for (const uint32_t *item = leaf_items(accel, first, items);; item++) {
        bool generic = PEN_ITEM_KIND(*item) == PEN_BLOCK_GENERIC;
        const uint32_t *prim = block_prims(accel, *item);
        for (int lane = 0; prim && lane < PEN_LANES && prim[lane] != PEN_NO_PRIM; lane++) {
            if (!disk_packet_add(accel, packet, prim[lane], generic, visibility))
                return false;
        }
        if (*item & PEN_ITEM_LAST)
            return true;
    }
}

static inline void disk_packet_traverse(const struct pen_accel *accel,
                                        struct pen_disk_packet *packet,
                                        enum pen_disk_visibility *visibility)
{
    uint32_t stack[(PEN_WIDE - 1) * PEN_MAX_DEPTH + 1];
    int top = 0;
    struct disk_packet_box box;
    disk_packet_box_make(&box, packet);
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &accel->nodes[stack[--top]];
        for (unsigned mask = disk_packet_enter_node(node, &box); mask; mask &= mask - 1) {
            uint32_t child = node->child[__builtin_ctz(mask)];
            if (!(child & PEN_CHILD_LEAF))
                stack[top++] = child;
            else if (!disk_packet_add_leaf(accel, packet, child & ~PEN_CHILD_LEAF, visibility))
                return;
        }
    }
}

/* Whether the primitive that occluded the whole last packet also occludes this whole packet. */
static inline bool occluded_by_last(const struct pen_accel *accel, struct pen_disk_packet *packet)
{
    uint32_t last = packet->last_occluder;
    if (last >= accel->prims->count)
        return false;
    packet->last_occluder = PEN_NO_PRIM;
    if (pen_prim_cut(accel->prims, last) ||
        pen_disk_candidate_make(packet, accel->prims, last, false, &packet->candidate[0]) !=
            PEN_DISK_CANDIDATE_ALWAYS)
        return false;
    packet->last_occluder = last;
    return true;
}

static enum pen_disk_visibility disk_begin(const struct pen_accel *accel,
                                           struct pen_disk_packet *packet)
{
    enum pen_disk_visibility visibility = PEN_DISK_ALL_VISIBLE;
    if (accel->stats.kind != PEN_ACCEL_AUTO || !pen_disk_packet_prepare(packet, accel->scale))
        return PEN_DISK_NOT_POSSIBLE;
    if (occluded_by_last(accel, packet))
        return PEN_DISK_ALL_OCCLUDED;
    if (disk_packet_add_leaf(accel, packet, accel->infinite, &visibility) &&
        (!accel->list || disk_packet_add_leaf(accel, packet, accel->list, &visibility)) &&
        accel->shape == PEN_SHAPE_WIDE)
        disk_packet_traverse(accel, packet, &visibility);
    return visibility == PEN_DISK_ALL_VISIBLE && packet->candidate_count > 0 ? PEN_DISK_MIXED
                                                                             : visibility;
}

#endif

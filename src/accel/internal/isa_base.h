/* SPDX-License-Identifier: MIT */
/* The operations that traversals need from an instruction set, in plain C for any processor: the
 * reference for the others. An instruction set's header provides
 *
 *   struct box_ray            a ray for tests of boxes, with a member `tmin` and a member `scale`;
 *   box_ray_make              makes it from a ray;
 *   enter_node, enter_pair    which boxes of a node a struct box_ray enters, and at which t;
 *   test_item                 tests the block, or the single primitive, of an item.
 *
 * Nodes, blocks and counts are the same for all instruction sets. The rules of prim_test.h for
 * box_ray, for enter_node and for the intersections that test_item offers hold for each. */
#ifndef PEN_ACCEL_INTERNAL_ISA_BASE_H
#define PEN_ACCEL_INTERNAL_ISA_BASE_H

#include "accel/internal/boxes_base.h"

#endif

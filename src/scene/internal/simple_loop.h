/* SPDX-License-Identifier: MIT */
/* Whether a closed polygon in the plane is simple, that is, does not intersect or touch itself. */
#ifndef PEN_SCENE_INTERNAL_SIMPLE_LOOP_H
#define PEN_SCENE_INTERNAL_SIMPLE_LOOP_H

#include <stdbool.h>
#include <stdint.h>

#include "math/orient2d.h"

struct pen_simple_loop_result {
    bool simple;
    uint32_t edge[2]; /* if not simple: two edges, by their first vertex, that intersect or touch */
};

/* Checks a closed polygon. Edge i runs from point i to point i + 1, the last one back to point 0.
 * Points are distinct, and `order` lists them in the order of pen_point2_compare.
 * Fails: returns false when out of memory.
 * Cost: O(n log n). */
bool pen_check_simple_loop(const struct pen_point2 *points, const uint32_t *order, uint32_t count,
                           struct pen_simple_loop_result *result);

#endif

/* SPDX-License-Identifier: MIT */
/* The table of kinds, made of the list in geom/kind.h and the functions in the kinds' own files. */
#include "geom/kind.h"

#include "geom/internal/kinds.h"
#include "geom/prims.h"

const struct pen_kind pen_kinds[PEN_PRIM_KIND_COUNT] = {
#define KIND(NAME, member, word, shape_of, extent_of, most, cost_of)                               \
    [PEN_PRIM_##NAME] = {.name = (word),                                                           \
                         .shape = PEN_KIND_##shape_of,                                             \
                         .extent = PEN_KIND_##extent_of,                                           \
                         .most_intersections = (most),                                             \
                         .cost = (cost_of),                                                        \
                         .bytes = sizeof(struct pen_##member),                                     \
                         .fn = &pen_##member##_functions},
    PEN_KINDS(KIND)
#undef KIND
};

#define KIND(NAME, member, word, shape, extent, most, cost)                                        \
    _Static_assert((most) <= PEN_MOST_INTERSECTIONS, "struct pen_intersections has room");
PEN_KINDS(KIND)
#undef KIND

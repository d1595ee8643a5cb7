/* SPDX-License-Identifier: MIT */
/* Sample points without state: those of math/sample_lanes.h with one lane. */
#include "math/sample_lanes.h"

_Static_assert(LANES == 1, "this file is compiled for the base instruction set");

static uint64_t pair(uint32_t low, uint32_t high)
{
    return (uint64_t)high << 32 | low;
}

uint64_t pen_sample_hash(const struct pen_sample_key *key)
{
    uint64_t h = lanes_mix(key->seed + LANES_GOLDEN);
    h = lanes_mix((h ^ pair(key->x, key->y)) + LANES_GOLDEN);
    h = lanes_mix((h ^ pair(key->pixel_sample, key->node)) + LANES_GOLDEN);
    return lanes_mix((h ^ pair(key->purpose, key->light)) + LANES_GOLDEN);
}

static struct pen_point2 point(struct lanes_point2 p)
{
    return (struct pen_point2){p.x, p.y};
}

struct pen_point2 pen_sobol2(uint64_t hash, uint32_t index)
{
    return point(lanes_sobol2(hash, index));
}

struct pen_point2 pen_random2(uint64_t hash, uint32_t index)
{
    return point(lanes_random2(hash, index));
}

struct pen_point2 pen_grid2(uint64_t hash, uint32_t edge, uint32_t cell)
{
    struct pen_point2 within = pen_random2(hash, cell);
    return (struct pen_point2){(cell % edge + within.x) / edge,
                               (cell / edge % edge + within.y) / edge};
}

struct pen_point2 pen_disk_of_square(struct pen_point2 p)
{
    if (p.x == 0.5 && p.y == 0.5)
        return (struct pen_point2){0, 0};
    return point(lanes_disk_of_square((struct lanes_point2){p.x, p.y}));
}

/* SPDX-License-Identifier: MIT */
/* Random orders of runs. The same state gives the same order on every machine. */
#ifndef PEN_STUDY_INTERNAL_RANDOM_ORDER_H
#define PEN_STUDY_INTERNAL_RANDOM_ORDER_H

#include <stdint.h>

/* The next number of splitmix64.
 * Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. */
static inline uint64_t pen_random_next(uint64_t *state)
{
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Fills order[] with the numbers 0 .. count - 1 in a random order (Fisher-Yates shuffle). */
static inline void pen_random_order(int *order, int count, uint64_t *state)
{
    for (int i = 0; i < count; i++)
        order[i] = i;
    for (int i = count - 1; i > 0; i--) {
        const int j = (int)(pen_random_next(state) % (uint64_t)(i + 1)), moved = order[i];
        order[i] = order[j];
        order[j] = moved;
    }
}

#endif

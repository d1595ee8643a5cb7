/* SPDX-License-Identifier: MIT */
/* The operations that the types of lanes.h lack, for any processor. */
#ifndef PEN_ACCEL_INTERNAL_LANES_BASE_H
#define PEN_ACCEL_INTERNAL_LANES_BASE_H

#include "accel/internal/lanes.h"

/* The lanes that are set, as bits. */
static inline unsigned mask4_bits(const mask4 *m)
{
    unsigned bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= (unsigned)((*m)[i] & 1) << i;
    return bits;
}

static inline unsigned mask8_bits(const mask8 *m)
{
    unsigned bits = 0;
    for (int i = 0; i < 8; i++)
        bits |= (unsigned)((*m)[i] & 1) << i;
    return bits;
}

static inline void sqrt4(double4 *x)
{
    for (int i = 0; i < 4; i++)
        (*x)[i] = __builtin_sqrt((*x)[i]);
}

#endif

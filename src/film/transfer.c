/* SPDX-License-Identifier: MIT */
/* The sRGB transfer function, and 8-bit codes without computing a power for each value. The code is
 * a monotonic function of a binary32 value with 255 steps, so a table of the steps gives it
 * exactly. tests/film/test_transfer.c derives the table. */
#include <math.h>
#include <string.h>

#include "film/encode.h"
#include "math/fn.h"

#include "film/internal/transfer_tables.h"

/* Where the branches meet they agree to 3e-8; no step of 8 or 16 bits is that near. */
double pen_encode_srgb(double linear)
{
    if (linear <= 0.0031308)
        return 12.92 * linear;
    return 1.055 * pen_pow(linear, 1 / 2.4) - 0.055;
}

double pen_decode_srgb(double encoded)
{
    if (encoded <= 0.04045)
        return encoded / 12.92;
    return pen_pow((encoded + 0.055) / 1.055, 2.4);
}

double pen_encode_unit(double linear, enum pen_transfer transfer)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 1;
    return transfer == PEN_TRANSFER_SRGB ? pen_encode_srgb(linear) : linear;
}

/* Floats with the same upper bits form a cell, which has at most one step. The result is the code
 * of the cell's first float, plus one if the value is at or above the step. There are no branches,
 * as the values of neighbouring pixels make them hard to predict. */
static unsigned char srgb_8(float value)
{
    const float lowest = srgb_first_float, highest = srgb_steps[254];
    value = value > lowest ? value : lowest; /* NaN too */
    value = value < highest ? value : highest;
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    unsigned code = srgb_cells[(bits >> SRGB_CELL_SHIFT) - SRGB_FIRST_CELL];
    return (unsigned char)(code + (value >= srgb_steps[code]));
}

/* Rounds a value that is not negative to the nearest integer, halves up. */
static unsigned nearest(double value)
{
    return (unsigned)(value + 0.5);
}

void pen_encode_8(const float *linear, size_t count, enum pen_transfer transfer, unsigned char *out)
{
    if (transfer == PEN_TRANSFER_SRGB) {
        for (size_t i = 0; i < count; i++)
            out[i] = srgb_8(linear[i]);
        return;
    }
    for (size_t i = 0; i < count; i++)
        out[i] = (unsigned char)nearest(255 * pen_encode_unit((double)linear[i], transfer));
}

void pen_encode_16(const float *linear, size_t count, enum pen_transfer transfer, uint16_t *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = (uint16_t)nearest(65535 * pen_encode_unit((double)linear[i], transfer));
}

/* SPDX-License-Identifier: MIT */
/* The transfer function, and 8-bit values without a power each: the codes of a picture are the
 * 255 steps of a monotonic function of binary32, so a table of the steps decides exactly. */
#include <math.h>
#include <string.h>

#include "film/encode.h"
#include "math/fn.h"

#include "film/internal/transfer_tables.h"

/* At the joint both branches agree to 3e-8, far from a step of 8 or 16 bits. */
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

/* The code of the first float of a value's cell, and one more if the value is beyond the one step
 * that a cell has at most. No branches: neighbouring values would mislead them. */
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

/* The nearest integer, halves up: a cast truncates, and values are not negative. */
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

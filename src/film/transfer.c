/* SPDX-License-Identifier: MIT */
/* The sRGB transfer function, and codes without a power for each value. An 8-bit code is a
 * monotonic function of a binary32 value with 255 steps, so a table of the steps gives it exactly.
 * A 16-bit code comes from an approximation of the power. If that is so near to a step that its
 * error could matter, the power is computed. tests/film/test_transfer.c derives the tables. */
#include <math.h>
#include <string.h>

#include "film/encode.h"
#include "math/fn.h"

#include "film/internal/transfer_tables.h"

/* At the value where the branches meet they agree to 3e-8; no step of 8 or 16 bits is that near. */
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

/* Floats with the same upper bits form a cell, which contains at most one step. The result is the
 * code of the cell's first float, plus one if the value is at or above the step. There are no
 * branches, because the values of neighbouring pixels make them hard to predict. */
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

/* The largest error of the approximation of srgb_16, in codes; srgb_power derives it. */
static const double srgb_16_error = 0x1p-11;

/* For 0.0031308 < v = m 2^e < 1 the formula is A 2^(5e/12) m^(5/12) - B, with A = 65535 * 1.055 and
 * B = 65535 * 0.055 - 0.5, rounded down. Let r be the middle of the part of [1, 2) that contains m,
 * and t = m / r - 1. The series
 *     m^(5/12) = r^(5/12) (1 + 5/12 t - 35/288 t^2 + 665/10368 t^3 - …)
 * is cut off after the square. A part is 2^-7 wide, so |t| <= 2^-8. Each later term is below |t|
 * times the one before. So the rest is below 1.004 * 665/10368 * 2^-24 = 3.84e-9 of the whole. The
 * whole is below A = 69139.5, so this is 2.66e-4 codes. Roundings, of this and of the formula, add
 * less than 1e-10 codes. So the code is right if the value is 2^-11 = 4.9e-4 away from a step; one
 * value in a thousand is not.
 *
 * Returns A v^(1 / 2.4), with that error. */
static double srgb_power(double value)
{
    enum { FRACTION_BITS = 52, PART_BITS = 7, BIAS = 1023 };
    _Static_assert(SRGB_ROOTS == 1 << PART_BITS, "the parts of [1, 2)");
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const int exponent = (int)(bits >> FRACTION_BITS) - BIAS;
    const unsigned part = bits >> (FRACTION_BITS - PART_BITS) & (SRGB_ROOTS - 1);
    const uint64_t fraction = (bits & ((UINT64_C(1) << FRACTION_BITS) - 1)) | (uint64_t)BIAS
                                                                                  << FRACTION_BITS;
    double m;
    memcpy(&m, &fraction, sizeof m);
    const double t = m * srgb_roots[part].inverse - 1;
    const double root = srgb_roots[part].root * (1 + t * (5.0 / 12 - t * (35.0 / 288)));
    return srgb_powers[exponent - SRGB_FIRST_POWER] * root;
}

double pen_encode_unit_near(double linear, enum pen_transfer transfer)
{
    if (transfer == PEN_TRANSFER_SRGB && linear > 0.0031308 && linear < 1)
        return srgb_power(linear) / 65535 - 0.055;
    return pen_encode_unit(linear, transfer);
}

static uint16_t srgb_16(float value)
{
    const double offset = 65535 * 0.055 - 0.5;
    if ((double)value > 0.0031308 && value < 1) {
        const double code = srgb_power((double)value) - offset;
        const double above = code - (int)code;
        if (above > srgb_16_error && above < 1 - srgb_16_error)
            return (uint16_t)code;
    }
    return (uint16_t)nearest(65535 * pen_encode_unit((double)value, PEN_TRANSFER_SRGB));
}

void pen_encode_16(const float *linear, size_t count, enum pen_transfer transfer, uint16_t *out)
{
    if (transfer == PEN_TRANSFER_SRGB) {
        for (size_t i = 0; i < count; i++)
            out[i] = srgb_16(linear[i]);
        return;
    }
    for (size_t i = 0; i < count; i++)
        out[i] = (uint16_t)nearest(65535 * pen_encode_unit((double)linear[i], transfer));
}

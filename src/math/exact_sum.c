/* SPDX-License-Identifier: MIT */
/* Sums in fixed point. A register as wide as the range of products makes their sums exact.
 * Source: Kulisch, "Computer Arithmetic and Validity", 2nd ed. 2013, chapter 8. */
#include "math/exact_sum.h"

#include <math.h>
#include <string.h>

#include "math/scale.h"

enum { LOWEST = -3222 };

/* |x| = mantissa 2^exponent, for a finite x. */
static uint64_t split(double x, int *exponent)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    uint64_t fraction = bits & UINT64_C(0x000FFFFFFFFFFFFF);
    int biased = (int)(bits >> 52 & 0x7FF);
    *exponent = biased > 0 ? biased - 1075 : -1074;
    return biased > 0 ? fraction | UINT64_C(1) << 52 : fraction;
}

/* Multiplies digits (6 of 32 bits) by factor; the product fits. */
static void multiply(uint32_t digits[6], uint64_t factor)
{
    uint32_t product[6] = {0};
    const uint64_t half[2] = {factor & UINT32_MAX, factor >> 32};
    for (int j = 0; j < 2; j++) {
        uint64_t carry = 0;
        for (int i = 0; i + j < 6; i++) {
            carry += digits[i] * half[j] + product[i + j];
            product[i + j] = (uint32_t)carry;
            carry >>= 32;
        }
    }
    memcpy(digits, product, sizeof product);
}

void pen_exact_add(struct pen_exact_sum *sum, double a, double b, double c)
{
    int ea, eb, ec;
    uint64_t mantissa = split(a, &ea);
    uint32_t digits[6] = {(uint32_t)mantissa, (uint32_t)(mantissa >> 32)};
    multiply(digits, split(b, &eb));
    multiply(digits, split(c, &ec));
    int negative = (a < 0) ^ (b < 0) ^ (c < 0), at = ea + eb + ec - LOWEST;
    int64_t *limb = sum->limb + at / 32;
    for (int i = 0; i < 6; i++) {
        uint64_t shifted = (uint64_t)digits[i] << at % 32;
        int64_t low = (int64_t)(shifted & UINT32_MAX), high = (int64_t)(shifted >> 32);
        limb[i] += negative ? -low : low;
        limb[i + 1] += negative ? -high : high;
    }
}

/* Propagates carries: all limbs but the last become 0 ... 2^32 - 1, and the last one has the sum's
 * sign. */
static void carry(struct pen_exact_sum *sum)
{
    int64_t over = 0;
    for (int i = 0; i < PEN_EXACT_LIMBS - 1; i++) {
        int64_t with = sum->limb[i] + over, low = with & UINT32_MAX;
        sum->limb[i] = low;
        over = (with - low) / (INT64_C(1) << 32);
    }
    sum->limb[PEN_EXACT_LIMBS - 1] += over;
}

/* Makes the sum positive or zero. Returns its sign; *top is the highest limb that is not zero. */
static int normalize(struct pen_exact_sum *sum, int *top)
{
    int sign = 1;
    carry(sum);
    if (sum->limb[PEN_EXACT_LIMBS - 1] < 0) {
        sign = -1;
        for (int i = 0; i < PEN_EXACT_LIMBS; i++)
            sum->limb[i] = -sum->limb[i];
        carry(sum);
    }
    *top = PEN_EXACT_LIMBS - 1;
    while (*top >= 0 && sum->limb[*top] == 0)
        (*top)--;
    return *top < 0 ? 0 : sign;
}

double pen_exact_value(struct pen_exact_sum *sum, int *exponent)
{
    int top, sign;
    struct pen_exact_sum positive = *sum;
    *exponent = 0;
    sign = normalize(&positive, &top);
    if (sign == 0)
        return 0;
    double value = 0;
    for (int i = top; i > top - 3; i--)
        value = value * 0x1p32 + (i >= 0 ? (double)positive.limb[i] : 0);
    int e = pen_exponent(value);
    *exponent = e + 32 * (top - 2) + LOWEST;
    return sign * pen_scale2(value, -e);
}

int pen_exact_sign(struct pen_exact_sum *sum)
{
    int exponent;
    double value = pen_exact_value(sum, &exponent);
    return (value > 0) - (value < 0);
}

/* Subtracts value 2^exponent from the sum. */
static void subtract(struct pen_exact_sum *sum, double value, int exponent)
{
    int half = exponent / 2;
    pen_exact_add(sum, -value, pen_scale2(1, half), pen_scale2(1, exponent - half));
}

/* As pen_exact_direction. If `low` is not NULL, the result is subtracted from the sums, and *low
 * gets their rest. */
static struct pen_vec3 direction(struct pen_exact_sum sum[3], struct pen_vec3 *low)
{
    double value[3], rest[3] = {0, 0, 0};
    int exponent[3], most = 3 * LOWEST, below;
    for (int i = 0; i < 3; i++) {
        value[i] = pen_exact_value(&sum[i], &exponent[i]);
        most = value[i] != 0 && exponent[i] > most ? exponent[i] : most;
    }
    for (int i = 0; i < 3; i++) {
        if (low && value[i] != 0) {
            subtract(&sum[i], value[i], exponent[i]);
            rest[i] = pen_exact_value(&sum[i], &below);
            rest[i] = pen_scale2(rest[i], below - most);
        }
        value[i] = pen_scale2(value[i], exponent[i] - most);
    }
    if (low)
        *low = pen_vec3(rest[0], rest[1], rest[2]);
    return pen_vec3(value[0], value[1], value[2]);
}

struct pen_vec3 pen_exact_direction(struct pen_exact_sum sum[3])
{
    return direction(sum, NULL);
}

/* The sum of v[i] x v[i + 1] around the loop. Moving all points by one vector adds terms that
 * cancel exactly here. */
static void sum_normal(const struct pen_vec3 *v, uint32_t count, struct pen_exact_sum sum[3])
{
    for (uint32_t i = 0; i < count; i++) {
        struct pen_vec3 a = v[i], b = v[i + 1 < count ? i + 1 : 0];
        for (int axis = 0; axis < 3; axis++) {
            int y = (axis + 1) % 3, z = (axis + 2) % 3;
            pen_exact_add(&sum[axis], pen_component(a, y), pen_component(b, z), 1);
            pen_exact_add(&sum[axis], pen_component(a, z), pen_component(b, y), -1);
        }
    }
}

struct pen_vec3 pen_exact_normal(const struct pen_vec3 *v, uint32_t count)
{
    struct pen_exact_sum sum[3] = {{{0}}};
    sum_normal(v, count, sum);
    return direction(sum, NULL);
}

struct pen_vec3 pen_exact_normal_low(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 *low)
{
    struct pen_exact_sum sum[3] = {{{0}}};
    sum_normal(v, count, sum);
    return direction(sum, low);
}

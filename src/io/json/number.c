/* SPDX-License-Identifier: MIT */
/* Nearly all decimals of scenes have at most 19 digits, which fit into 64 bits, and few places
 * after the point. One division of integers gives their nearest double. strtod, which accepts any
 * number, takes several times as long. */
#include "io/json/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/scale.h"

__extension__ typedef unsigned __int128 wide;

/* 5^n, up to the largest that fits into 64 bits: each written number gives four powers. */
#define FOUR(five) UINT64_C(five), UINT64_C(five) * 5, UINT64_C(five) * 25, UINT64_C(five) * 125
static const uint64_t fives[] = {FOUR(1),
                                 FOUR(625),
                                 FOUR(390625),
                                 FOUR(244140625),
                                 FOUR(152587890625),
                                 FOUR(95367431640625),
                                 FOUR(59604644775390625)};
#undef FOUR

/* All numbers with at most this number of digits fit into 64 bits. */
enum { DIGITS_MAX = 19 };

enum { FIVES = sizeof fives / sizeof fives[0] };

/* Numbers with more places or larger exponents are left to strtod. */
enum { EXPONENT_MAX = 1000 };

static bool is_digit(const char *text, size_t at, size_t end)
{
    return at < end && text[at] >= '0' && text[at] <= '9';
}

/* Appends the digits at `at` to the decimal and returns their end. */
static size_t scan_digits(const char *text, size_t at, size_t end, struct pen_json_decimal *out)
{
    uint64_t digits = out->digits;
    while (digits == 0 && at < end && text[at] == '0')
        at++;
    size_t first = at;
    for (; is_digit(text, at, end); at++)
        digits = digits * 10 + (uint64_t)(text[at] - '0');
    out->digits = digits;
    out->length += at - first;
    return at;
}

/* Reads an exponent after the E. Returns `at` if it has no digits. */
static size_t scan_exponent(const char *text, size_t at, size_t end, struct pen_json_decimal *out)
{
    bool negative = at < end && text[at] == '-';
    size_t first = at + (at < end && (text[at] == '-' || text[at] == '+')), next = first;
    int exponent = 0;
    for (; is_digit(text, next, end); next++) {
        if (exponent > EXPONENT_MAX)
            out->cut = true;
        else
            exponent = exponent * 10 + (text[next] - '0');
    }
    out->exponent += negative ? -exponent : exponent;
    return next > first ? next : at;
}

/* Reads sign, digits, fraction and exponent. With `java`, also a plus sign, leading zeros, and a
 * point with digits on one side only. */
static size_t scan(const char *text, size_t offset, size_t end, bool java,
                   struct pen_json_decimal *out)
{
    *out = (struct pen_json_decimal){.negative = offset < end && text[offset] == '-'};
    bool plus = java && offset < end && text[offset] == '+';
    size_t first = offset + (out->negative || plus), at = scan_digits(text, first, end, out), start;
    bool digits = at > first;
    if (!java && (!digits || (text[first] == '0' && at > first + 1)))
        return offset;
    out->integer = true;
    if (at < end && text[at] == '.') {
        out->integer = false;
        at = scan_digits(text, start = at + 1, end, out);
        if (at == start && !(java && digits))
            return offset;
        digits = true;
        out->cut = out->cut || at - start > EXPONENT_MAX;
        out->exponent = out->cut ? 0 : -(int)(at - start);
    }
    if (digits && at < end && (text[at] == 'e' || text[at] == 'E')) {
        out->integer = false;
        at = scan_exponent(text, start = at + 1, end, out);
        if (at == start)
            return offset;
    }
    return digits ? at : offset;
}

size_t pen_json_scan_number(const char *text, size_t offset, size_t end,
                            struct pen_json_decimal *out)
{
    return scan(text, offset, end, false, out);
}

size_t pen_java_scan_number(const char *text, size_t offset, size_t end,
                            struct pen_json_decimal *out, size_t *bytes)
{
    size_t at = scan(text, offset, end, true, out);
    bool suffix = at > offset && at < end && strchr("fFdD", text[at]) != NULL && text[at] != '\0';
    *bytes = at - offset;
    return at + suffix;
}

/* n 2^exponent, rounded to nearest, ties to even. It is rounded in integers, because a program that
 * embeds this one may have set another rounding mode. Scaling is exact: the doubles made here are
 * far from the ends of their range. */
static double nearest_double(uint64_t n, int exponent)
{
    int drop = 64 - 53 - __builtin_clzll(n);
    if (drop > 0) {
        uint64_t half = UINT64_C(1) << (drop - 1), rest = n & (2 * half - 1);
        n >>= drop;
        n += rest > half || (rest == half && (n & 1));
        exponent += drop;
    }
    return pen_scale2((double)n, exponent);
}

/* digits / 10^places. Digits and 5^places are shifted until their highest bits are set, and divided
 * as integers. The quotient has 63 or 64 bits, 10 more than a double. So it is rounded correctly if
 * its last bit is also set for a remainder. */
static double divide(uint64_t digits, int places)
{
    int up = __builtin_clzll(digits), up5 = __builtin_clzll(fives[places]);
    uint64_t divisor = fives[places] << up5;
    wide dividend = (wide)(digits << up) << 63;
    uint64_t quotient = (uint64_t)(dividend / divisor);
    quotient |= (uint64_t)dividend != quotient * divisor;
    return nearest_double(quotient, up5 - up - 63 - places);
}

bool pen_json_nearest(const struct pen_json_decimal *decimal, double *out)
{
    uint64_t product;
    int exponent = decimal->exponent;
    double value = 0;
    if (decimal->cut || decimal->length > DIGITS_MAX)
        return false;
    if (decimal->digits > 0) {
        if (exponent <= -FIVES || exponent >= FIVES)
            return false;
        if (exponent < 0)
            value = divide(decimal->digits, -exponent);
        else if (!__builtin_mul_overflow(decimal->digits, fives[exponent], &product))
            value = nearest_double(product, exponent);
        else
            return false;
    }
    *out = decimal->negative ? -value : value;
    return true;
}

/* The value with these bits. It is made unless one of the recent values is the same. */
static json_t *share(struct pen_json_numbers *numbers, bool integer, uint64_t bits)
{
    if (!numbers->recent && !(numbers->recent = calloc(PEN_JSON_RECENT, sizeof *numbers->recent)))
        return NULL;
    const size_t slot =
        ((bits ^ integer) * UINT64_C(0x9E3779B97F4A7C15)) >> 54; /* below PEN_JSON_RECENT */
    struct pen_json_recent *recent = &numbers->recent[slot];
    json_t *value = recent->value;
    if (value && recent->bits == bits && json_is_integer(value) == integer)
        return json_incref(value);
    double real;
    memcpy(&real, &bits, sizeof real);
    json_t *made = integer ? json_integer((json_int_t)bits) : json_real(real);
    if (made) {
        json_decref(value);
        recent->value = json_incref(made);
        recent->bits = bits;
    }
    return made;
}

/* Whether it is an integer that fits into 64 bits. */
static bool is_whole(const struct pen_json_decimal *decimal)
{
    return decimal->integer && decimal->length <= DIGITS_MAX &&
           decimal->digits <= (uint64_t)INT64_MAX + decimal->negative;
}

bool pen_json_number(struct pen_json_numbers *numbers, const char *text, size_t bytes,
                     const struct pen_json_decimal *decimal, json_t **out)
{
    double real;
    uint64_t bits = decimal->negative ? -decimal->digits : decimal->digits;
    *out = NULL;
    if (!is_whole(decimal)) {
        if (!pen_json_nearest(decimal, &real)) {
            numbers->scratch.bytes = 0;
            if (!pen_buf_add(&numbers->scratch, text, bytes))
                return true;
            real = strtod((char *)numbers->scratch.data, NULL);
        }
        if (!isfinite(real))
            return false;
        memcpy(&bits, &real, sizeof bits);
    }
    *out = share(numbers, is_whole(decimal), bits);
    return true;
}

void pen_json_numbers_release(struct pen_json_numbers *numbers)
{
    for (size_t i = 0; numbers->recent && i < PEN_JSON_RECENT; i++)
        json_decref(numbers->recent[i].value);
    free(numbers->recent);
    numbers->recent = NULL;
    pen_buf_release(&numbers->scratch);
}

/* SPDX-License-Identifier: MIT */
/* The numbers of JSON text, and of XML attributes, which may have Java's syntax. */
#ifndef PEN_IO_JSON_NUMBER_H
#define PEN_IO_JSON_NUMBER_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"

/* A number as written: digits * 10^exponent. */
struct pen_json_decimal {
    bool negative;
    bool integer;    /* without fraction and exponent */
    bool cut;        /* `exponent` cannot hold the exponent or the number of places */
    uint64_t digits; /* wrapped around if there are more than 19 digits */
    size_t length;   /* number of digits, without leading zeros */
    int exponent;
};

/* Reads the number by RFC 8259, section 6, that begins at `offset`, up to `end` at most. Returns
 * its end; `offset` if there is no number. */
size_t pen_json_scan_number(const char *text, size_t offset, size_t end,
                            struct pen_json_decimal *out);

/* The same for a decimal number in the syntax of Java's Double.parseDouble: also .5, 60., +20, 007
 * and 50.0f, but not NaN, Infinity and hexadecimal numbers. *bytes becomes its length without the
 * suffix, for pen_json_number. */
size_t pen_java_scan_number(const char *text, size_t offset, size_t end,
                            struct pen_json_decimal *out, size_t *bytes);

/* The double nearest to a decimal. Returns false for the few decimals that are left to strtod. */
bool pen_json_nearest(const struct pen_json_decimal *decimal, double *out);

enum { PEN_JSON_RECENT = 1024 };

struct pen_json_recent {
    uint64_t bits; /* of the integer or double */
    json_t *value; /* NULL: none yet */
};

/* Makes values of numbers; {0} has made none. Scenes repeat their numbers: several faces share the
 * corners of a mesh, and 0 and 1 are frequent. A recently made number is not made again; its
 * reference count is increased, which saves memory. So the values of numbers must not be changed.
 */
struct pen_json_numbers {
    struct pen_json_recent *recent; /* PEN_JSON_RECENT, by a hash; NULL before the first number */
    struct pen_buf scratch;
};

/* The value of a number of `bytes` bytes, in the locale "C": an integer if it fits into 64 bits,
 * else a double.
 * Owns: the caller json_decref()s *out.
 * Fails: returns false if the number overflows a double; *out is NULL when out of memory. */
bool pen_json_number(struct pen_json_numbers *numbers, const char *text, size_t bytes,
                     const struct pen_json_decimal *decimal, json_t **out);

void pen_json_numbers_release(struct pen_json_numbers *numbers);

#endif

/* SPDX-License-Identifier: MIT */
/* The sRGB transfer function, and the codes of 8 and 16 bits, against their formula. This test also
 * derives the table src/film/internal/transfer_tables.h and compares it with the stored one; to
 * write the table: PEN_WRITE_TABLES=1 build/tests/film/test_transfer */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "film/encode.h"
#include "math/fn.h"
#include "support/random.h"
#include "support/suite.h"

static const char path[] = "src/film/internal/transfer_tables.h";

/* Floats with equal upper bits form a cell. There are 128 cells in each power of two, which is fine
 * enough that none has two steps; comparing with the formula at every step checks this. */
enum { CELL_SHIFT = 16 };

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* The formula of api/scene-format.md and film/encode.h, word for word. */
static unsigned formula(double v, double max, enum pen_transfer transfer)
{
    double e = transfer == PEN_TRANSFER_SRGB ? pen_encode_srgb(v) : v;
    double clamped = e > 1 ? 1 : e > 0 ? e : 0;
    return (unsigned)floor(max * clamped + 0.5);
}

/* The smallest float whose code exceeds `code`, of the codes 0 to max. */
static float step_above(unsigned code, double max)
{
    uint32_t lo = 0, hi = bits_of(1.0f);
    while (hi - lo > 1) {
        uint32_t middle = lo + (hi - lo) / 2;
        if (formula((double)float_of(middle), max, PEN_TRANSFER_SRGB) > code)
            hi = middle;
        else
            lo = middle;
    }
    return float_of(hi);
}

/* v^(5/12) for v = m 2^e: m is in one of 128 parts of [1, 2), and e is -9 to -1. */
static void derive_roots(struct pen_buf *out)
{
    pen_buf_puts(out,
                 "/* Parts of [1, 2), by the upper bits of a float's fraction: the middle m of\n"
                 " * each as m^(5/12) and 1 / m. */\n"
                 "enum { SRGB_ROOTS = 128 };\n"
                 "static const struct {\n    double root, inverse;\n"
                 "} srgb_roots[SRGB_ROOTS] = {\n");
    for (int i = 0; i < 128; i++) {
        double middle = 1 + (i + 0.5) / 128;
        pen_buf_printf(out, "{%a, %a},%s", pen_pow(middle, 1 / 2.4), 1 / middle,
                       i == 127 ? "};\n\n" : " ");
    }
    pen_buf_puts(out, "/* 65535 * 1.055 * 2^(5/12 e), for e from SRGB_FIRST_POWER to -1. */\n"
                      "enum { SRGB_FIRST_POWER = -9 };\n"
                      "static const double srgb_powers[9] = {\n");
    for (int e = -9; e < 0; e++)
        pen_buf_printf(out, "%a,%s", 65535 * 1.055 * pen_pow(ldexp(1, e), 1 / 2.4),
                       e == -1 ? "};\n\n" : " ");
}

static void derive(struct pen_buf *out)
{
    uint32_t first = bits_of(step_above(0, 255)) >> CELL_SHIFT;
    uint32_t end = (bits_of(step_above(254, 255)) >> CELL_SHIFT) + 1;
    pen_buf_puts(out,
                 "/* SPDX-License-Identifier: MIT */\n"
                 "/* The steps of 8-bit sRGB, and values for 16-bit sRGB. Written by\n"
                 " * tests/film/test_transfer.c, which finds the steps by bisection; not edited\n"
                 " * by hand. */\n"
                 "#ifndef PEN_FILM_INTERNAL_TRANSFER_TABLES_H\n"
                 "#define PEN_FILM_INTERNAL_TRANSFER_TABLES_H\n\n");
    pen_buf_printf(out,
                   "/* Floats with equal bits above the lowest SRGB_CELL_SHIFT are a cell. */\n"
                   "enum { SRGB_CELL_SHIFT = %d, SRGB_FIRST_CELL = %u, SRGB_CELLS = %u };\n\n",
                   CELL_SHIFT, first, end - first);
    pen_buf_printf(out, "static const float srgb_first_float = %af;\n\n",
                   (double)float_of(first << CELL_SHIFT));
    pen_buf_puts(out, "/* srgb_steps[c] is the smallest float whose value is above c. */\n"
                      "static const float srgb_steps[256] = {\n");
    for (unsigned c = 0; c < 255; c++)
        pen_buf_printf(out, "%af, ", (double)step_above(c, 255));
    pen_buf_puts(out, "0x1p+127f};\n\n");
    pen_buf_puts(out, "/* The value of a cell's first float. */\n"
                      "static const unsigned char srgb_cells[SRGB_CELLS] = {\n");
    for (uint32_t cell = first; cell < end; cell++) {
        float value = float_of(cell << CELL_SHIFT);
        pen_buf_printf(out, "%u,%s", formula((double)value, 255, PEN_TRANSFER_SRGB),
                       cell + 1 == end ? "};\n\n" : " ");
    }
    derive_roots(out);
    pen_buf_puts(out, "#endif\n");
}

/* Removes white space, which clang-format may change. */
static void strip(struct pen_buf *buf)
{
    size_t kept = 0;
    for (size_t i = 0; i < buf->bytes; i++) {
        if (!strchr(" \n", buf->data[i]))
            buf->data[kept++] = buf->data[i];
    }
    buf->bytes = kept;
    buf->data[kept] = '\0';
}

START_TEST(test_transfer__table_equals_its_derivation)
{
    struct pen_buf derived = {0}, stored = {0};
    derive(&derived);
    if (getenv("PEN_WRITE_TABLES")) {
        FILE *out = fopen(path, "w");
        ck_assert_ptr_nonnull(out);
        ck_assert_uint_eq(fwrite(derived.data, 1, derived.bytes, out), derived.bytes);
        ck_assert_int_eq(fclose(out), 0);
    }
    FILE *file = fopen(path, "r");
    ck_assert_msg(file != NULL, "cannot read %s; run this from the top folder", path);
    char piece[4096];
    for (size_t bytes; (bytes = fread(piece, 1, sizeof piece, file)) > 0;)
        pen_buf_add(&stored, piece, bytes);
    fclose(file);
    strip(&derived);
    strip(&stored);
    ck_assert_msg(stored.bytes == derived.bytes &&
                      memcmp(stored.data, derived.data, derived.bytes) == 0,
                  "%s differs from its derivation", path);
    pen_buf_release(&derived);
    pen_buf_release(&stored);
}
END_TEST

static void check_8(float v)
{
    unsigned char srgb, linear;
    pen_encode_8(&v, 1, PEN_TRANSFER_SRGB, &srgb);
    pen_encode_8(&v, 1, PEN_TRANSFER_LINEAR, &linear);
    if (srgb != formula((double)v, 255, PEN_TRANSFER_SRGB) ||
        linear != formula((double)v, 255, PEN_TRANSFER_LINEAR))
        ck_abort_msg("%a: srgb %u, linear %u", (double)v, srgb, linear);
}

static void check_16(float v)
{
    uint16_t srgb, linear;
    pen_encode_16(&v, 1, PEN_TRANSFER_SRGB, &srgb);
    pen_encode_16(&v, 1, PEN_TRANSFER_LINEAR, &linear);
    if (srgb != formula((double)v, 65535, PEN_TRANSFER_SRGB) ||
        linear != formula((double)v, 65535, PEN_TRANSFER_LINEAR))
        ck_abort_msg("%a: srgb %u, linear %u", (double)v, srgb, linear);
}

/* Every float within 300 of a step, and the first and last float of every cell. PEN_EXHAUSTIVE=1
 * tests all 2^30 floats up to 1, which takes minutes. */
START_TEST(test_transfer__codes_of_8_bits_follow_the_formula)
{
    uint32_t end = bits_of(1.0f) + 1000;
    if (getenv("PEN_EXHAUSTIVE")) {
        for (uint32_t bits = 0; bits < end; bits++)
            check_8(float_of(bits));
        return;
    }
    for (unsigned c = 0; c < 255; c++) {
        uint32_t step = bits_of(step_above(c, 255));
        for (uint32_t bits = step - 300; bits < step + 300; bits++)
            check_8(float_of(bits));
    }
    for (uint32_t bits = 0; bits < end; bits += 1u << CELL_SHIFT) {
        check_8(float_of(bits));
        check_8(float_of(bits + (1u << CELL_SHIFT) - 1));
    }
    struct random r = random_begin(1);
    for (int i = 0; i < 1000000; i++) {
        check_8(float_of(random_below(&r, end)));
        check_8((float)random_in(&r, 0, 1));
    }
}
END_TEST

START_TEST(test_transfer__the_quick_formula_is_near)
{
    static const double edge[] = {-1, 0, 0.0031308, 0.00313081, 0.00390625, 0.5, 1, 1.5};
    for (size_t i = 0; i < sizeof edge / sizeof *edge; i++)
        ck_assert(fabs(pen_encode_unit_near(edge[i], PEN_TRANSFER_SRGB) -
                       pen_encode_unit(edge[i], PEN_TRANSFER_SRGB)) < 5e-9);
    for (int i = 0; i < 1000000; i++) {
        const double v = (i + 0.37) * 1e-6;
        ck_assert(fabs(pen_encode_unit_near(v, PEN_TRANSFER_SRGB) -
                       pen_encode_unit(v, PEN_TRANSFER_SRGB)) < 5e-9);
        ck_assert(pen_encode_unit_near(v, PEN_TRANSFER_LINEAR) == v);
    }
}
END_TEST

/* Both floats at each step, where an approximation that is wrong by more than its bound gives the
 * wrong code on one side; the ends of the parts of [1, 2) that the table has, where it is worst;
 * and the floats where the curve begins. */
START_TEST(test_transfer__codes_of_16_bits_follow_the_formula)
{
    struct random r = random_begin(2);
    uint32_t step = 1;
    for (unsigned c = 0; c < 65535; c++) {
        while (formula((double)float_of(step + 4096), 65535, PEN_TRANSFER_SRGB) <= c)
            step += 4096;
        uint32_t lo = step, hi = step + 4096;
        while (hi - lo > 1) {
            uint32_t middle = lo + (hi - lo) / 2;
            bool above = formula((double)float_of(middle), 65535, PEN_TRANSFER_SRGB) > c;
            *(above ? &hi : &lo) = middle;
        }
        check_16(float_of(lo));
        check_16(float_of(hi));
        step = lo;
    }
    for (uint32_t bits = 0; bits < bits_of(1.0f); bits += 1u << CELL_SHIFT) {
        check_16(float_of(bits));
        check_16(float_of(bits + (1u << CELL_SHIFT) - 1));
    }
    for (uint32_t bits = bits_of(0.0031308f) - 1000; bits < bits_of(0.0031308f) + 1000; bits++)
        check_16(float_of(bits));
    for (int i = 0; i < 300000; i++)
        check_16((float)random_in(&r, 0, 1.01));
}
END_TEST

START_TEST(test_transfer__values_outside_the_range_are_clamped)
{
    const float below[] = {-0.0f, -1e-30f, -1, -INFINITY, NAN, 1e-45f, 0};
    const float above[] = {1, 1.5f, 1e30f, INFINITY, 0x1.fffffep-1f};
    for (int transfer = 0; transfer < 2; transfer++) {
        for (size_t i = 0; i < sizeof below / sizeof below[0]; i++) {
            unsigned char v8 = 7;
            uint16_t v16 = 7;
            pen_encode_8(&below[i], 1, (enum pen_transfer)transfer, &v8);
            pen_encode_16(&below[i], 1, (enum pen_transfer)transfer, &v16);
            ck_assert(v8 == 0 && v16 == 0);
        }
        for (size_t i = 0; i < sizeof above / sizeof above[0]; i++) {
            unsigned char v8 = 7;
            uint16_t v16 = 7;
            pen_encode_8(&above[i], 1, (enum pen_transfer)transfer, &v8);
            pen_encode_16(&above[i], 1, (enum pen_transfer)transfer, &v16);
            ck_assert(v8 == 255 && v16 == 65535);
        }
        ck_assert(pen_encode_unit(NAN, (enum pen_transfer)transfer) == 0);
        ck_assert(pen_encode_unit(-INFINITY, (enum pen_transfer)transfer) == 0);
        ck_assert(pen_encode_unit(INFINITY, (enum pen_transfer)transfer) == 1);
    }
}
END_TEST

/* Against libm, and against values from the tables of the standard. */
START_TEST(test_transfer__srgb_follows_the_standard)
{
    ck_assert(pen_encode_srgb(0) == 0 && fabs(pen_encode_srgb(1) - 1) < 1e-15);
    ck_assert(fabs(pen_encode_srgb(0.5) - 0.7353569830524495) < 1e-15);
    ck_assert(fabs(pen_encode_srgb(0.001) - 0.01292) < 1e-17);
    ck_assert(fabs(pen_decode_srgb(0.5) - 0.21404114048223255) < 1e-15);
    for (int i = 0; i <= 100000; i++) {
        double v = i * 1e-5;
        double exact = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
        if (!(fabs(pen_encode_srgb(v) - exact) < 1e-15 &&
              fabs(pen_decode_srgb(pen_encode_srgb(v)) - v) < 1e-7))
            ck_abort_msg("%a", v);
    }
    for (unsigned c = 0; c < 256; c++) { /* decoding and encoding a code gives the code */
        float v = (float)pen_decode_srgb(c / 255.0);
        unsigned char code;
        pen_encode_8(&v, 1, PEN_TRANSFER_SRGB, &code);
        ck_assert_uint_eq(code, c);
    }
}
END_TEST

PEN_SUITE("transfer", test_transfer__table_equals_its_derivation,
          test_transfer__codes_of_8_bits_follow_the_formula,
          test_transfer__the_quick_formula_is_near,
          test_transfer__codes_of_16_bits_follow_the_formula,
          test_transfer__values_outside_the_range_are_clamped,
          test_transfer__srgb_follows_the_standard)

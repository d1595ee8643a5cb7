/* SPDX-License-Identifier: MIT */
/* Derives src/math/internal/fn_tables.h in __float128 (113 bits), and compares the file in the tree
 * with the result. To write the file: PEN_WRITE_TABLES=1 build/tests/math/test_fn_tables */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "support/suite.h"

__extension__ typedef __float128 quad;
quad acosq(quad x);
quad cosq(quad x);
quad expq(quad x);
quad ldexpq(quad x, int e);
quad logq(quad x);
quad rintq(quad x);

enum { EXP_STEPS = 128, LOG_STEPS = 128 };

static const char path[] = "src/math/internal/fn_tables.h";

static const char head[] =
    "/* SPDX-License-Identifier: MIT */\n"
    "/* Constants and tables of fn.c. Written by tests/math/test_fn_tables.c, which derives them\n"
    " * in 113-bit arithmetic; not edited by hand. */\n"
    "#ifndef PEN_MATH_INTERNAL_FN_TABLES_H\n"
    "#define PEN_MATH_INTERNAL_FN_TABLES_H\n\n"
    "enum { EXP_STEPS = 128, LOG_STEPS = 128 };\n\n";

static double on_grid(quad x, int e)
{
    return (double)ldexpq(rintq(ldexpq(x, -e)), e);
}

/* Splits a number into hi, the nearest multiple of 2^e, and the rest. */
static void split(struct pen_buf *out, const char *name, quad value, int e)
{
    double hi = on_grid(value, e);
    pen_buf_printf(out, "static const double %s_HI = %a, %s_LO = %a;\n", name, hi, name,
                   (double)(value - hi));
}

static void write_constants(struct pen_buf *out)
{
    quad ln2 = logq(2), half_pi = acosq(0);
    pen_buf_printf(out, "static const double STEPS_PER_UNIT = %a; /* EXP_STEPS / ln 2 */\n\n",
                   (double)(EXP_STEPS / ln2));
    pen_buf_puts(out,
                 "/* ln 2 / EXP_STEPS; integers below 2^18 times the first part are exact */\n");
    split(out, "STEP", ln2 / EXP_STEPS, -42);
    pen_buf_puts(out, "\n/* ln 2; the first part is a multiple of 2^-42, as log_hi below */\n");
    split(out, "LN2", ln2, -42);
    pen_buf_puts(out, "\n/* pi / 180; the first part has 26 bits */\n");
    split(out, "DEGREE", half_pi / 90, -31);
    pen_buf_printf(out, "\nstatic const double QUARTERS_PER_RADIAN = %a; /* 2 / pi */\n\n",
                   (double)(1 / half_pi));
    pen_buf_puts(out,
                 "/* pi / 2 in parts; integers below 2^20 times all but the last are exact */\n");
    quad rest = half_pi;
    for (int i = 1; i <= 3; i++) {
        double part = on_grid(rest, 1 - 33 * i);
        pen_buf_printf(out, "static const double HALF_PI_%d = %a;\n", i, part);
        rest -= part;
    }
    rest += cosq(half_pi); /* what half_pi itself lacks */
    pen_buf_printf(out, "static const double HALF_PI_4 = %a;\n", (double)rest);
}

static void write_exp_table(struct pen_buf *out)
{
    pen_buf_puts(out,
                 "\n/* 2^(i / EXP_STEPS) = value (1 + tail), value the nearest double. */\n"
                 "static const struct {\n    double value, tail;\n} exp_table[EXP_STEPS] = {\n");
    for (int i = 0; i < EXP_STEPS; i++) {
        quad exact = expq(i * logq(2) / EXP_STEPS);
        double value = (double)exact;
        pen_buf_printf(out, "    {%a, %a},\n", value, (double)(exact / value - 1));
    }
    pen_buf_puts(out, "};\n");
}

/* The middle of a cell: the cells cut the bit patterns of [LOG_FIRST, 2 LOG_FIRST) evenly, and 1
 * is the middle of one. */
static double cell_middle(int i)
{
    uint64_t bits = UINT64_C(0x3fe6900000000000) + ((2 * (uint64_t)i + 1) << 44);
    double middle;
    memcpy(&middle, &bits, sizeof middle);
    return middle;
}

static void write_log_table(struct pen_buf *out)
{
    pen_buf_puts(
        out, "\n/* The bits of the double where the first cell begins; each cell is 2^45\n"
             " * doubles wide, and 1 is the middle of its cell. */\n"
             "#define LOG_FIRST UINT64_C(0x3fe6900000000000)\n\n"
             "/* inverse: of the cell's middle, a multiple of 2^-11, so that products with\n"
             " * numbers of 42 bits are exact. -ln(inverse) = log_hi + log_lo, the first part a\n"
             " * multiple of 2^-42. */\n"
             "static const struct {\n    double inverse, log_hi, log_lo;\n"
             "} log_table[LOG_STEPS] = {\n");
    for (int i = 0; i < LOG_STEPS; i++) {
        double inverse = on_grid(1 / (quad)cell_middle(i), -11);
        quad exact = -logq(inverse);
        double hi = on_grid(exact, -42);
        pen_buf_printf(out, "    {%a, %a, %a},\n", inverse, hi, (double)(exact - hi));
    }
    pen_buf_puts(out, "};\n\n#endif\n");
}

static bool read_file(struct pen_buf *out)
{
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    char piece[4096];
    for (size_t bytes; (bytes = fread(piece, 1, sizeof piece, file)) > 0;)
        pen_buf_add(out, piece, bytes);
    fclose(file);
    return !out->failed;
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

START_TEST(test_fn_tables__equal_their_derivation)
{
    struct pen_buf derived = {0}, stored = {0};
    pen_buf_puts(&derived, head);
    write_constants(&derived);
    write_exp_table(&derived);
    write_log_table(&derived);
    ck_assert(!derived.failed);
    if (getenv("PEN_WRITE_TABLES")) {
        FILE *file = fopen(path, "w");
        ck_assert_ptr_nonnull(file);
        ck_assert_uint_eq(fwrite(derived.data, 1, derived.bytes, file), derived.bytes);
        ck_assert_int_eq(fclose(file), 0);
    }
    ck_assert_msg(read_file(&stored), "cannot read %s; run this from the top folder", path);
    strip(&derived);
    strip(&stored);
    ck_assert_msg(stored.bytes == derived.bytes &&
                      memcmp(stored.data, derived.data, derived.bytes) == 0,
                  "%s differs from its derivation", path);
    pen_buf_release(&derived);
    pen_buf_release(&stored);
}
END_TEST

PEN_SUITE("fn_tables", test_fn_tables__equal_their_derivation)

/* SPDX-License-Identifier: MIT */
/* The frame of the stability suite: a row is a property that must hold in every case drawn for it.
 *
 * A row has a function that draws cases (lists of numbers) and a function that judges a case. The
 * frame draws as many cases as asked, makes failing cases smaller, keeps the worst, counts and
 * measures. Case i of a row is a pure function of (seed, row, i): it does not depend on the number
 * of processes or on where a run began. Judging depends only on the case, so a stored case is a
 * lasting test. */
#ifndef TESTS_PROPERTY_ROW_H
#define TESTS_PROPERTY_ROW_H

#include <stdbool.h>
#include <stdint.h>

#include "support/random.h"

typedef struct pen_vec3 vec3;

enum {
    ROW_ARGS = 48,   /* numbers in a case */
    ROW_ERRORS = 8,  /* measurements in one case */
    ROW_SERIES = 12, /* measured quantities in one row */
    ROW_TALLIES = 16,
    ROW_BINS = 162, /* of a histogram: below 2^-8, quarter octaves up to 2^32, beyond */
    ROW_KEPT = 4,   /* failing cases kept, of those made smaller */
    ROW_NAME = 56,
    ROW_WHY = 240
};

/* The arguments of one case. The first `fixed` arguments are choices (which primitive, which
 * scene), which must not be changed a little. count 0: no case could be drawn. */
struct row_case {
    int count, fixed;
    double arg[ROW_ARGS];
};

struct row_error {
    const char *series;
    double value, bound;
};

/* The result of judging a case. */
struct row_verdict {
    bool failed;
    bool skipped; /* the property does not apply to this case */
    char why[ROW_WHY];
    int errors, tallies;
    struct row_error error[ROW_ERRORS];
    const char *tally[ROW_ERRORS];
};

/* What a case is drawn from. */
struct row_draw {
    struct random random; /* of this case alone */
    uint64_t index;       /* of the case */
};

typedef void row_draw_fn(struct row_draw *draw, struct row_case *c);
typedef void row_judge_fn(const struct row_case *c, struct row_verdict *v);

enum row_status { ROW_TESTED, ROW_INAPPLICABLE, ROW_PENDING };

struct pen_row_run;

/* One row of the table. */
struct row {
    const char *id;     /* of the catalogue: "H038 H039" */
    const char *name;   /* as in test_property__h038_watertight */
    const char *what;   /* what must hold, in a sentence */
    const char *oracle; /* the judge that is independent of the code under test */
    enum row_status status;
    const char *why; /* for rows that are not tested */
    void (*run)(struct pen_row_run *run);
    uint64_t full;     /* cases of a full run; 0: 1e6 */
    uint64_t check;    /* cases in `make check`; 0: 1e4 */
    const char *known; /* a defect under repair that this row shows; NULL: none */
};

/* A measured quantity: its distribution over all cases, and the case with the largest value. */
struct row_series {
    char name[ROW_NAME];
    uint64_t count, over, bin[ROW_BINS];
    double bound, max;
    struct row_case worst;
};

struct row_tally {
    char name[ROW_NAME];
    uint64_t count;
};

struct row_kept {
    struct row_case as_drawn, small;
    char why[ROW_WHY];
    uint64_t index;
};

/* The result of a run; plain data, added up over processes. */
struct row_result {
    uint64_t tried, skipped, failures, replayed;
    double cpu_s;
    int series_count, tally_count, kept_count, crashed;
    struct row_series series[ROW_SERIES];
    struct row_tally tally[ROW_TALLIES];
    struct row_kept kept[ROW_KEPT];
};

struct corpus;

/* One run of one row, or of a range of its cases. */
struct pen_row_run {
    const struct row *row;
    uint64_t seed, first, cases;
    const struct corpus *corpus; /* cases to replay first; may be NULL */
    struct row_result *result;
};

/* Row i of the table; NULL behind the last. */
const struct row *row_at(int i);
enum { ROWS_MAX = 256 };

/* The loop of nearly every row. It replays the corpus, then draws cases first ... first + cases -
 * 1, judges them, and makes the failing cases smaller. */
void row_each(struct pen_row_run *run, row_draw_fn *draw, row_judge_fn *judge);

/* Runs a row, with its time. */
void row_run(struct pen_row_run *run);

/* Building a case. */
void row_arg(struct row_case *c, double x);
void row_arg3(struct row_case *c, vec3 v);
/* Adds an argument that shrinking leaves alone; these come first. */
void row_fixed(struct row_case *c, double x);

/* Reads the next argument, in the same order; `at` counts arguments from 0. */
double row_next(const struct row_case *c, int *at);
vec3 row_next3(const struct row_case *c, int *at);

/* Adds a measurement to a verdict. A value above its bound, or NaN, fails the case; bound < 0: only
 * measured. Names must be string literals or live as long as the program. */
void row_measure(struct row_verdict *v, const char *series, double value, double bound);
void row_tally(struct row_verdict *v, const char *name);
void row_fail(struct row_verdict *v, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Fails unless `holds`. */
bool row_require(struct row_verdict *v, bool holds, const char *what);
void row_skip(struct row_verdict *v);

/* For rows that judge without row_each. */
void row_take(struct pen_row_run *run, uint64_t index, const struct row_case *c,
              const struct row_verdict *v);

/* Adds the result of a process. */
void row_result_add(struct row_result *to, const struct row_result *from);

/* Returns the value below which the share `part` of a series is, to a quarter octave; 0 if
 * exact. */
double row_quantile(const struct row_series *s, double part);
/* The lower end of a bin. */
double row_bin_begin(int bin);

/* Writes the numbers of a case as hex floats with spaces between them; returns the length as
 * snprintf does. */
int row_print(char *text, size_t size, const struct row_case *c);

#endif

/* SPDX-License-Identifier: MIT */
/* Reads the members of a report, and writes its values as people read them. A member that is
 * missing or of the wrong type reads as 0, "" or an empty list. */
#ifndef PEN_STUDY_INTERNAL_REPORT_VALUES_H
#define PEN_STUDY_INTERNAL_REPORT_VALUES_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"

/* A member by its path, keys between dots: "rays.total". NULL if there is none. */
const json_t *pen_bench_report_member(const json_t *object, const char *path);
double pen_bench_report_number(const json_t *object, const char *path);
const char *pen_bench_report_string(const json_t *object, const char *path);

/* The rows of a report. */
size_t pen_bench_report_row_count(const json_t *report);
const json_t *pen_bench_report_row(const json_t *report, size_t row);

/* Appends the value of a setting as text without quotes. */
void pen_bench_write_value(const json_t *value, struct pen_buf *out);

/* Appends a number with three significant digits if it is below 100, else without decimals.
 * `separator` stands between groups of thousands: 0.123, 12.3, 12 345. */
void pen_bench_write_number(double value, const char *separator, struct pen_buf *out);

/* Appends a row's settings in words: "none, 2 threads, light_samples 64". */
void pen_bench_write_row_name(const json_t *row, struct pen_buf *out);

/* Appends the number of threads that worked on a row, beside the setting if the two differ: "2",
 * "all 2", "2 of 8". */
void pen_bench_write_threads(const json_t *row, struct pen_buf *out);

/* Appends a row's speed-up over the baseline: "1.25×". */
void pen_bench_write_speedup(const json_t *row, struct pen_buf *out);

/* Appends a ratio with its interval, if it has one: "0.982 (0.976–0.991)". */
void pen_bench_write_ratio(const json_t *ratio, struct pen_buf *out);

/* Appends what the baseline's twin tells, and why the repeats ended. */
void pen_bench_write_noise(const json_t *report, struct pen_buf *out);

/* Appends how the times were measured. */
void pen_bench_write_method(const json_t *report, struct pen_buf *out);

/* Appends "AMD EPYC, avx2, 2 cores, 2 threads in the pool, Penumbra 0.1.0, kernel …; load average
 * …". */
void pen_bench_write_host(const json_t *report, struct pen_buf *out);

/* A column of a table: what it shows of a row. One of number, count and write is set. */
struct pen_bench_column {
    const char *title;
    const char *number; /* the path of a number, shown as by pen_bench_write_number */
    const char *count;  /* the path of a whole number, shown with all its digits */
    void (*write)(const json_t *row, struct pen_buf *out);
    bool words; /* aligned left */
};

/* Appends what the column shows of the row; nothing if the row has no such number. */
void pen_bench_column_write(const struct pen_bench_column *column, const json_t *row,
                            struct pen_buf *out);

extern const struct pen_bench_column pen_bench_time_columns[]; /* end with a NULL title */
extern const struct pen_bench_column pen_bench_ray_columns[];

#endif

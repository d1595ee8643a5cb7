/* SPDX-License-Identifier: MIT */
/* Looking into a report, and writing its figures for people. What is missing, or of the wrong
 * type, reads as nothing: 0, "", an empty list. */
#ifndef PEN_STUDY_INTERNAL_READ_H
#define PEN_STUDY_INTERNAL_READ_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"

/* A member by its path, keys between dots: "rays.total". NULL if it is not there. */
const json_t *pen_study_at(const json_t *object, const char *path);
double pen_study_number(const json_t *object, const char *path);
int pen_study_count(const json_t *object, const char *path); /* -1 if it is no int */
bool pen_study_has(const json_t *object, const char *path);  /* and it is a number */
const char *pen_study_text(const json_t *object, const char *path);

/* The rows of a report. */
size_t pen_study_row_count(const json_t *report);
const json_t *pen_study_row(const json_t *report, size_t row);

/* Appends the value of a setting as text without quotes. */
void pen_write_value(const json_t *value, struct pen_buf *out);

/* Appends a number with three digits that count, thousands apart by `gap`: 0.123, 12.3, 12 345. */
void pen_write_figure(double value, const char *gap, struct pen_buf *out);

/* Appends a row's settings in words: "none, 2 threads, light_samples 64". */
void pen_write_row_name(const json_t *row, struct pen_buf *out);

/* Appends the number of threads that a row asks for, and of those that worked: "all 2". */
void pen_write_threads(const json_t *row, struct pen_buf *out);

/* Appends what is known of a row's picture: "reference", "identical", "max 0.0123, rmse 0.00045".
 */
void pen_write_picture(const json_t *row, struct pen_buf *out);

/* Appends the sentence that says how the times were taken. */
void pen_write_method(const json_t *report, struct pen_buf *out);

/* Appends "AMD EPYC, avx2, 2 cores, 2 threads in the pool, Penumbra 0.1.0; load …". */
void pen_write_host(const json_t *report, struct pen_buf *out);

/* The figures of a row that tables show, behind its settings. */
struct pen_column {
    const char *title;
    void (*write)(const json_t *row, struct pen_buf *out);
};
extern const struct pen_column pen_time_columns[]; /* end with a NULL title */
extern const struct pen_column pen_ray_columns[];

#endif

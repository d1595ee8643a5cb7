/* SPDX-License-Identifier: MIT */
/* Reads the members of a report, and writes values for readers. A member that is missing or of the
 * wrong type reads as 0, "" or an empty list. */
#ifndef PEN_REPORT_VALUES_H
#define PEN_REPORT_VALUES_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"

/* A member by its path: keys and list indices, separated by dots, as in "rays.total" or
 * "interval.0". NULL if there is none. */
const json_t *pen_report_member(const json_t *object, const char *path);
double pen_report_number(const json_t *object, const char *path);
const char *pen_report_string(const json_t *object, const char *path);
bool pen_report_has_number(const json_t *object, const char *path);

/* A member as a whole number. -1 if it is not a number from 0 to INT_MAX. */
int pen_report_whole(const json_t *object, const char *path);

/* The rows of a report. */
size_t pen_report_row_count(const json_t *report);
const json_t *pen_report_row(const json_t *report, size_t row);

/* Appends a JSON value as text. A string has no quotes. */
void pen_write_value(const json_t *value, struct pen_buf *out);

/* Appends a number with three significant digits if it is below 100, else without decimals. Groups
 * of thousands are separated by spaces: 0.123, 12.3, 12 345. */
void pen_write_number(double value, struct pen_buf *out);

/* Appends a whole number with all its digits, in groups. */
void pen_write_count(double value, struct pen_buf *out);

/* Appends settings in words: "light_samples 64, light_pattern grid". A target error of 0 is left
 * out. With a target error above 0, the numbers of samples are left out, since they have no effect.
 */
void pen_write_settings(const json_t *settings, struct pen_buf *out);

/* Appends the settings of a row in words. */
void pen_write_row_name(const json_t *row, struct pen_buf *out);

/* Appends a ratio with its interval, if it has one: "0.982 (0.976–0.991)".
 */
void pen_write_ratio(const json_t *ratio, struct pen_buf *out);

/* Appends a description of the host: "AMD EPYC, avx2, 2 cores, 2 threads in the pool, Penumbra
 * 0.1.0, kernel …; load average …". */
void pen_write_host(const json_t *report, struct pen_buf *out);

/* Appends the number of spoiled runs and the reason. If over half are spoiled, also `withheld`,
 * which names the missing results. Returns whether any run is spoiled. */
bool pen_write_spoiled(const json_t *report, const char *withheld, struct pen_buf *out);

/* Appends each text of a list as a line that starts with `begin`. */
void pen_write_list(const json_t *list, const char *begin, struct pen_buf *out);

/* Appends a line with the settings that all rows share. */
void pen_write_shared(const json_t *report, struct pen_buf *out);

#endif

/* SPDX-License-Identifier: MIT */
/* What the formats of an accuracy report have in common: sentences and columns. Each function
 * appends words without markup; out->failed tells that memory ran out. */
#ifndef PEN_STUDY_INTERNAL_ACCURACY_WORDS_H
#define PEN_STUDY_INTERNAL_ACCURACY_WORDS_H

#include "study/internal/report_values.h"

/* "RMSE", "FLIP", … of a metric's name. */
const char *pen_accuracy_metric_title(const char *metric);

/* Whether over half of the runs are spoiled. Then the answer is that, and all formats begin with
 * it.
 */
bool pen_accuracy_is_spoiled(const json_t *report);

/* Which row meets the target, and what to write to get it; or what would be needed. */
void pen_accuracy_write_answer(const json_t *report, struct pen_buf *out);

/* How times and errors were measured; of the reference; of the forecast. */
void pen_accuracy_write_method(const json_t *report, struct pen_buf *out);
void pen_accuracy_write_reference(const json_t *report, struct pen_buf *out);
void pen_accuracy_write_forecast(const json_t *report, struct pen_buf *out);

/* How fast the error falls, or which error is left, of one member of `convergence`. */
void pen_accuracy_write_slope(const json_t *series, struct pen_buf *out);

/* The settings of an object in words: "light_samples 64, light_pattern grid". */
void pen_accuracy_write_settings(const json_t *settings, struct pen_buf *out);

/* Appends an error with three significant digits. */
void pen_accuracy_write_error(double error, struct pen_buf *out);

/* Whether the row is the recommended one. */
bool pen_accuracy_is_recommended(const json_t *report, const json_t *row);

extern const struct pen_bench_column pen_accuracy_columns[]; /* end with a NULL title */

#endif

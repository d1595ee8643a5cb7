/* SPDX-License-Identifier: MIT */
/* The plots of an accuracy report, as SVG elements. The page's style sheet sets the colours, by
 * class. Each function appends to `out`; out->failed tells that memory ran out. */
#ifndef PEN_STUDY_INTERNAL_ACCURACY_PLOT_H
#define PEN_STUDY_INTERNAL_ACCURACY_PLOT_H

#include <jansson.h>

#include "base/buf.h"

/* Error against time, both logarithmic, with the Pareto front as a line; `metric` is rmse or
 * flip. With `style`, the element has its own colours, to stand in a file. */
void pen_accuracy_plot_time(const json_t *report, const char *metric, bool style,
                            struct pen_buf *out);

/* RMSE against the number of samples, with the fitted lines; nothing without convergence. */
void pen_accuracy_plot_convergence(const json_t *report, struct pen_buf *out);

#endif

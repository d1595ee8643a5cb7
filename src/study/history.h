/* SPDX-License-Identifier: MIT */
/* The history of a scene's times: many reports of benchmarks in chronological order, and the points
 * where times changed.
 *
 * Rows of the reports form one series if all their settings, views and numbers of primitives are
 * equal. Change points are searched for among the points of one host, since hosts differ for other
 * reasons.
 *
 * Pettitt's test compares the ranks of the medians before a point with the ranks from that point
 * on. It accepts a change if at most 5 % of 999 random orders of the same medians reach the
 * statistic. The medians of both sides must also differ by the least effect. The change is placed
 * at the point at which the values of both sides lie closest to their medians. Then both sides are
 * searched in the same way (binary segmentation). The random orders have a fixed seed, so the same
 * reports give the same history. With fewer than 8 points of a host there is no change, since too
 * many of their orders look like one.
 * Source: Pettitt, "A non-parametric approach to the change-point problem", Applied Statistics 28,
 * 1979. */
#ifndef PEN_STUDY_HISTORY_H
#define PEN_STUDY_HISTORY_H

#include <jansson.h>

#include "base/status.h"

/* Finds the change points of `count` values, and writes them to at[] in rising order. At a change
 * point i, the values from i on differ from the values before. `least_effect` is the least ratio of
 * two medians that counts, minus 1. Returns the number of change points; -1 when out of memory.
 * Shape: at[] has place for `count` numbers. */
int pen_history_changes(const double *values, int count, double least_effect, int *at);

/* Makes the history of reports that pen_comparison_check accepts. Returns an object:
 *    kind     "history"
 *    scene, least_effect
 *    hosts    [the `host` members of the reports' hosts, each once]
 *    reports  [{began_at, version, build, host}], by time; host is an index into `hosts`
 *    rows     [{settings, points: [{report, median_ms, low_ms, high_ms, calibrated}],
 *             changes: [{point, before_ms, after_ms, ratio}]}]
 * low_ms and high_ms are the ends of a 95 % interval, or null. `calibrated` is the median divided
 * by the median of the report's calibration, or null.
 * Owns: the caller json_decref()s.
 * Fails: NULL; PEN_INVALID (no reports, or reports of several scenes, which the message names),
 * PEN_NO_MEMORY. */
json_t *pen_history_new(json_t *const *reports, int count, double least_effect,
                        struct pen_status *st);

#endif

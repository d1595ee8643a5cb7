/* SPDX-License-Identifier: MIT */
/* The history of a scene's times: many reports of benchmarks in the order of time, and where times
 * have changed.
 *
 * Rows of the reports are one series if all settings, the views and the number of primitives agree.
 * Change points are searched for among the points of one host, since others differ for other
 * reasons. There is a change if the medians before some point rank unlike those from it on by more
 * than in 95 % of 999 random orders of the same medians (Pettitt, "A non-parametric approach to the
 * change-point problem", Applied Statistics 28, 1979), and if the medians of both sides differ by
 * the least effect. It is at the point that leaves the medians of both sides closest around their
 * middle. Then both sides are searched likewise (binary segmentation). The orders are drawn from a
 * fixed seed: the same reports give the same history.
 * Fewer than 8 points of a host show no change: too many of their orders look like one. */
#ifndef PEN_STUDY_HISTORY_H
#define PEN_STUDY_HISTORY_H

#include <jansson.h>

#include "base/status.h"

/* Finds the change points of `count` values: writes them in rising order to at[], which has place
 * for `count`, and returns how many there are. A change at i: the values from i on are other than
 * those before. `least_effect`: the medians' ratio minus 1. Returns -1 when out of memory. */
int pen_history_changes(const double *values, int count, double least_effect, int *at);

/* The history of reports that pen_comparison_check accepts. Returns an object:
 *   kind     "history"
 *   scene, least_effect
 *   hosts    [the `host` members of the reports' hosts, each once]
 *   reports  [{began_at, version, build, host}], in the order of time; host is a number in `hosts`
 *   rows     [{settings, points: [{report, median_ms, low_ms, high_ms, calibrated}], changes:
 *            [{point, before_ms, after_ms, ratio}]}]; low_ms and high_ms of a 95 % interval or
 * null; calibrated: the median over that of the report's calibration, or null Owns: the caller
 * json_decref()s. Fails: NULL; PEN_INVALID (no reports, or of several scenes, which it names),
 * PEN_NO_MEMORY. */
json_t *pen_history_new(json_t *const *reports, int count, double least_effect,
                        struct pen_status *st);

#endif

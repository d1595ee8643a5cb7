/* SPDX-License-Identifier: MIT */
/* Compares two reports of benchmarks, or two accuracy studies, of one scene, made by different
 * builds or on different hosts.
 *
 * Rows are matched by their settings: those that both reports state must be equal. What a run
 * counts (rays by kind, box and primitive tests) and its pictures must be exactly equal, on any
 * host. Times advise: the interval of the ratio of medians follows from that of each median, each
 * with half of the 5 %, since runs of different reports make no pairs; and there is a verdict only
 * if both reports are of one host, and if the calibrated times have the same one. For other hosts
 * there is the calibrated ratio: each time is divided by that of the calibration on its own host.
 */
#ifndef PEN_STUDY_COMPARISON_H
#define PEN_STUDY_COMPARISON_H

#include <jansson.h>

#include "base/status.h"

/* Checks that a document is a report of a benchmark or an accuracy study. Fails: PEN_INVALID. */
bool pen_comparison_check(const json_t *report, struct pen_status *st);

/* Compares two reports that pen_comparison_check accepts. Returns an object:
 *   kind      "comparison"
 *   scene     its name
 *   before, after   {began_at, version, build}
 *   host_differences   the members of `host` in which they differ; empty: one host
 *   rows      [{settings, threads, before_ms, after_ms, ratio, calibrated_ratio, verdict,
 *             reason, picture, differences, errors}], where
 *             picture is "same", "different" or "unknown",
 *             differences is [{counter, before, after}],
 *             errors is {rmse: [before, after], flip: [before, after]} of accuracy studies, or null
 *   missing, added   the settings of rows that only one report has
 *   counters  "same" or "different"
 *   pictures  "same", "different" or "unknown"
 *   slower    rows
 *
 * Owns: the caller json_decref()s. Fails: NULL; PEN_INVALID (different scenes, views or numbers of
 * primitives; no row in common), PEN_NO_MEMORY. */
json_t *pen_comparison_new(const json_t *before, const json_t *after, struct pen_status *st);

/* What a comparison finds that a build must not change: counters, pictures, and rows if `time` that
 * are slower. Fails: PEN_DIFFERENT, and the message says what. */
bool pen_comparison_judge(const json_t *comparison, bool time, struct pen_status *st);

#endif

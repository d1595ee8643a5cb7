/* SPDX-License-Identifier: MIT */
/* Compares two reports of benchmarks, or two accuracy studies, of one scene. They may come from
 * different builds or hosts.
 *
 * Rows are matched by their settings: each setting that both reports have must be equal. The counts
 * of a run (rays by kind, box and primitive tests) and its pictures must be exactly equal, on any
 * host.
 *
 * Times lead to a verdict, but need not be equal. Runs of different reports do not form pairs. So
 * the interval of the ratio of two medians follows from the interval of each median, which may err
 * with half of the 5 %. There is a verdict only for reports of one host, and only if the calibrated
 * times give the same verdict. A calibrated time is a time divided by the time of the calibration
 * on the same host. Reports of different hosts get a calibrated ratio and no verdict. */
#ifndef PEN_STUDY_COMPARISON_H
#define PEN_STUDY_COMPARISON_H

#include <jansson.h>

#include "base/status.h"

/* Checks that a document is a report of a benchmark or an accuracy study.
 * Fails: PEN_INVALID. */
bool pen_comparison_check(const json_t *report, struct pen_status *st);

/* Compares two reports that pen_comparison_check accepts. Returns an object:
 *    kind              "comparison"
 *    scene             its name
 *    before, after     {began_at, version, build}
 *    host_differences  the members of `host` that differ; empty: the same host
 *    rows              [{settings, threads, before_ms, after_ms, ratio, calibrated_ratio, verdict,
 *                      reason, picture, differences, errors}], where
 *                      picture is "same", "different" or "unknown",
 *                      differences is [{counter, before, after}],
 *                      errors is {rmse: [before, after], flip: [before, after]} of accuracy
 *                      studies, or null
 *    missing, added    the settings of rows that only one report has
 *    counters          "same" or "different"
 *    pictures          "same", "different" or "unknown"
 *    slower            the number of rows that are slower
 * Owns: the caller json_decref()s.
 * Fails: NULL; PEN_INVALID (different kinds, scenes, views or numbers of primitives; no row in
 * common), PEN_NO_MEMORY. */
json_t *pen_comparison_new(const json_t *before, const json_t *after, struct pen_status *st);

/* Checks that a comparison finds no difference that a new build must not have: in counters, in
 * pictures and, if `time` is set, in rows that are slower.
 * Fails: PEN_DIFFERENT; the message names the difference. */
bool pen_comparison_judge(const json_t *comparison, bool time, struct pen_status *st);

#endif

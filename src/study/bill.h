/* SPDX-License-Identifier: MIT */
/* What each effect of a scene costs and changes: the scene is rendered as it is, and with each of
 * its effects left out in turn (leave_out.h). Runs are interleaved: a pass visits every row, so
 * that a change of the machine's load meets all rows alike. One pass to warm up is thrown away. A
 * run that is spoiled (run_time.h) is repeated, twice at most; if it stays spoiled, its time does
 * not count. If over half of the runs are spoiled, no cost is told. */
#ifndef PEN_STUDY_BILL_H
#define PEN_STUDY_BILL_H

#include <jansson.h>

#include "base/buf.h"
#include "io/scene_json.h"
#include "study/run_time.h"
#include "study/study.h"

struct pen_bill_row {
    unsigned effect;           /* the one that is left out; 0: none */
    struct pen_run_time *runs; /* of rendering, by pass */
    struct pen_row_time time;
    struct pen_ray_counts rays;
    const char *kernel;
    /* From the whole picture: film/metrics.h, and the mean of film/flip.h. */
    double rmse, max_error, flip;
    float *rgb;    /* the picture */
    uint64_t hash; /* of it: pen_film_hash; only where it is kept */
};

/* What to do; everything is borrowed. */
struct pen_bill_task {
    struct pen_study_frame frame;
    const struct pen_settings *settings;
    int view, repeats; /* repeats: 1 .. PEN_RUN_TIMES_MAX */
};

struct pen_bill {
    const struct pen_bill_task *task;
    struct pen_bill_row row[PEN_FX_COUNT + 1]; /* row 0 has all effects */
    int rows;
    struct pen_runs_use use; /* of the processors, by all runs */
    /* Of the last render with all effects. */
    struct pen_render_stats whole;
    struct pen_accel_stats accel;
    double build_ms;
};

/* The effects of one view that a bill leaves out in turn: all that it calls for, without those
 * whose absence would change nothing. */
unsigned pen_bill_effects(const struct pen_scene_desc *desc, int view,
                          const struct pen_settings *settings);

/* How many pictures a bill of these effects keeps, and how many renders it takes. */
static inline int pen_bill_pictures(unsigned effects)
{
    return 1 + __builtin_popcount(effects);
}
static inline int pen_bill_runs(unsigned effects, int repeats)
{
    return pen_bill_pictures(effects) * (repeats + 1);
}

/* Checks each render by pen_limits_check, the rays of all renders together without those of forking
 * paths, and the size of the pictures. Fails: PEN_TOO_LARGE, at the place `at`. */
bool pen_bill_check(const struct pen_limits *limits, const struct pen_scene_desc *desc, int view,
                    const struct pen_settings *settings, int repeats, const char *at,
                    struct pen_status *st);

/* Makes the bill. Owns: release *bill in any case. Fails: PEN_NO_MEMORY, PEN_CANCELLED,
 * PEN_UNAVAILABLE (`between` has ended it); as pen_scene_freeze. */
bool pen_bill_make(const struct pen_bill_task *task, struct pen_bill *bill, struct pen_status *st);
void pen_bill_release(struct pen_bill *bill);

/* The report as JSON, without pictures. `scene` is the scene's name. Fails: NULL when out of
 * memory.
 */
json_t *pen_bill_json(const struct pen_bill *bill, const char *scene);

/* Appends the pictures of the report's page: the whole one, and that without each effect. */
void pen_bill_figures(const struct pen_bill *bill, struct pen_buf *out);

#endif

/* SPDX-License-Identifier: MIT */
/* The bill: the time that each effect of a scene costs, and its effect on the picture. The scene is
 * rendered as it is, and with each of its effects left out in turn (leave_out.h).
 *
 * A pass visits every row, so that a change of the machine's load affects all rows alike. The first
 * pass is a warm-up, and its times are discarded. A spoiled run (run_time.h) is repeated at most
 * twice. If it stays spoiled, its time does not count. If over half of the runs are spoiled, the
 * report gives no costs. */
#ifndef PEN_STUDY_BILL_H
#define PEN_STUDY_BILL_H

#include <jansson.h>

#include "base/buf.h"
#include "io/scene_json.h"
#include "study/run_time.h"
#include "study/study.h"

/* The results of one row. */
struct pen_bill_row {
    unsigned effect;           /* the effect that is left out; 0: none */
    struct pen_run_time *runs; /* of rendering, one for each pass */
    struct pen_row_time time;
    struct pen_ray_counts rays;
    const char *kernel;
    /* Against the picture of row 0: film/metrics.h, and the mean of film/flip.h. */
    double rmse, max_error, flip;
    float *rgb;    /* the picture */
    uint64_t hash; /* pen_film_hash of rgb; only set if the study may be saved */
};

/* The input of a bill. Everything is borrowed. */
struct pen_bill_task {
    struct pen_study_frame frame;
    const struct pen_settings *settings;
    int view, repeats; /* repeats: 1 .. PEN_RUN_TIMES_MAX */
};

/* The results of a bill. */
struct pen_bill {
    const struct pen_bill_task *task;
    struct pen_bill_row row[PEN_FX_COUNT + 1]; /* row 0 has all effects */
    int rows;
    struct pen_runs_use use; /* how much of the processors all runs got */
    /* Of the last render with all effects. */
    struct pen_render_stats whole;
    struct pen_accel_stats accel;
    double build_ms;
};

/* The effects of one view that a bill leaves out in turn: all effects that the view calls for and
 * whose absence changes something. */
unsigned pen_bill_effects(const struct pen_scene_desc *desc, int view,
                          const struct pen_settings *settings);

/* The number of pictures of a bill with these effects, and the number of its renders. */
static inline int pen_bill_pictures(unsigned effects)
{
    return 1 + __builtin_popcount(effects);
}
static inline int pen_bill_runs(unsigned effects, int repeats)
{
    return pen_bill_pictures(effects) * (repeats + 1);
}

/* Checks the limits of a bill: of one render (pen_limits_check), of the primary and shadow rays of
 * all renders together (pen_work_per_pixel), and of the pixels of all pictures.
 * Fails: PEN_TOO_LARGE, at the place `at`; as pen_limits_check. */
bool pen_bill_check(const struct pen_limits *limits, const struct pen_scene_desc *desc, int view,
                    const struct pen_settings *settings, int repeats, const char *at,
                    struct pen_status *st);

/* Makes the bill.
 * Owns: release *bill, after success and after failure.
 * Fails: PEN_NO_MEMORY, PEN_CANCELLED, PEN_UNAVAILABLE (frame.between returned false); as
 * pen_scene_freeze. */
bool pen_bill_make(const struct pen_bill_task *task, struct pen_bill *bill, struct pen_status *st);
void pen_bill_release(struct pen_bill *bill);

/* Makes the report as JSON (api/openapi.yaml, schema Bill), without pictures. `scene` is the
 * scene's name.
 * Owns: the caller json_decref()s.
 * Fails: NULL when out of memory. */
json_t *pen_bill_json(const struct pen_bill *bill, const char *scene);

/* Appends the pictures of the report's page: with all effects, and without each effect.
 * Fails: out->failed is set when out of memory. */
void pen_bill_figures(const struct pen_bill *bill, struct pen_buf *out);

#endif

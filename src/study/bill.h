/* SPDX-License-Identifier: MIT */
/* What each effect of a scene costs and changes: the scene is rendered as it is, and with each of
 * its effects left out in turn (leave_out.h). Runs are interleaved: a pass visits every row, so
 * that a change of the machine's load meets all rows alike. One pass to warm up is thrown away. */
#ifndef PEN_STUDY_BILL_H
#define PEN_STUDY_BILL_H

#include <jansson.h>

#include "base/buf.h"
#include "render/render.h"

struct pen_bill_row {
    unsigned effect; /* the one that is left out; 0: none */
    double *runs_ms; /* times of rendering, by pass */
    double median_ms, min_ms, max_ms;
    struct pen_ray_counts rays;
    const char *kernel;
    double rmse, max_error; /* from the whole picture: film/metrics.h */
    float *rgb;             /* the picture */
};

/* What to do; everything is borrowed. */
struct pen_bill_task {
    const struct pen_scene_desc *desc;
    const struct pen_settings *settings;
    int view, repeats; /* repeats: at least 1 */
    struct pen_thread_pool *pool;
    const atomic_bool *cancel; /* may be NULL */
    /* Called between runs, with done = 0 before the first; may be NULL. */
    void (*progress)(void *user, int done, int total);
    void *user;
};

struct pen_bill {
    const struct pen_bill_task *task;
    struct pen_bill_row row[PEN_FX_COUNT + 1]; /* row 0 has all effects */
    int rows;
};

/* Makes the bill. Owns: release *bill in any case. Fails: PEN_NO_MEMORY, PEN_CANCELLED; as
 * pen_scene_freeze. */
bool pen_bill_make(const struct pen_bill_task *task, struct pen_bill *bill, struct pen_status *st);
void pen_bill_release(struct pen_bill *bill);

/* The bill as JSON, without pictures. `scene` is the scene's name. Fails: NULL when out of memory.
 */
json_t *pen_bill_json(const struct pen_bill *bill, const char *scene);

/* Appends a report: "text" for a terminal, "csv", "md", "json", or "html": one page without
 * references to other files, with the pictures beside bars of time. Fails: PEN_NO_MEMORY. */
bool pen_bill_write(const struct pen_bill *bill, const char *scene, const char *format,
                    struct pen_buf *out, struct pen_status *st);

#endif

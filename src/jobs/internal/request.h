/* SPDX-License-Identifier: MIT */
/* Reads and checks a submission: a job, or a bare scene, which is a job with all defaults. Errors
 * of the job's own keys and of its scene are collected together. */
#ifndef PEN_JOBS_INTERNAL_REQUEST_H
#define PEN_JOBS_INTERNAL_REQUEST_H

#include "io/document.h"
#include "jobs/accuracy_spec.h"
#include "jobs/bench_spec.h"
#include "jobs/internal/kind.h"
#include "jobs/jobs.h"
#include "render/layers.h"
#include "scene/desc.h"

enum {
    PEN_JOB_NAME_CHARACTERS = 200,
    PEN_JOB_LABELS = 32,
    PEN_JOB_TEXT_BYTES = 8192, /* of name and labels together, as JSON text */
    PEN_BUDGET_SECONDS_MAX = 86400
};

struct pen_request {
    struct pen_arena *arena;        /* of desc */
    struct pen_document document;   /* the body, parsed */
    json_t *body;                   /* the document's JSON; the document owns it */
    struct pen_document own;        /* the parsed scene that the body names, or has as XML text */
    const struct pen_document *has; /* the document with the scene: `document` or `own` */
    const json_t *scene;            /* the scene's values in this document */
    const char *scene_text;         /* the text of the scene; NULL: not found in the body */
    size_t scene_bytes;
    const char *scene_at; /* JSON Pointer to it in the body: "" or "/scene" */
    bool bare;            /* the body is the scene */
    bool explain;         /* explain the body */
    bool analyze;         /* render it too, to compare */
    struct pen_scene_desc desc;
    struct pen_settings settings; /* the scene's, overridden by the job's */
    int priority, max_attempts;
    int timeout_max_s, priority_max; /* what the operator allows */
    int64_t timeout_ms;
    const json_t *name;   /* NULL: none */
    const json_t *labels; /* NULL: none */
    const json_t *layers; /* NULL: the beauty alone */
    bool cost_layer;      /* `layers` has the cost, of this kind */
    enum pen_cost cost;
    int audit_pixels; /* 0: no audit */
    double audit_threshold;
    double budget_seconds; /* of a render; 0: none */
    enum pen_job_kind kind;
    struct pen_bench_spec spec; /* of a benchmark */
    struct pen_accuracy_spec accuracy;
    int repeats; /* of a job of kind "effects" */
    int view_count;
    int *views; /* indices into desc.views; in arena */
};

/* Reads and checks a submission.
 * Owns: release *out, after success and after failure. It has pointers into in->body.
 * Fails: errors->count > 0. */
bool pen_request_read(const struct pen_submission *in, const struct pen_limits *limits,
                      struct pen_request *out, struct pen_errors *errors);
void pen_request_release(struct pen_request *request);

/* Returns the time of a render's layers, as a multiple of the time of its pixels:
 * pen_layer_work. */
double pen_request_layer_work(const struct pen_request *request);

/* request_keys.c: reads the keys of a job, without scene, render, views and the keys of a
 * benchmark. request->body must be an object. */
void pen_request_keys_read(struct pen_request *request, struct pen_errors *errors);

#endif

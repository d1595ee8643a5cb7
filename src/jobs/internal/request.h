/* SPDX-License-Identifier: MIT */
/* What a client sent, read and checked: a job, or a bare scene, which is a job of defaults. All
 * errors of both the job's own keys and its scene are collected together. */
#ifndef PEN_JOBS_INTERNAL_REQUEST_H
#define PEN_JOBS_INTERNAL_REQUEST_H

#include "io/document.h"
#include "jobs/benchmark.h"
#include "jobs/internal/jobs.h"
#include "scene/desc.h"

enum { PEN_JOB_NAME_BYTES = 200, PEN_JOB_LABELS = 32 };

struct pen_request {
    struct pen_arena *arena;      /* of desc */
    struct pen_document document; /* what was sent */
    json_t *body;                 /* the same as JSON; borrowed */
    json_t *builtin;              /* the built-in scene it names, parsed; else NULL */
    const json_t *scene;          /* the scene document, in body or builtin */
    const char *scene_at;         /* its place in the body: "" or "/scene" */
    bool bare;
    struct pen_scene_desc desc;
    struct pen_settings settings; /* the scene's, and the job's on top */
    int priority, max_attempts;
    int64_t timeout_ms;   /* 0: none */
    const json_t *name;   /* NULL: none */
    const json_t *labels; /* NULL: none */
    const char *kind;
    bool benchmark;
    struct pen_bench_spec order; /* of a benchmark */
    int view_count;
    int *views; /* indices into desc.views; in arena */
};

/* Reads and checks. Returns false with errors->count > 0. Release in any case. */
bool pen_request_read(const struct pen_submission *in, const struct pen_limits *limits,
                      struct pen_request *out, struct pen_errors *errors);
void pen_request_release(struct pen_request *request);

/* request_keys.c: the keys of a job but scene and views. `body` is an object. */
void pen_request_keys_read(struct pen_request *request, struct pen_errors *errors);

/* Adds an error at a place below `up`: up/key. The key is escaped as RFC 6901 says. */
void pen_request_fail(struct pen_errors *errors, enum pen_code code, const char *up,
                      const char *key, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* A value as messages name it. */
struct pen_found {
    char text[256];
};
struct pen_found pen_found(const json_t *value);

#endif

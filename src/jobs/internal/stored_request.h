/* SPDX-License-Identifier: MIT */
/* Reads the stored request of a job: the client's keys with all defaults filled in, as submit.c
 * wrote them. The worker and the results of a job use it. The scene is stored separately. */
#ifndef PEN_JOBS_INTERNAL_STORED_REQUEST_H
#define PEN_JOBS_INTERNAL_STORED_REQUEST_H

#include <jansson.h>

#include "base/status.h"
#include "jobs/internal/kind.h"
#include "render/layers.h"
#include "scene/settings.h"

struct pen_stored_request {
    json_t *json; /* the whole request; owns the names of views */
    struct pen_settings settings;
    enum pen_job_kind kind;
    int view_count;
    unsigned layers;    /* a bit for each enum pen_layer; every render has the beauty */
    enum pen_cost cost; /* what the cost layer shows */
    bool audit;         /* audit the picture, with the members below */
    uint64_t audit_pixels;
    double audit_threshold;
    double budget_s;   /* time in which the picture must be made; 0: no bound */
    double bound_rays; /* the bound of the job's rays, which decides whether it is a long job */
    int repeats;       /* of kind "effects": how often each render is timed */
    bool analyze;      /* of kind "explain": it renders */
};

/* Reads a request from its text.
 * Owns: release *request after success.
 * Fails: PEN_STORAGE. */
bool pen_stored_request_read(const char *text, struct pen_stored_request *request,
                             struct pen_status *st);
void pen_stored_request_release(struct pen_stored_request *request);

/* Returns the name of the view with index `view`; NULL if there is none. */
const char *pen_stored_request_view(const struct pen_stored_request *request, int view);

/* Returns the index of the view with that name; -1 if there is none. */
int pen_stored_request_find_view(const struct pen_stored_request *request, const char *name);

/* Parses a stored text; NULL gives JSON's null.
 * Owns: the caller.
 * Fails: PEN_STORAGE. */
json_t *pen_stored_json(const char *text, struct pen_status *st);

#endif

/* SPDX-License-Identifier: MIT */
/* Reading the stored request of a job: the client's keys with all defaults filled in, as submit.c
 * has written them. The worker and the results of a job use it; the scene is stored separately. */
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
    int view_count;
    enum pen_job_kind kind;
};

/* Reads a request from its text. Owns: release *request after success. Fails: PEN_STORAGE. */
bool pen_stored_request_read(const char *text, struct pen_stored_request *request,
                             struct pen_status *st);
void pen_stored_request_release(struct pen_stored_request *request);

/* The name of the view with index `view`; NULL if there is no such view. */
const char *pen_stored_request_view(const struct pen_stored_request *request, int view);

/* Whether the job has a layer beside the beauty, which every render has; and what its cost is. */
bool pen_stored_request_layer(const struct pen_stored_request *request, enum pen_layer layer);
enum pen_cost pen_stored_request_cost(const struct pen_stored_request *request);

/* Whether the picture is to be audited; then sets how. */
bool pen_stored_request_audit(const struct pen_stored_request *request, uint64_t *pixels,
                              double *threshold);

/* The seconds in which the picture is to be made; 0: as many as it takes. */
double pen_stored_request_budget(const struct pen_stored_request *request);

/* The bound of the job's rays, by which a job is a long one. */
double pen_stored_request_bound_rays(const struct pen_stored_request *request);

/* How often a job of kind "effects" times each render; whether one of kind "explain" renders. */
int pen_stored_request_repeats(const struct pen_stored_request *request);
bool pen_stored_request_analyze(const struct pen_stored_request *request);

/* The index of the view with that name, or -1. */
int pen_stored_request_find_view(const struct pen_stored_request *request, const char *name);

/* Parses a stored text; NULL gives JSON's null. Owns: the caller. Fails: PEN_STORAGE. */
json_t *pen_stored_json(const char *text, struct pen_status *st);

#endif

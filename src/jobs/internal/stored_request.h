/* SPDX-License-Identifier: MIT */
/* The stored request of a job, read: what the client asked for, with all defaults filled in, as
 * submit.c has written it. The worker and the results of a job need it; the scene is stored apart.
 */
#ifndef PEN_JOBS_INTERNAL_STORED_REQUEST_H
#define PEN_JOBS_INTERNAL_STORED_REQUEST_H

#include <jansson.h>

#include "base/status.h"
#include "scene/settings.h"

struct pen_stored_request {
    json_t *json; /* the whole of it; owns the names of views */
    struct pen_settings settings;
    int view_count;
    bool benchmark;
};

/* Reads it from its text. Owns: release it after success. Fails: PEN_STORAGE. */
bool pen_stored_request_read(const char *text, struct pen_stored_request *request,
                             struct pen_status *st);
void pen_stored_request_release(struct pen_stored_request *request);

/* The name of view number `view`; NULL if it has none. */
const char *pen_stored_request_view(const struct pen_stored_request *request, int view);

/* The number of the view of that name, or -1. */
int pen_stored_request_find_view(const struct pen_stored_request *request, const char *name);

/* A text of the store as JSON, null for NULL. Fails: PEN_STORAGE. */
json_t *pen_stored_json(const char *text, struct pen_status *st);

#endif

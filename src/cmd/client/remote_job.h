/* SPDX-License-Identifier: MIT */
/* What several commands do with a job of a daemon: follow it to its end, fetch its picture, show
 * it. */
#ifndef PEN_CMD_CLIENT_REMOTE_JOB_H
#define PEN_CMD_CLIENT_REMOTE_JOB_H

#include <jansson.h>
#include <stdbool.h>

#include "cmd/client/http_client.h"

/* A request about one job, with `suffix` after its path ("/stats", "?wait=30", ""). The answer,
 * if there is one, is *json. Errors as pen_client_json. */
bool pen_remote_job(struct pen_client *client, const char *method, const char *id,
                    const char *suffix, json_t **json, struct pen_errors *errors);

/* Follows a job until it has ended, with a progress bar; *job is its last state. A job that
 * failed or was cancelled is PEN_JOB_FAILED, with *job set too. Owns: the caller json_decref()s
 * *job in any case. */
bool pen_remote_wait(struct pen_client *client, const char *id, bool quiet, json_t **job,
                     struct pen_errors *errors);

struct pen_fetch {
    const char *output, *format; /* format NULL: by the ending of output */
    const char *view, *layer;    /* NULL: the daemon's defaults */
    bool report;                 /* the report, not a picture */
};

/* Downloads a job's picture or report into a file. */
bool pen_remote_fetch(struct pen_client *client, const char *id, const struct pen_fetch *fetch,
                      struct pen_errors *errors);

/* A member of a job that is text; "" if there is none. */
const char *pen_remote_text(const json_t *job, const char *key);

/* The same for people, cut to fit: it cannot play with the terminal. */
void pen_remote_label(const json_t *object, const char *key, char *out, size_t bytes);

/* A member that is a time, in seconds since 1970; negative if there is none. */
double pen_remote_time(const json_t *object, const char *key);

#endif

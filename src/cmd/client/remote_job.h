/* SPDX-License-Identifier: MIT */
/* Functions about a daemon's jobs that several commands use: send one request, follow a job to its
 * end, fetch its picture or report, show its members. */
#ifndef PEN_CMD_CLIENT_REMOTE_JOB_H
#define PEN_CMD_CLIENT_REMOTE_JOB_H

#include <jansson.h>
#include <stdbool.h>

#include "cmd/client/http_client.h"

/* GETs a path. *json is NULL if the answer has no body.
 * Owns: the caller calls json_decref() for *json in any case.
 * Fails: as pen_client_json. */
bool pen_remote_get(struct pen_client *client, const char *path, json_t **json,
                    struct pen_errors *errors);

/* Sends a request about one job; `suffix` follows the job's path ("/stats", "/cancel", ""). It may
 * be sent again after an error, so `method` must be idempotent there.
 * Owns: *json as for pen_remote_get. */
bool pen_remote_job(struct pen_client *client, const char *method, const char *id,
                    const char *suffix, json_t **json, struct pen_errors *errors);

/* Follows a job until it has ended, with a progress bar; *job is its last state.
 * Owns: the caller calls json_decref() for *job in any case.
 * Fails: PEN_RENDER_FAILED, with *job set, if the job failed or was cancelled; otherwise as
 * pen_client_json. */
bool pen_remote_wait(struct pen_client *client, const char *id, bool quiet, json_t **job,
                     struct pen_errors *errors);

/* GETs the report of a job as JSON.
 * Owns: the caller calls json_decref() for *report.
 * Fails: as pen_client_json. */
bool pen_remote_report(struct pen_client *client, const char *id, json_t **report,
                       struct pen_errors *errors);

struct pen_fetch {
    const char *output, *format; /* format NULL: the format that output ends in */
    const char *view, *layer;    /* NULL: the daemon's defaults */
    bool report;                 /* fetch the report, not a picture */
};

/* Downloads a job's picture or report into a file. */
bool pen_remote_fetch(struct pen_client *client, const char *id, const struct pen_fetch *fetch,
                      struct pen_errors *errors);

/* Returns a string member; "" if there is none. */
const char *pen_remote_text(const json_t *object, const char *key);

/* Writes a string member for a terminal: cut to fit, with control characters escaped
 * (base/utf8.h). */
void pen_remote_label(const json_t *object, const char *key, char *out, size_t bytes);

/* Returns a string member that is a time, in seconds since 1970; negative if there is none. */
double pen_remote_time(const json_t *object, const char *key);

#endif

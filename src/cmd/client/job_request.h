/* SPDX-License-Identifier: MIT */
/* The request that makes a job: its text, sending it, and the places of the daemon's errors in the
 * document. */
#ifndef PEN_CMD_CLIENT_JOB_REQUEST_H
#define PEN_CMD_CLIENT_JOB_REQUEST_H

#include "cmd/client/http_client.h"
#include "cmd/files.h"

struct pen_job_request {
    struct pen_buf text;
    const char *key; /* for idempotency; NULL: a random one */
    bool xml;        /* a bare scene in XML */
    bool wrapped;    /* a job whose member "scene" is the document, which begins on line 2 */
};

/* Makes the request from a job.
 * Fails: PEN_NO_MEMORY. */
bool pen_job_request_whole(struct pen_job_request *request, const json_t *job,
                           struct pen_status *st);

/* Makes the job {"scene": DOCUMENT, MEMBERS}. A document in JSON keeps its own bytes. For a
 * document in XML, `scene` is the same scene in JSON.
 * Fails: PEN_NO_MEMORY. */
bool pen_job_request_wrap(struct pen_job_request *request, const struct pen_source *source,
                          const json_t *scene, const json_t *members, struct pen_status *st);

/* Sends the request.
 * Owns: the caller calls json_decref() for *job, which has an id.
 * Fails: as pen_client_json. */
bool pen_job_request_post(struct pen_client *client, const struct pen_job_request *request,
                          json_t **job, struct pen_errors *errors);

/* Prints the daemon's errors. If the document was wrapped, a place in the scene becomes a place in
 * the file. Errors of other members are about the command line, and are printed without the file's
 * name. Returns the exit code. */
int pen_job_request_report(const struct pen_job_request *request, const struct pen_source *source,
                           bool json, struct pen_errors *errors);

#endif

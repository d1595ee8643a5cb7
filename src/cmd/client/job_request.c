/* SPDX-License-Identifier: MIT */
#include "cmd/client/job_request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "cmd/client/remote_job.h"
#include "cmd/report.h"

static bool dump(const json_t *json, struct pen_buf *out)
{
    char *text = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17));
    bool ok = text && pen_buf_puts(out, text);
    free(text);
    return ok;
}

bool pen_job_request_whole(struct pen_job_request *request, const json_t *job,
                           struct pen_status *st)
{
    return dump(job, &request->text) || pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

/* Writes {"scene":⏎DOCUMENT⏎,MEMBERS}. The document begins on line 2. */
static bool write_job(const struct pen_source *source, const json_t *scene, const json_t *members,
                      struct pen_buf *out)
{
    struct pen_buf tail = {0};
    bool ok = pen_buf_puts(out, "{\"scene\":\n") &&
              (source->xml ? dump(scene, out)
                           : pen_buf_add(out, source->text.data, source->text.bytes)) &&
              dump(members, &tail);
    if (ok && json_object_size(members) > 0)
        ok = pen_buf_puts(out, "\n,") && pen_buf_add(out, tail.data + 1, tail.bytes - 1);
    else
        ok = ok && pen_buf_puts(out, "\n}");
    pen_buf_release(&tail);
    return ok;
}

bool pen_job_request_wrap(struct pen_job_request *request, const struct pen_source *source,
                          const json_t *scene, const json_t *members, struct pen_status *st)
{
    request->wrapped = true;
    return write_job(source, scene, members, &request->text) ||
           pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

static bool random_key(char key[40], struct pen_status *st)
{
    unsigned char bytes[16];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return pen_fail(st, PEN_IO, "no random numbers for the idempotency key");
    for (size_t i = 0; i < sizeof bytes; i++)
        snprintf(key + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

static bool add_error(struct pen_errors *errors, const struct pen_status *st)
{
    pen_errors_add(errors, st);
    return false;
}

bool pen_job_request_post(struct pen_client *client, const struct pen_job_request *request,
                          json_t **job, struct pen_errors *errors)
{
    struct pen_status st;
    struct pen_reply reply = {0};
    char key[40];
    *job = NULL;
    if (!request->key && !random_key(key, &st))
        return add_error(errors, &st);
    struct pen_request post = {.method = "POST",
                               .path = "/v1/jobs",
                               .body = (const char *)request->text.data,
                               .body_bytes = request->text.bytes,
                               .type = request->xml ? "application/xml" : "application/json",
                               .idempotency_key = request->key ? request->key : key,
                               .repeatable = true, /* because of the key */
                               .timeout_s = 60};
    const bool ok = pen_client_json(client, &post, &reply, job, errors);
    pen_reply_release(&reply);
    if (!ok || *pen_remote_text(*job, "id"))
        return ok;
    json_decref(*job);
    *job = NULL;
    pen_fail(&st, PEN_NETWORK, "the answer names no job: is that a Penumbra daemon?");
    return add_error(errors, &st);
}

int pen_job_request_report(const struct pen_job_request *request, const struct pen_source *source,
                           bool json, struct pen_errors *errors)
{
    static const char inside[] = "/scene";
    enum { LENGTH = sizeof inside - 1 };
    const char *label = source->label;
    if (!request->wrapped)
        return pen_report_errors_json(label, json, errors);
    for (size_t i = 0; i < errors->count; i++) {
        struct pen_status *st = &errors->item[i];
        if (st->line > 1)
            st->line--;
        if (strncmp(st->at, inside, LENGTH) == 0) {
            memmove(st->at, st->at + LENGTH, sizeof st->at - LENGTH);
            pen_source_locate(source, st);
        } else if (st->at[0])
            label = "the job";
    }
    return pen_report_errors_json(label, json, errors);
}

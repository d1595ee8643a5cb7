/* SPDX-License-Identifier: MIT */
/* The life of a job as the API sees it: submit, read, list, cancel, delete, results. Input is
 * bytes, output is JSON; there is no HTTP here. The api process never renders: it validates, queues
 * and answers.
 *
 * Fails: every call that takes a handle also fails as the store does: PEN_STORAGE,
 * PEN_STORAGE_FULL, PEN_UNAVAILABLE; and with PEN_NO_MEMORY.
 * Threads: one thread at a time uses a pen_jobs handle, which has a store handle. */
#ifndef PEN_JOBS_JOBS_H
#define PEN_JOBS_JOBS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "base/status.h"
#include "io/scene_json.h"
#include "store/store.h"

struct pen_jobs;

/* The names that the API knows, including names that are not supported yet. Each list begins with
 * the default and ends with NULL. */
extern const char *const pen_job_kinds[];     /* of jobs */
extern const char *const pen_image_formats[]; /* of pictures */

/* Opens a handle.
 * Owns: close it with pen_jobs_close.
 * Fails: as pen_store_open. */
struct pen_jobs *pen_jobs_open(const char *store_url, const struct pen_limits *limits,
                               struct pen_status *st);
void pen_jobs_close(struct pen_jobs *jobs);

/* Returns the store behind the handle, for pen_store_wait, pen_store_intake and pen_store_scene.
 * Owns: the handle. */
struct pen_store *pen_jobs_store(struct pen_jobs *jobs);

struct pen_submission {
    const char *body;
    size_t bytes;
    bool xml;                    /* true: a bare scene in XML; false: JSON */
    bool explain;                /* make a job of kind "explain" */
    const char *client;          /* `token:NAME` or `address:IP`, the job's owner; NULL: "" */
    bool client_is_shared;       /* the address may stand for many clients */
    const char *traceparent;     /* the trace that the job belongs to; NULL: none */
    const char *idempotency_key; /* of the client; NULL: none */
    struct pen_models *models;   /* that the scene may name; NULL in a daemon */
};

struct pen_submitted {
    char id[PEN_ID_BYTES];
    struct pen_buf answer; /* the job as JSON; release it */
    bool repeated;         /* an earlier submit with this key made the job and the answer */
};

/* Accepts a job (an object with `scene`) or a bare scene (an object with `format`, or XML). When it
 * returns true, the job is on disk.
 * Fails: errors->count > 0. PEN_INVALID without a place means that the idempotency key was used
 * with another body. PEN_GONE means that the job of this key was removed. */
bool pen_jobs_submit(struct pen_jobs *jobs, const struct pen_submission *in,
                     struct pen_submitted *out, struct pen_errors *errors);

/* Checks a scene or a job without storing it; *answer is {"valid": true, "warnings": […]}. Of a
 * scene with meshes it has `meshes` {count, triangles}. The store is not used. `jobs` NULL stands
 * for the default limits.
 * Owns: *answer is the caller's.
 * Fails: errors->count > 0. */
bool pen_jobs_validate(struct pen_jobs *jobs, const struct pen_submission *in, json_t **answer,
                       struct pen_errors *errors);

struct pen_job_snapshot {
    json_t *json; /* the job object (api/http-api.md); release it with json_decref() */
    enum pen_job_state state;
    int64_t revision;
    bool cancelled_now; /* by this call */
};

/* Reads a job.
 * Fails: PEN_NOT_FOUND, PEN_GONE (the job was removed); so does every other call about a job. */
bool pen_jobs_get(struct pen_jobs *jobs, const char *id, struct pen_job_snapshot *out,
                  struct pen_status *st);

/* Reads only the state and the revision of a job.
 * Fails: as pen_jobs_get. */
bool pen_jobs_state(struct pen_jobs *jobs, const char *id, enum pen_job_state *state,
                    int64_t *revision, struct pen_status *st);

struct pen_list_query {
    int state;          /* enum pen_job_state; -1: all */
    const char *kind;   /* NULL: all */
    const char *name;   /* NULL: all */
    const char *label;  /* "key:value"; NULL: all. The first colon ends the key */
    int limit;          /* 1…500 */
    const char *cursor; /* `next` of an earlier list; NULL: from the newest job on */
};

/* Returns a page of jobs, newest first: {jobs: […], next: cursor | null}. A page ends at the limit
 * or at about 1 MiB of JSON, and has at least one job if there is one. Without a cursor it also has
 * `counts`, the number of all jobs in each state.
 * Owns: the caller.
 * Fails: PEN_USAGE (limit, a label without a colon, or a cursor that no list has given). */
json_t *pen_jobs_list(struct pen_jobs *jobs, const struct pen_list_query *query,
                      struct pen_status *st);

/* Cancels a job, and reads it. An ended job stays as it is. `client` NULL is the operator.
 * Fails: PEN_NOT_FOUND, PEN_FORBIDDEN (the job belongs to another client). */
bool pen_jobs_cancel(struct pen_jobs *jobs, const char *id, const char *client,
                     struct pen_job_snapshot *out, struct pen_status *st);

/* Removes an ended job and its results. With keep_stats its statistics can still be read for years.
 * Without keep_stats they are removed too, even if the job was removed before. `client` NULL is the
 * operator.
 * Fails: PEN_NOT_FOUND, PEN_GONE (nothing is left to remove), PEN_FORBIDDEN (the job belongs to
 * another client), PEN_CONFLICT (the job has not ended). */
bool pen_jobs_delete(struct pen_jobs *jobs, const char *id, const char *client, bool keep_stats,
                     struct pen_status *st);

struct pen_image_query {
    const char *view;   /* "all": a contact sheet of all views; NULL: the first view */
    const char *layer;  /* NULL: beauty */
    const char *format; /* one of pen_image_formats; NULL: the first */
    int max_edge;       /* pixels: a PNG with a longer edge is shrunk to this; 0: never */
    const char *with;   /* the other job, for pen_jobs_compare */
};

struct pen_image {
    struct pen_buf bytes; /* release it */
    char type[40];        /* media type */
    char etag[72];        /* quoted, strong: a hash of the bytes */
};

/* Returns the picture of a job that has succeeded.
 * Fails: PEN_CONFLICT (unfinished, failed, cancelled), PEN_NOT_FOUND (no such job or view, a layer
 * that was not requested, a job with a report), PEN_USAGE (format, layer, max_edge with another
 * format than PNG). */
bool pen_jobs_image(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                    struct pen_image *out, struct pen_status *st);

/* Compares a view of a job with that of the job `with`, which is the reference. The query's layer
 * and max_edge do not count. Format "json" (NULL) has the figures (comparison.h), "png" FLIP's
 * error of each pixel.
 * Fails: PEN_NOT_FOUND, as pen_jobs_image; PEN_CONFLICT (a job that has not succeeded; views of
 * different sizes). */
bool pen_jobs_compare(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                      struct pen_image *out, struct pen_status *st);

/* Returns the pixels committed so far as an RGBA PNG; other pixels are transparent. The query's
 * layer and format do not count; NULL stands for the first view.
 * Fails: PEN_NOT_FOUND (no such job or view, a job with a report). */
bool pen_jobs_preview(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                      struct pen_image *out, struct pen_status *st);

/* A rectangle of a view, whose pixels came with one commit. */
struct pen_job_tile {
    int64_t revision; /* the job's revision after this commit */
    int part; /* 1 … PEN_JOB_TILE_PARTS: its number among the rectangles of the same commit */
    const char *view;
    int x, y, width, height;
};
enum { PEN_JOB_TILE_PARTS = 3 };

/* Calls `each` for the rectangles committed after a revision, in the order of their commits. Stops
 * when it returns false.
 * Fails: PEN_NOT_FOUND, PEN_STORAGE. */
typedef bool pen_job_tile_fn(void *user, const struct pen_job_tile *tile);
bool pen_jobs_tiles(struct pen_jobs *jobs, const char *id, int64_t after, pen_job_tile_fn *each,
                    void *user, struct pen_status *st);

/* Returns the statistics object of an ended job, even if the job was removed since.
 * Owns: the caller.
 * Fails: PEN_NOT_FOUND, PEN_GONE (removed with its statistics), PEN_CONFLICT (the job has not
 * ended). */
json_t *pen_jobs_stats(struct pen_jobs *jobs, const char *id, struct pen_status *st);

/* As pen_jobs_stats. Of a job that has not ended, returns the statistics of its committed
 * batches. */
json_t *pen_jobs_stats_so_far(struct pen_jobs *jobs, const char *id, struct pen_status *st);

/* Returns the report of a job in one of the formats of pen_report_formats.
 * Fails: PEN_CONFLICT (unfinished, failed, cancelled), PEN_NOT_FOUND (no such job, or of a kind
 * without a report), PEN_ACCEPT (an explanation in another format than "json"). */
bool pen_jobs_report(struct pen_jobs *jobs, const char *id, const char *form, struct pen_image *out,
                     struct pen_status *st);

/* Returns the workers: {"workers": [{name, host, pid, threads, started_at, last_seen_at,
 * batches}]}.
 * Owns: the caller. */
json_t *pen_jobs_workers(struct pen_jobs *jobs, struct pen_status *st);

/* Returns the built-in scenes: {"scenes": [{name, title, bytes, objects, href}]}.
 * Owns: the caller.
 * Fails: NULL when out of memory. */
json_t *pen_jobs_scenes(void);

/* Makes a problem document (RFC 9457) for one status or for a list of errors. It is the HTTP body,
 * the stored error of a job, and the error of the command line with --json.
 * Owns: the caller.
 * Fails: NULL when out of memory. */
json_t *pen_problem(const struct pen_status *st);
json_t *pen_problem_list(const struct pen_errors *errors);

/* Returns the place of an error: {pointer, detail}, or {line, column, detail} if the input is text
 * with lines.
 * Owns: the caller.
 * Fails: NULL when out of memory. */
json_t *pen_problem_place(const struct pen_status *st);

/* Writes a problem document as text, with a line end. http_status overrides the status of the code,
 * unless it is 0. request_id (may be NULL) is the id of the refused request. Returns false when out
 * of memory. */
bool pen_problem_write(struct pen_buf *out, const struct pen_status *st, int http_status,
                       const char *request_id);
bool pen_problem_list_write(struct pen_buf *out, const struct pen_errors *errors,
                            const char *request_id);

#endif

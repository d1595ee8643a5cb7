/* SPDX-License-Identifier: MIT */
/* Jobs: submit, read, list, cancel, delete. This header is a part of store.h, whose promises hold
 * here. The store does not read texts, with one exception: of a request that is a JSON object it
 * reads three members. Lists are filtered by `name` and `labels`; the length of `layers` counts for
 * the expected results. */
#ifndef PEN_STORE_JOBS_H
#define PEN_STORE_JOBS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "base/clock.h"
#include "base/status.h"

struct pen_store;

enum { PEN_ID_BYTES = 37 }; /* UUID text and its end */

enum pen_job_state {
    PEN_JOB_QUEUED,
    PEN_JOB_RUNNING,
    PEN_JOB_SUCCEEDED,
    PEN_JOB_FAILED,
    PEN_JOB_CANCELLED,
    PEN_JOB_STATE_COUNT
};

enum pen_batch_state {
    PEN_BATCH_OPEN,   /* may be claimed */
    PEN_BATCH_LEASED, /* a worker holds an attempt */
    PEN_BATCH_DONE,   /* result committed */
    PEN_BATCH_ENDED,  /* its job failed or was cancelled */
    PEN_BATCH_STATE_COUNT
};

enum pen_batch_kind {
    PEN_BATCH_RENDER,   /* tiles of a view */
    PEN_BATCH_ASSEMBLE, /* makes the picture of a view from its committed batches */
    PEN_BATCH_STUDY     /* the only batch of a job with a report; its worker holds no other batch */
};

/* The name of a state in the API, such as "queued". pen_job_state_of_name returns false if no state
 * has this name. */
const char *pen_job_state_name(enum pen_job_state state);
bool pen_job_state_of_name(const char *name, enum pen_job_state *state);

static inline bool pen_job_state_ended(enum pen_job_state state)
{
    return state >= PEN_JOB_SUCCEEDED;
}

struct pen_view_new {
    const char *name;
    int width, height;
};

struct pen_batch_new {
    int view;
    int first_tile, tile_count;
    int64_t pixels;           /* of a study: the number of its runs, in which progress is counted */
    enum pen_batch_kind kind; /* render or study; a study is the only batch of its job */
};

struct pen_job_new {
    const char *id;            /* UUIDv7 */
    int64_t created_ms;        /* by pen_store_now; the id and the answer have the same time */
    struct pen_moment created; /* the same moment */
    const char *kind;
    const char *request; /* JSON: the job as accepted, without its scene */
    const void *scene;   /* the scene document as sent; equal documents are stored once */
    size_t scene_bytes;
    const unsigned char *scene_sha256; /* 32 bytes */
    int priority, max_attempts;
    int64_t timeout_ms; /* 0: none */
    int view_count;
    const struct pen_view_new *views;
    int batch_count;
    const struct pen_batch_new *batches;
    const char *client;                  /* NULL: "" */
    int64_t queue_max, client_queue_max; /* the most unfinished jobs, this one included, of all
                                            clients and of this client; 0: no limit */
    const char *idempotency_key;         /* of the client; NULL: none */
    const unsigned char *body_sha256;    /* 32 bytes; required with a key */
    const char *answer;                  /* stored with the key, returned to a repeated submit */
};

enum pen_submit_result {
    PEN_SUBMIT_CREATED,
    PEN_SUBMIT_KNOWN,    /* the job is already stored: an earlier try of this submit succeeded */
    PEN_SUBMIT_REPEATED, /* same key, same body: *first_answer is the answer to the first submit */
    PEN_SUBMIT_REUSED    /* same key, another body: nothing was stored */
};

/* Stores a job. A caller that does not know the outcome repeats the call with the same job. For a
 * repeated key, the first answer is appended to *first_answer.
 * Fails: PEN_STORAGE_FULL (the disk is nearly full; or keep_bytes is reached, where unfinished jobs
 * count with their expected results). PEN_TOO_LARGE (this job's expected results alone exceed
 * keep_bytes). PEN_QUOTA (too many unfinished jobs), PEN_CONFLICT (another job has this id),
 * PEN_INTERNAL (a view without a batch). PEN_UNAVAILABLE (busy too long), PEN_STORAGE,
 * PEN_NO_MEMORY. */
bool pen_store_submit(struct pen_store *store, const struct pen_job_new *job,
                      enum pen_submit_result *result, struct pen_buf *first_answer,
                      struct pen_status *st);

/* The work of a whole job; a claim's work is a part of it. */
enum { PEN_WORK_ALL = 1000000000 };

/* A job as stored.
 * Owns: the texts belong to the record; free them with pen_job_record_release. */
struct pen_job_record {
    int64_t number; /* in order of submission */
    char id[PEN_ID_BYTES];
    enum pen_job_state state;
    int64_t revision; /* grows with every change that a reader can see; at first 1 */
    char *kind, *request;
    char *error; /* the problem document, JSON; NULL unless failed */
    int priority, max_attempts;
    int attempts; /* 0 before the first claim, then 1. Each crash of a worker that is charged to the
                     job adds 1, until the next commit; at most max_attempts */
    int64_t timeout_ms;
    int64_t created_ms, started_ms, finished_ms; /* by the store's clock; 0: not yet */
    int64_t updated_ms;                          /* when the revision last changed */
    int64_t done_pixels, total_pixels;
    int64_t work;        /* done part of the expected work; all is PEN_WORK_ALL */
    int64_t estimate_ms; /* expected working time of all workers; 0: not estimated */
    int64_t told_us;     /* working time when `work` was last reported */
    /* Times since the submit: to the last change, to the last report of `work` (0: none), and to
     * the first claim. They are of the boot's clock; across a boot, of the store's clock. */
    int64_t elapsed_us, told_elapsed_us, queue_us;
};

void pen_job_record_release(struct pen_job_record *job);

/* Returns the length of request and error together. */
size_t pen_job_record_text_bytes(const struct pen_job_record *job);

/* Reads a job.
 * Fails: PEN_NOT_FOUND, PEN_GONE (the job was removed); so does every other call about a job. */
bool pen_store_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                   struct pen_status *st);

struct pen_queue {
    struct pen_buf ids; /* of the first PEN_QUEUE_TOLD open jobs, PEN_ID_BYTES each, in the order in
                           which their next batches are claimed */
    int64_t hand_us;    /* sum of the time that leased batches still need, each at most a minute */
    int64_t workers;    /* workers seen lately */
    int64_t job_us;     /* mean working time of the last 50 ended jobs; 0: no such job */
};
enum { PEN_QUEUE_TOLD = 1000 };

/* Reads the queue.
 * Owns: the caller releases queue->ids, also after a failure.
 * Fails: PEN_NO_MEMORY.
 * Cost: an index of open batches. */
bool pen_store_queue(struct pen_store *store, struct pen_queue *queue, struct pen_status *st);

struct pen_job_filter {
    int state;                                  /* enum pen_job_state, or -1: any */
    const char *kind;                           /* NULL: any */
    const char *name, *label_key, *label_value; /* of the request: `name`, a label; NULL: any */
    int64_t below; /* the cursor: only jobs with smaller numbers; 0: all */
    int limit;
    /* The list ends with the job with which the texts (request and error) of all listed jobs exceed
     * this size, but not before its second job. 0: no limit. */
    size_t text_bytes;
};

/* Lists at most filter->limit jobs, newest first.
 * Owns: *jobs has *count records; free them with pen_job_records_free. */
bool pen_store_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                    struct pen_job_record **jobs, int *count, struct pen_status *st);
void pen_job_records_free(struct pen_job_record *jobs, int count);

/* Counts the jobs in each state.
 * Cost: reads an index entry for each job. */
bool pen_store_job_counts(struct pen_store *store, int64_t jobs[PEN_JOB_STATE_COUNT],
                          struct pen_status *st);

/* The number of jobs in each state, and of open and leased batches. */
struct pen_counts {
    int64_t jobs[PEN_JOB_STATE_COUNT];
    int64_t open_batches, leased_batches;
    int64_t oldest_queued_ms; /* submit time of the oldest queued job; 0: none */
    int64_t bytes;            /* used bytes of the store's database */
};
bool pen_store_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st);

/* Appends the scene document, as it was sent.
 * Fails: PEN_NOT_FOUND, PEN_STORAGE (damaged). */
bool pen_store_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                     struct pen_status *st);

/* Returns true if a client may change a job, which may already be removed. `client` NULL is the
 * operator. pen_store_cancel and pen_store_delete check it too.
 * Fails: PEN_FORBIDDEN (the job belongs to another client). */
bool pen_store_check_client(struct pen_store *store, const char *id, const char *client,
                            struct pen_status *st);

/* Cancels a job and ends its open and leased batches, in one transaction. An ended job stays as it
 * is.
 * Fails: PEN_NOT_FOUND, PEN_FORBIDDEN. */
bool pen_store_cancel(struct pen_store *store, const char *id, const char *client,
                      struct pen_status *st);

/* Removes an ended job. Only the text `stats` (may be NULL) can still be read, by
 * pen_store_removed_stats. If the job was removed before and `stats` is NULL, its text is dropped.
 * pen_store_purge frees the space later.
 * Fails: PEN_NOT_FOUND, PEN_GONE (removed before, and there is no text to drop), PEN_FORBIDDEN,
 * PEN_CONFLICT (the job has not ended). */
bool pen_store_delete(struct pen_store *store, const char *id, const char *client,
                      const char *stats, struct pen_status *st);

/* Appends the text that a removed job left.
 * Fails: PEN_NOT_FOUND (no such job, or not removed), PEN_GONE (it left no text). */
bool pen_store_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                             struct pen_status *st);

#endif

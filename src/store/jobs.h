/* SPDX-License-Identifier: MIT */
/* Jobs: submit, read, list, cancel, delete. A part of store.h, whose promises hold here. Text is
 * opaque to the store, but for three members of a request that is a JSON object: `name` and
 * `labels`, which lists are filtered by, and the length of `layers`. */
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
    PEN_BATCH_STUDY     /* the only batch of a job with a report; its worker holds nothing else */
};

/* The name of a state in the API, "queued" and so on; pen_job_state_of_name returns false if no
 * state has this name. */
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
    int64_t pixels;           /* of a study: the number of its runs, which its progress counts */
    enum pen_batch_kind kind; /* render or study; a study is the only batch of its job */
};

struct pen_job_new {
    const char *id;            /* UUIDv7 */
    int64_t created_ms;        /* by pen_store_now; also the time in the id and in the answer */
    struct pen_moment created; /* the same moment */
    const char *kind;
    const char *request; /* JSON: the job as accepted, without its scene */
    const void *scene;   /* the scene document as sent; stored once per content */
    size_t scene_bytes;
    const unsigned char *scene_sha256; /* 32 bytes */
    int priority, max_attempts;
    int64_t timeout_ms; /* 0: none */
    int view_count;
    const struct pen_view_new *views;
    int batch_count;
    const struct pen_batch_new *batches;
    const char *client;                  /* NULL: "" */
    int64_t queue_max, client_queue_max; /* the most unfinished jobs, in all and of this client,
                                            with this one; 0: any number */
    const char *idempotency_key;         /* of the client; NULL: none */
    const unsigned char *body_sha256;    /* 32 bytes; required with a key */
    const char *answer;                  /* stored with the key, returned to a repeated submit */
};

enum pen_submit_result {
    PEN_SUBMIT_CREATED,
    PEN_SUBMIT_KNOWN,    /* the job is stored already: an earlier try of this submit succeeded */
    PEN_SUBMIT_REPEATED, /* same key, same body: *first_answer is the answer given first */
    PEN_SUBMIT_REUSED    /* same key, another body: nothing was stored */
};

/* Stores a job. A caller that does not know the outcome repeats the call with the same job. The
 * first answer is appended to *first_answer. Fails: PEN_STORAGE_FULL (the disk is nearly full, or
 * the store holds keep_bytes, the results of unfinished jobs counted as expected), PEN_TOO_LARGE
 * (the job's results alone are expected to take more than keep_bytes), PEN_STORAGE, PEN_UNAVAILABLE
 * (busy too long), PEN_QUOTA (too many unfinished jobs), PEN_CONFLICT (another job has this id),
 * PEN_INTERNAL (a view without a batch), PEN_NO_MEMORY. */
bool pen_store_submit(struct pen_store *store, const struct pen_job_new *job,
                      enum pen_submit_result *result, struct pen_buf *first_answer,
                      struct pen_status *st);

/* All of a job's work, of which claims tell shares. */
enum { PEN_WORK_ALL = 1000000000 };

/* A job as stored. Owns: the texts belong to the record; free them with pen_job_record_release. */
struct pen_job_record {
    int64_t number; /* order of submission */
    char id[PEN_ID_BYTES];
    enum pen_job_state state;
    int64_t revision; /* grows with every change that a reader can see; 1 at first */
    char *kind, *request;
    char *error; /* JSON of the problem, NULL unless failed */
    int priority, max_attempts;
    int attempts; /* 0 before the first claim, then 1 and one more for each crash of a worker
                     charged to the job since its last commit; at most max_attempts */
    int64_t timeout_ms;
    int64_t created_ms, started_ms, finished_ms; /* by the store's clock; 0: not yet */
    int64_t updated_ms;                          /* when the revision last changed */
    int64_t done_pixels, total_pixels;
    int64_t work;        /* the share of its expected work that is done, of PEN_WORK_ALL */
    int64_t estimate_ms; /* how long workers are expected to work on it in all; 0: not estimated */
    int64_t told_us;     /* how long they had worked on it when `work` was last told */
    /* The time since the submit: up to the last change; up to when `work` was last told, 0: never;
     * up to the first claim. By the clock of the boot; from one boot to the next by the store's. */
    int64_t elapsed_us, told_elapsed_us, queue_us;
};

void pen_job_record_release(struct pen_job_record *job);

/* The length of its request and error together. */
size_t pen_job_record_text_bytes(const struct pen_job_record *job);

/* Fails: PEN_NOT_FOUND; PEN_GONE (the job was removed), as every other call about a job. */
bool pen_store_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                   struct pen_status *st);

struct pen_queue {
    struct pen_buf ids; /* of the first PEN_QUEUE_TOLD open jobs, PEN_ID_BYTES each, in the order in
                         * which their next batches are claimed */
    int64_t hand_us;    /* what the batches in hand still take, each at most a minute */
    int64_t workers;    /* that are there now */
    int64_t job_us;     /* the mean time that workers took for each of the last 50 jobs; 0: none */
};
enum { PEN_QUEUE_TOLD = 1000 };

/* Reads the queue; the caller releases its ids, also after a failure. Fails: PEN_NO_MEMORY. Cost:
 * an index of open batches. */
bool pen_store_queue(struct pen_store *store, struct pen_queue *queue, struct pen_status *st);

struct pen_job_filter {
    int state;                                  /* enum pen_job_state, or -1: any */
    const char *kind;                           /* NULL: any */
    const char *name, *label_key, *label_value; /* of the request: `name`, a label; NULL: any */
    int64_t below; /* the cursor: only jobs with smaller numbers; 0: all */
    int limit;
    /* The list ends with the job whose texts, request and error, bring those of all to more than
     * this, but not with the first one; 0: no bound. */
    size_t text_bytes;
};

/* Lists jobs, newest first, at most filter->limit. Owns: *jobs are *count records; free them with
 * pen_job_records_free. */
bool pen_store_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                    struct pen_job_record **jobs, int *count, struct pen_status *st);
void pen_job_records_free(struct pen_job_record *jobs, int count);

/* The number of jobs in each state. Cost: reads an index entry for each job. */
bool pen_store_job_counts(struct pen_store *store, int64_t jobs[PEN_JOB_STATE_COUNT],
                          struct pen_status *st);

/* The number of jobs in each state, and of batches that are open or leased. */
struct pen_counts {
    int64_t jobs[PEN_JOB_STATE_COUNT];
    int64_t open_batches, leased_batches;
    int64_t oldest_queued_ms; /* when the oldest queued job was submitted; 0: there is none */
    int64_t bytes;            /* of the store's files */
};
bool pen_store_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st);

/* Appends the scene document, as it was sent. Fails: PEN_NOT_FOUND, PEN_STORAGE (damaged). */
bool pen_store_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                     struct pen_status *st);

/* Returns true if a client may change a job, which may have been removed; the two calls below check
 * it too. NULL as `client` is the operator. Fails: PEN_FORBIDDEN (it belongs to another client). */
bool pen_store_check_client(struct pen_store *store, const char *id, const char *client,
                            struct pen_status *st);

/* Cancels a job, and ends its open and leased batches, in one transaction. A job that has ended
 * stays as it is. Fails: PEN_NOT_FOUND, PEN_FORBIDDEN. */
bool pen_store_cancel(struct pen_store *store, const char *id, const char *client,
                      struct pen_status *st);

/* Removes an ended job. Only `stats`, a text, stays readable, by pen_store_removed_stats (NULL:
 * nothing; of a job that was removed before, the text is dropped). Space is freed later, by
 * pen_store_purge. Fails: PEN_NOT_FOUND, PEN_GONE (it was removed, and there is no text to drop),
 * PEN_FORBIDDEN, PEN_CONFLICT (it has not ended). */
bool pen_store_delete(struct pen_store *store, const char *id, const char *client,
                      const char *stats, struct pen_status *st);

/* Appends what a removed job left. Fails: PEN_NOT_FOUND (no such job, or not removed), PEN_GONE (it
 * left nothing). */
bool pen_store_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                             struct pen_status *st);

#endif

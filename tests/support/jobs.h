/* SPDX-License-Identifier: MIT */
/* Jobs on a test store, and a worker in a thread. */
#ifndef TESTS_SUPPORT_JOBS_H
#define TESTS_SUPPORT_JOBS_H

#include <pthread.h>
#include <stdatomic.h>
#include <sys/types.h>

#include "jobs/jobs.h"
#include "jobs/worker.h"
#include "support/store.h"

struct jobs_bed {
    struct store_bed bed;
    struct pen_jobs *jobs;
    pthread_t thread;
    atomic_bool stop;
    bool working;
    int max_seconds;                      /* as in pen_worker_options */
    int64_t batch_ms;                     /* the same */
    const struct pen_worker_fault *fault; /* of the workers that are started; may be NULL */
    void (*stuck)(void *user);            /* the same */
};

/* Opens the bed, in the folder of store_bed_make if that was called before. Keeps bed->fault. */
void jobs_bed_open(struct jobs_bed *bed);

/* Stops the worker if it runs, audits the store and closes the bed. */
void jobs_bed_close(struct jobs_bed *bed);

/* Starts a worker with two threads, in a thread of this process. */
void jobs_worker_start(struct jobs_bed *bed);
void jobs_worker_stop(struct jobs_bed *bed);

/* Starts a worker process, "doomed:1:1", for the test to kill. Call it between store_bed_make and
 * jobs_bed_open, because the new process must not inherit a store handle. */
pid_t jobs_worker_fork(const struct jobs_bed *bed);

/* Returns true if the job's first view has kept something under a name (struct pen_kept). */
bool jobs_has_kept(struct jobs_bed *bed, const char *id, const char *name);

/* Returns what it has kept, to be released. The test fails if there is nothing within a minute, or
 * if the job ends. */
struct pen_buf jobs_wait_kept(struct jobs_bed *bed, const char *id, const char *name);

/* Replaces what is kept. */
void jobs_put_kept(struct jobs_bed *bed, const char *id, const char *name, const void *data,
                   size_t bytes);

/* Opens the bed and begins a job in a worker process. Kills the process as soon as `enough` accepts
 * what it has kept under a name; NULL accepts anything. Returns what was kept last, to be
 * released. */
struct pen_buf jobs_begin_and_kill(struct jobs_bed *bed, const char *body, char id[PEN_ID_BYTES],
                                   const char *name, bool (*enough)(const struct pen_buf *kept));

/* Submits a job and writes its id. The test fails with the errors if the job is refused. */
void jobs_submit(struct jobs_bed *bed, const char *body, char id[PEN_ID_BYTES]);

/* Waits until the job has ended; the test fails after four minutes. */
enum pen_job_state jobs_wait(struct jobs_bed *bed, const char *id);

/* Returns true if the first of two ended jobs ended before the second. Also if it came after that,
 * as when a test is slow to submit it. */
bool jobs_did_not_wait(struct jobs_bed *bed, const char *first, const char *second);

/* Returns the job as JSON; the caller calls json_decref(). */
json_t *jobs_get(struct jobs_bed *bed, const char *id);

/* Returns the picture of a view in a format; release it. */
struct pen_buf jobs_image(struct jobs_bed *bed, const char *id, const char *view,
                          const char *format);

/* Returns a scene of a few primitives with lights and a mirror. `more` is inserted before the
 * closing brace, such as ", \"render\": {…}". */
const char *jobs_scene(const char *more);

#endif

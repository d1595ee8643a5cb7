/* SPDX-License-Identifier: MIT */
/* The worker: claims batches, renders them on one thread pool, commits pixels. It has no state of
 * its own. If it is killed, at most its unfinished batches are lost, and they are rendered
 * again. */
#ifndef PEN_JOBS_WORKER_H
#define PEN_JOBS_WORKER_H

#include <stdatomic.h>
#include <stdbool.h>

#include "base/status.h"
#include "jobs/trace.h"
#include "render/render.h"
#include "scene/scene.h"
#include "store/store.h"

/* For tests: makes rendering fail. `wanted` is called once for each batch with the job's name
 * (NULL: none); if it returns true, `pixel` is called before each pixel. If `pixel` returns false,
 * the batch fails as if memory had run out. */
struct pen_worker_fault {
    bool (*wanted)(void *user, const char *job_name);
    bool (*pixel)(void *user, int x, int y);
    void *user;
};

struct pen_worker_options {
    const char *store_url;
    const char *id;         /* see pen_worker_id_make */
    int supervisor;         /* the process that reports this worker's end; 0: none */
    int threads;            /* 0: one per processor */
    size_t scene_cap_bytes; /* memory cap of a scene's arena, 0: none */
    int64_t idle_ms;        /* the worker ends after so long without work; 0: never */
    int64_t lease_ms;       /* 0: 15 s */
    int64_t keep_ms;  /* for tests: the shortest time between two kept states of a batch; 0: by the
                         kind of batch, and by the time that keeping takes */
    int64_t batch_ms; /* for tests: how long a batch begins tiles; 0: three seconds */
    int64_t housekeeping_ms; /* for tests: between rounds of the housekeeping; 0: a second */
    int max_seconds;         /* a job that is expected to take longer fails; 0: none does */
    struct pen_trace *trace; /* where the worker notes what it is doing; may be NULL */
    /* Called when render threads do not stop although their claim has ended. The store is then up
     * to date, and only the end of the process can end the threads. It must not return. NULL: the
     * worker waits for the threads. */
    void (*stuck)(void *user);
    /* Called by any thread of the worker when the store has an I/O error. Only a new process can
     * rely on the store again. It must not return. NULL: pen_worker_run fails at its next call. */
    void (*broken)(void *user, const struct pen_status *why);
    void *user;                           /* of `stuck` and `broken` */
    const struct pen_worker_fault *fault; /* NULL: none */
};

/* Works until there was no work for idle_ms, or *stop becomes true. When it must stop, it finishes
 * its current batch, but gives a study back to the store. Wake the store (pen_store_wake) after
 * setting *stop.
 * Fails: the store cannot be opened, or one of its calls fails with an error that a repetition
 * cannot cure. */
bool pen_worker_run(const struct pen_worker_options *options, const atomic_bool *stop,
                    struct pen_status *st);

/* A report on a worker process that has ended, from its supervisor. */
struct pen_worker_report {
    const char *worker;
    enum pen_worker_end end;
    const char *how;               /* "signal 11 (SIGSEGV)", "exit code 3" */
    const struct pen_trace *trace; /* of that worker; NULL: none */
};

/* Opens the batches that the worker held, and charges and fails jobs, by the rules of
 * pen_store_worker_ended. *opened becomes the number of opened batches.
 * Fails: as pen_store_worker_ended. */
bool pen_jobs_worker_ended(struct pen_store *store, const struct pen_worker_report *report,
                           int *opened, struct pen_status *st);

#endif

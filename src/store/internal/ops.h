/* SPDX-License-Identifier: MIT */
/* What an engine behind store.h implements. Each pen_store_* function is one entry of the same
 * name and meaning; the dispatcher (store.c) adds only the wake-up hints, so an engine deals with
 * the database alone. It says through the head of its handle what readers and workers should hear
 * of, and what went wrong; what follows from that is health.h's to decide. */
#ifndef PEN_STORE_INTERNAL_OPS_H
#define PEN_STORE_INTERNAL_OPS_H

#include "store/store.h"

struct pen_wake;

/* What can be wrong with a store; see health.h. */
enum pen_fault {
    PEN_FAULT_FULL,   /* no room: nothing is broken */
    PEN_FAULT_IO,     /* a read, write or fsync failed: what the handle believes may not be so */
    PEN_FAULT_DAMAGE, /* what was read cannot be */
    PEN_FAULT_COUNT
};

/* The head of every engine's handle. */
struct pen_store {
    const struct pen_store_ops *ops;
    const char *name; /* for messages; the engine's */
    struct pen_wake *wake;
    bool work;              /* out: since the dispatcher last looked, a batch became claimable */
    bool changed;           /* out: a job changed */
    bool others_checkpoint; /* in: the handle's commits leave settling to another */
    bool checkpoint_due;    /* out: it is time for that */
    int64_t transactions;   /* out: writing ones that were committed */
    const struct pen_store_observer *observer; /* NULL: none */
    unsigned faults;                           /* out: bits of enum pen_fault that were met */
    int fault_errno;                           /* out: of the last one, 0 if not known */
    /* health.c's: */
    int depth;      /* of calls: callbacks may call again */
    bool closed;    /* the engine's handle must be opened anew, or could not be */
    uint32_t epoch; /* the store's faults when the engine's handle was opened */
};

struct pen_store_ops {
    void (*close)(struct pen_store *store);
    bool (*check)(struct pen_store *store, struct pen_status *st);
    bool (*probe)(struct pen_store *store, struct pen_status *st);
    /* Whether there is room for more than a trifle: writes about a MiB, and takes it back. */
    bool (*space)(struct pen_store *store, struct pen_status *st);
    /* Closes the database without writing to it, and opens it anew; an existing one only. After a
     * failure nothing but this and close may be called. */
    bool (*reopen)(struct pen_store *store, struct pen_status *st);
    bool (*submit)(struct pen_store *store, const struct pen_job_new *job,
                   enum pen_submit_result *result, struct pen_buf *first_answer,
                   struct pen_status *st);
    bool (*job)(struct pen_store *store, const char *id, struct pen_job_record *job,
                struct pen_status *st);
    bool (*jobs)(struct pen_store *store, const struct pen_job_filter *filter,
                 struct pen_job_record **jobs, int *count, struct pen_status *st);
    bool (*scene)(struct pen_store *store, const char *id, struct pen_buf *scene,
                  struct pen_status *st);
    bool (*cancel)(struct pen_store *store, const char *id, struct pen_status *st);
    bool (*remove)(struct pen_store *store, const char *id, struct pen_status *st);
    bool (*claim)(struct pen_store *store, const char *worker, int64_t lease_ms,
                  struct pen_claim *claim, bool *found, struct pen_status *st);
    bool (*commit)(struct pen_store *store, const struct pen_claim *claim,
                   const struct pen_result *result, struct pen_next *next, struct pen_status *st);
    bool (*progress)(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                     struct pen_status *st);
    bool (*release)(struct pen_store *store, const struct pen_claim *claim, struct pen_status *st);
    bool (*fail)(struct pen_store *store, const struct pen_claim *claim, const char *error,
                 struct pen_status *st);
    bool (*heartbeat)(struct pen_store *store, const struct pen_claim *claim, int64_t lease_ms,
                      bool *held, struct pen_status *st);
    bool (*expire_leases)(struct pen_store *store, const char *dead_worker, int *opened,
                          struct pen_status *st);
    bool (*worker_ended)(struct pen_store *store, const struct pen_worker_death *death, int *opened,
                         struct pen_status *st);
    bool (*pixels)(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                   void *user, struct pen_status *st);
    bool (*stats)(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                  struct pen_status *st);
    bool (*batches)(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                    struct pen_status *st);
    bool (*commits)(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                    void *user, struct pen_status *st);
    bool (*worker_seen)(struct pen_store *store, const char *name, int threads, int64_t lease_ms,
                        struct pen_status *st);
    bool (*worker_gone)(struct pen_store *store, const char *name, struct pen_status *st);
    bool (*workers)(struct pen_store *store, pen_worker_fn *each, void *user,
                    struct pen_status *st);
    bool (*artefact)(struct pen_store *store, const char *id, int view, const char *layer,
                     const char *format, struct pen_buf *out, struct pen_status *st);
    bool (*artefact_put)(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, const void *data, size_t bytes, struct pen_status *st);
    bool (*checkpoint)(struct pen_store *store, struct pen_status *st);
    bool (*purge)(struct pen_store *store, int64_t key_age_ms, struct pen_status *st);
    bool (*audit)(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                  struct pen_status *st);
};

/* Opens the SQLite engine on a file. */
struct pen_store *pen_sqlite_open(const char *path, struct pen_status *st);

/* As pen_store_backup. */
bool pen_sqlite_backup(const char *path, const char *file, bool replace, struct pen_backup *out,
                       struct pen_status *st);

#endif

/* SPDX-License-Identifier: MIT */
/* A store in its own folder, and jobs to put in it, for tests of the modules store and jobs. Only
 * store.c knows the URL. Its engine is PEN_STORE_ENGINE, by default sqlite. So the tests hold for
 * every engine, except tests/store/test_sqlite_*.c. */
#ifndef TESTS_SUPPORT_STORE_H
#define TESTS_SUPPORT_STORE_H

#include "store/store.h"

struct store_bed {
    char folder[64], url[96];
    char schema[16]; /* of a PostgreSQL store; else empty */
    struct pen_store *store;
};

/* Makes the folder and the URL, and opens nothing. A test that forks calls this, then forks, then
 * opens the store, because a handle must not be used across a fork. */
void store_bed_make(struct store_bed *bed);

/* Opens a new store, in the folder of store_bed_make or in a new folder. The test fails if it
 * cannot. */
void store_bed_open(struct store_bed *bed);

/* Makes the bed's store take its time from *time_ms, which only the test changes. */
void store_bed_set_clock(const struct store_bed *bed, int64_t *time_ms);

/* Checks the store, closes it and removes the folder. The test fails if the store is damaged. */
void store_bed_close(struct store_bed *bed);

/* Returns another handle on the bed's store. */
struct pen_store *store_bed_handle(const struct store_bed *bed);

enum { STORE_JOB_BATCHES = 64, STORE_JOB_TILE = 4 };

/* A job of `views` views, each of `batches` batches of one tile of 4x4 pixels. Fields may be
 * changed before it is submitted. It must not be moved. */
struct store_job {
    char id[PEN_ID_BYTES], scene[64];
    unsigned char sha256[32];
    struct pen_view_new view[8];
    struct pen_batch_new batch[STORE_JOB_BATCHES];
    struct pen_job_new job;
};

/* Number n gives the id and, modulo 8, the scene. */
void store_job_init(struct store_job *job, int n, int views, int batches);

/* Makes a job that is one study of `runs` runs. */
void store_study_init(struct store_job *job, int n, int runs);

/* Submits a job; fails the test unless it was created. */
void store_job_submit(struct pen_store *store, const struct store_job *job);

/* The length of leases that must not end in a test: longer than any test takes, on any machine. */
enum { STORE_LEASE_MS = 3600 * 1000 };

/* Claims a batch, for STORE_LEASE_MS; fails the test if none is open. */
struct pen_claim store_claim(struct pen_store *store, const char *worker);

/* Commits the result that the batch needs: pixels, which depend only on the tile, and a picture if
 * the batch ends its view. Returns the code. */
enum pen_code store_commit(struct pen_store *store, const struct pen_claim *claim);

/* Claims and commits until nothing is left; returns the number of batches. */
int store_work_off(struct pen_store *store, const char *worker);

/* Stores an artefact of a job in any state, without a claim. */
struct store_artefact {
    const char *id;
    int view;
    const char *layer, *format;
    const void *data;
    size_t bytes;
};
void store_put(struct pen_store *store, const struct store_artefact *artefact);

/* Reports that a worker was killed by another process; returns the number of batches opened. */
int store_worker_died(struct pen_store *store, const char *id);

/* Does all housekeeping that deletes have left, in slices; returns their number. */
int store_purge_slices(struct pen_store *store);

/* Puts a worker with two threads on the list of workers. */
void store_worker_seen(struct pen_store *store, const char *id);

/* Returns the job; the caller releases it. */
struct pen_job_record store_job_get(struct pen_store *store, const char *id);
enum pen_job_state store_job_state(struct pen_store *store, const char *id);

/* Fails the test with the message of the status, unless ok. */
void store_must(bool ok, const struct pen_status *st, const char *what);

#endif

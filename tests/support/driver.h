/* SPDX-License-Identifier: MIT */
/* The drivers that the contract of store/internal/driver.h is tested against, a store of such a
 * driver, and calls in transactions and races. A test program of the contract is
 * tests/store/test_driver_*.c; it knows no driver: every test runs once for each of driver_kinds.
 *
 * A new driver takes one line in driver_kinds (driver.c). */
#ifndef TESTS_SUPPORT_DRIVER_H
#define TESTS_SUPPORT_DRIVER_H

#include <check.h>

#include "store/internal/driver.h"
#include "support/store.h"

/* How the storage under a driver is made to fail. */
enum driver_failure {
    DRIVER_FULL,       /* every write finds no space left */
    DRIVER_COMMIT_LOST /* a commit fails after its changes were sent: a sync, or the connection */
};

struct driver_kind {
    const char *name;
    /* Names a place for a new store: a path, an address. */
    void (*make)(char place[160]);
    struct pen_driver *(*open)(const char *place, struct pen_status *st);
    void (*remove)(const char *place);
    /* Prepares the process for failures, before the first open. */
    void (*install_failures)(void);
    /* From here on handles of this process fail, until heal. */
    void (*break_storage)(enum driver_failure failure);
    void (*heal)(void);
};

extern const struct driver_kind driver_kinds[];
extern const int driver_kind_count;

/* Test programs of the contract end with this. Each test is a libcheck loop test: `_i` is the
 * driver's index, for driver_bed_open. */
int driver_suite_run(const char *name, const TTest *const *tests, int count);

#define DRIVER_SUITE(name, ...)                                                                    \
    int main(void)                                                                                 \
    {                                                                                              \
        const TTest *const tests[] = {__VA_ARGS__};                                                \
        return driver_suite_run(name, tests, (int)(sizeof tests / sizeof tests[0]));               \
    }

struct driver_bed {
    const struct driver_kind *kind;
    char place[160];
    struct pen_driver *driver;
};

/* A new store of a driver, and a handle on it. */
void driver_bed_open(struct driver_bed *bed, int kind);

/* A further handle; its owner closes it with ops->close. */
struct pen_driver *driver_bed_handle(const struct driver_bed *bed);

/* Removes all jobs, whatever their state; fails the test if the audit then finds rows that they
 * have left, or the check finds damage; removes the store. */
void driver_bed_close(struct driver_bed *bed);

/* Fails the test if the audit finds anything. */
void driver_audit_clean(struct pen_driver *driver);

/* Calls an operation that must succeed. RUN: one that takes a status and nothing else. */
#define DRIVER_DO(driver, op, ...)                                                                 \
    do {                                                                                           \
        struct pen_status driver_st;                                                               \
        store_must((driver)->ops->op((driver), __VA_ARGS__, &driver_st), &driver_st, #op);         \
    } while (0)
#define DRIVER_RUN(driver, op)                                                                     \
    do {                                                                                           \
        struct pen_status driver_st;                                                               \
        store_must((driver)->ops->op((driver), &driver_st), &driver_st, #op);                      \
    } while (0)

/* Runs `body` in a write transaction. The driver may refuse with PEN_UNAVAILABLE because of a
 * concurrent transaction; nothing has happened then, and the whole is repeated. */
typedef bool driver_body(struct pen_driver *driver, void *arg, struct pen_status *st);
bool driver_write(struct pen_driver *driver, driver_body *body, void *arg, struct pen_status *st);

/* What driver_submit has stored. */
enum { DRIVER_BATCHES = 8 };
struct driver_job {
    int64_t number, scene;
    int64_t batch[DRIVER_BATCHES]; /* numbers, in order */
    int batch_count;
};

/* Stores scene, job, views and batches in a transaction of its own. */
struct driver_job driver_submit(struct pen_driver *driver, const struct store_job *in);

/* The same with store_job_init's fields and a priority. */
struct driver_job driver_submit_new(struct pen_driver *driver, int n, int views, int batches,
                                    int priority);

/* Row of a job by its number n of store_job_init; the test fails if there is none. */
struct pen_job_row driver_job_row(struct pen_driver *driver, int n);
struct pen_batch_row driver_batch_row(struct pen_driver *driver, int64_t batch);

/* Leases a batch under an attempt, in a transaction of its own. Returns whether it was open. */
bool driver_lease(struct pen_driver *driver, int64_t batch, int64_t attempt, const char *worker,
                  int64_t until_ms);

/* Several racers that begin at the same time, each with a handle of its own. */
enum driver_racers { DRIVER_THREADS, DRIVER_PROCESSES, DRIVER_RACER_KINDS };
enum { DRIVER_RACERS = 4, DRIVER_RACE_VALUES = 64 };

struct driver_race {
    struct driver_bed *bed; /* its handle is closed during the race */
    const void *user;
    /* Of each racer; shared between processes. */
    int64_t value[DRIVER_RACERS][DRIVER_RACE_VALUES];
    bool ok[DRIVER_RACERS];
    struct pen_status st[DRIVER_RACERS];
    _Atomic int ready;
};

typedef bool driver_racer(struct pen_driver *driver, struct driver_race *race, int racer,
                          struct pen_status *st);

/* Runs the race; the test fails unless every racer returns true. Returns what the racers wrote.
 * Owns: static, until the next race. */
const struct driver_race *driver_race(struct driver_bed *bed, enum driver_racers racers,
                                      driver_racer *body, const void *user);

#endif

/* SPDX-License-Identifier: MIT */
#include "support/driver.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/faults.h"

static void sqlite_make(char place[160])
{
    char folder[] = "/tmp/penumbra-test-XXXXXX";
    ck_assert_ptr_nonnull(mkdtemp(folder));
    snprintf(place, 160, "%s/penumbra.db", folder);
}

static void sqlite_remove(const char *place)
{
    char command[256];
    snprintf(command, sizeof command, "rm -rf \"$(dirname %s)\"", place);
    ck_assert_int_eq(system(command), 0);
}

static struct pen_driver *sqlite_open(const char *place, struct pen_status *st)
{
    return pen_sqlite_open(place, NULL, st);
}

static void sqlite_break(enum driver_failure failure)
{
    static const struct fault_plan plans[] = {
        [DRIVER_FULL] = {.calls = FAULT_WRITE, .mode = FAULT_FROM, .n = 1, .error = ENOSPC},
        [DRIVER_COMMIT_LOST] = {.calls = FAULT_SYNC, .mode = FAULT_FROM, .n = 1, .error = EIO},
    };
    faults_arm(&plans[failure]);
}

static void sqlite_heal(void)
{
    ck_assert_msg(faults_disarm() > 0, "the failure was never met");
}

const struct driver_kind driver_kinds[] = {
    {"sqlite", sqlite_make, sqlite_open, sqlite_remove, faults_install, sqlite_break, sqlite_heal},
};
const int driver_kind_count = (int)(sizeof driver_kinds / sizeof driver_kinds[0]);

int driver_suite_run(const char *name, const TTest *const *tests, int count)
{
    Suite *suite = suite_create(name);
    TCase *tcase = tcase_create(name);
    tcase_set_timeout(tcase, 300);
    for (int i = 0; i < count; i++)
        tcase_add_loop_test(tcase, tests[i], 0, driver_kind_count);
    suite_add_tcase(suite, tcase);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}

struct pen_driver *driver_bed_handle(const struct driver_bed *bed)
{
    struct pen_status st;
    struct pen_driver *driver = bed->kind->open(bed->place, &st);
    store_must(driver != NULL, &st, bed->kind->name);
    return driver;
}

void driver_bed_open(struct driver_bed *bed, int kind)
{
    *bed = (struct driver_bed){.kind = &driver_kinds[kind]};
    bed->kind->make(bed->place);
    bed->driver = driver_bed_handle(bed);
}

static bool remove_job(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    const struct pen_job_record *job = arg;
    bool changed;
    return driver->ops->job_end(driver, job->number, PEN_JOB_CANCELLED, NULL, 1, &changed, st) &&
           driver->ops->job_remove(driver, job->number, st) &&
           driver->ops->scene_remove_unused(driver, 0, st);
}

static void remove_jobs(struct pen_driver *driver)
{
    struct pen_job_filter filter = {.state = -1, .limit = 1};
    struct pen_job_row row;
    struct pen_status st;
    int count = 1;
    while (count > 0) {
        DRIVER_DO(driver, job_page, &filter, &row, &count);
        if (count > 0) {
            store_must(driver_write(driver, remove_job, &row.record, &st), &st, "remove");
            pen_job_record_release(&row.record);
        }
    }
}

void driver_audit_clean(struct pen_driver *driver)
{
    struct pen_buf findings = {0};
    int found = -1;
    DRIVER_DO(driver, audit, &findings, &found);
    ck_assert_msg(found == 0, "%d findings, first: %s", found,
                  findings.data ? (const char *)findings.data : "");
    pen_buf_release(&findings);
}

void driver_bed_close(struct driver_bed *bed)
{
    remove_jobs(bed->driver);
    driver_audit_clean(bed->driver);
    DRIVER_RUN(bed->driver, check);
    bed->driver->ops->close(bed->driver);
    bed->kind->remove(bed->place);
}

/* Nothing has happened after PEN_UNAVAILABLE, so the body runs again. */
enum { TRIES = 100 };

bool driver_write(struct pen_driver *driver, driver_body *body, void *arg, struct pen_status *st)
{
    for (int i = 0; i < TRIES; i++) {
        if (driver->ops->begin_write(driver, st)) {
            if (body(driver, arg, st) && driver->ops->commit(driver, st))
                return true;
            driver->ops->rollback(driver);
        }
        if (st->code != PEN_UNAVAILABLE)
            break;
    }
    return false;
}

struct submission {
    const struct store_job *in;
    struct driver_job *out;
};

static bool add_scene(struct pen_driver *driver, const struct pen_job_new *job, int64_t *number,
                      struct pen_status *st)
{
    struct pen_blob_start document = {
        .total = job->scene_bytes, .data = job->scene, .bytes = job->scene_bytes};
    bool found, added;
    if (!driver->ops->scene_find(driver, job->scene_sha256, number, &found, st))
        return false;
    return found ||
           driver->ops->scene_add(driver, job->scene_sha256, &document, number, &added, st);
}

static bool add_parts(struct pen_driver *driver, const struct pen_job_new *job, int64_t number,
                      struct pen_status *st)
{
    bool added;
    for (int v = 0; v < job->view_count; v++) {
        if (!driver->ops->view_add(driver, number, v, &job->views[v],
                                   job->batch_count / job->view_count, st))
            return false;
    }
    for (int b = 0; b < job->batch_count; b++) {
        struct pen_batch_add add = {.job = number, .batch = job->batches[b]};
        if (!driver->ops->batch_add(driver, &add, &added, st))
            return false;
    }
    return true;
}

static bool write_submission(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    const struct submission *submission = arg;
    const struct pen_job_new *job = &submission->in->job;
    struct driver_job *out = submission->out;
    int64_t pixels = 0;
    bool added;
    for (int b = 0; b < job->batch_count; b++)
        pixels += job->batches[b].pixels;
    if (!add_scene(driver, job, &out->scene, st) ||
        !driver->ops->job_add(driver, job, out->scene, pixels, &out->number, &added, st))
        return false;
    return added ? add_parts(driver, job, out->number, st)
                 : pen_fail(st, PEN_CONFLICT, "there is a job %s", job->id);
}

struct driver_job driver_submit(struct pen_driver *driver, const struct store_job *in)
{
    struct driver_job out = {0};
    struct submission submission = {in, &out};
    struct pen_batch_record rows[DRIVER_BATCHES];
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_status st;
    ck_assert_int_le(in->job.batch_count, DRIVER_BATCHES);
    store_must(driver_write(driver, write_submission, &submission, &st), &st, "submit");
    DRIVER_DO(driver, batch_page, out.number, 0, arena, rows, DRIVER_BATCHES, &out.batch_count);
    for (int i = 0; i < out.batch_count; i++)
        out.batch[i] = rows[i].batch;
    pen_arena_free(arena);
    return out;
}

struct driver_job driver_submit_new(struct pen_driver *driver, int n, int views, int batches,
                                    int priority)
{
    struct store_job in;
    store_job_init(&in, n, views, batches);
    in.job.priority = priority;
    return driver_submit(driver, &in);
}

struct pen_job_row driver_job_row(struct pen_driver *driver, int n)
{
    struct store_job in;
    struct pen_job_row row;
    bool found = false;
    store_job_init(&in, n, 1, 1);
    DRIVER_DO(driver, job_get, in.id, &row, &found);
    ck_assert_msg(found, "job %s is not there", in.id);
    return row;
}

struct pen_batch_row driver_batch_row(struct pen_driver *driver, int64_t batch)
{
    struct pen_batch_row row;
    bool found = false;
    DRIVER_DO(driver, batch_get, batch, &row, &found);
    ck_assert_msg(found, "batch %lld is not there", (long long)batch);
    return row;
}

struct lease {
    int64_t batch, attempt, until_ms;
    const char *worker;
    bool changed;
};

static bool write_lease(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    struct lease *in = arg;
    return driver->ops->batch_lease(driver, in->batch, in->attempt, in->worker, in->until_ms,
                                    &in->changed, st);
}

bool driver_lease(struct pen_driver *driver, int64_t batch, int64_t attempt, const char *worker,
                  int64_t until_ms)
{
    struct lease in = {batch, attempt, until_ms, worker, false};
    struct pen_status st;
    store_must(driver_write(driver, write_lease, &in, &st), &st, "lease");
    return in.changed;
}

struct runner {
    struct driver_race *race;
    driver_racer *body;
    int number;
};

/* Opens a handle, waits until all racers have one, and runs the body. */
static void *race_one(void *arg)
{
    const struct runner *runner = arg;
    struct driver_race *race = runner->race;
    int i = runner->number;
    struct pen_driver *driver = race->bed->kind->open(race->bed->place, &race->st[i]);
    atomic_fetch_add(&race->ready, 1);
    while (atomic_load(&race->ready) < DRIVER_RACERS)
        sched_yield();
    race->ok[i] = driver && runner->body(driver, race, i, &race->st[i]);
    if (driver)
        driver->ops->close(driver);
    return NULL;
}

static void race_threads(struct runner *runners)
{
    pthread_t thread[DRIVER_RACERS];
    for (int i = 0; i < DRIVER_RACERS; i++)
        ck_assert_int_eq(pthread_create(&thread[i], NULL, race_one, &runners[i]), 0);
    for (int i = 0; i < DRIVER_RACERS; i++)
        pthread_join(thread[i], NULL);
}

static void race_processes(struct runner *runners)
{
    pid_t pid[DRIVER_RACERS];
    for (int i = 0; i < DRIVER_RACERS; i++) {
        pid[i] = fork();
        ck_assert_int_ge(pid[i], 0);
        if (pid[i] == 0) {
            race_one(&runners[i]);
            _exit(0);
        }
    }
    for (int i = 0; i < DRIVER_RACERS; i++)
        ck_assert_int_eq(waitpid(pid[i], NULL, 0), pid[i]);
}

const struct driver_race *driver_race(struct driver_bed *bed, enum driver_racers racers,
                                      driver_racer *body, const void *user)
{
    static struct driver_race *race;
    struct runner runners[DRIVER_RACERS];
    if (!race)
        race = mmap(NULL, sizeof *race, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ck_assert_ptr_ne(race, MAP_FAILED);
    memset(race, 0, sizeof *race);
    race->bed = bed;
    race->user = user;
    for (int i = 0; i < DRIVER_RACERS; i++)
        runners[i] = (struct runner){race, body, i};
    bed->driver->ops->close(bed->driver); /* handles must not be carried across a fork */
    if (racers == DRIVER_THREADS)
        race_threads(runners);
    else
        race_processes(runners);
    bed->driver = driver_bed_handle(bed);
    for (int i = 0; i < DRIVER_RACERS; i++)
        store_must(race->ok[i], &race->st[i], "racer");
    return race;
}

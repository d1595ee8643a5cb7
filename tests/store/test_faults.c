/* SPDX-License-Identifier: MIT */
/* A disk that fails below SQLite, at the n-th call for every n: whatever a call of the store says
 * must be so. One that succeeded has done its work; one that failed has done all or nothing, says
 * what is wrong with which store, and leaves a handle that works as soon as the disk does. */
#include <errno.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "pen/base/log.h"
#include "support/faults.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static char template_path[128];

/* Numbers of the jobs in the template. */
enum { QUEUED = 1, HALF = 2, LAST = 3, ENDED = 4, FRESH = 5 };

static struct pen_claim held[4]; /* leased in the template: HALF's two batches, LAST's assemble */

static void copy_file(const char *from, const char *to)
{
    char command[400];
    snprintf(command, sizeof command, "cp %s %s", from, to);
    ck_assert_int_eq(system(command), 0);
}

/* What can be seen of a store, times left out; a row of a probe is not seen. */
static const char dump_sql[] =
    "SELECT 'job', id, state, revision, done_pixels, open_views, error IS NULL, charges, deaths"
    " FROM job UNION ALL "
    "SELECT 'view', job, view, batches, open_batches, 0, 0, 0, 0 FROM view UNION ALL "
    "SELECT 'batch', id, state, attempt, worker, kind, stats, suspect, revision FROM batch"
    " UNION ALL "
    "SELECT 'pixels', batch, hex(data), 0, 0, 0, 0, 0, 0 FROM pixels UNION ALL "
    "SELECT 'artefact', job, view, layer, format, hex(data), 0, 0, 0 FROM artefact UNION ALL "
    "SELECT 'key', key, answer, hex(body_sha256), 0, 0, 0, 0, 0 FROM idempotency WHERE key <> ''"
    " UNION ALL "
    "SELECT 'scene', id, hex(sha256), hex(document), 0, 0, 0, 0, 0 FROM scene UNION ALL "
    "SELECT 'worker', name, threads, lease_ms, 0, 0, 0, 0, 0 FROM worker";

static int dump_row(void *user, int columns, char **value, char **name)
{
    struct pen_buf *out = user;
    (void)name;
    for (int i = 0; i < columns; i++)
        pen_buf_printf(out, "%s ", value[i] ? value[i] : "-");
    pen_buf_puts(out, "\n");
    return 0;
}

static struct pen_buf dump(void)
{
    sqlite3 *db;
    char *error = NULL;
    struct pen_buf out = {0};
    pen_buf_puts(&out, "store\n");
    ck_assert_int_eq(sqlite3_open_v2(bed.url, &db, SQLITE_OPEN_READWRITE, "unix"), SQLITE_OK);
    sqlite3_db_config(db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    sqlite3_exec(db, dump_sql, dump_row, &out, &error);
    ck_assert_msg(!error, "%s", error);
    sqlite3_close(db);
    ck_assert(!out.failed);
    return out;
}

static bool same(const struct pen_buf *a, const struct pen_buf *b)
{
    return a->bytes == b->bytes && memcmp(a->data, b->data, a->bytes) == 0;
}

/* Starts over from the template. */
static void set_up(void)
{
    static const char *const ends[] = {"-wal", "-shm", "-wake", "-new", "-journal"};
    char path[160];
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        snprintf(path, sizeof path, "%s%s", bed.url, ends[i]);
        unlink(path);
    }
    faults_forget();
    copy_file(template_path, bed.url);
}

static void make_template(void)
{
    struct store_job in;
    struct pen_status st;
    store_bed_open(&bed);
    snprintf(template_path, sizeof template_path, "%s/template", bed.folder);
    store_job_init(&in, ENDED, 1, 1);
    store_job_submit(bed.store, &in);
    store_work_off(bed.store, "w");
    store_job_init(&in, LAST, 1, 2);
    store_job_submit(bed.store, &in);
    for (int i = 0; i < 2; i++) {
        struct pen_claim claim = store_claim(bed.store, "w");
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    }
    held[2] = store_claim(bed.store, "w");
    store_job_init(&in, HALF, 1, 2);
    store_job_submit(bed.store, &in);
    held[0] = store_claim(bed.store, "w");
    held[1] = store_claim(bed.store, "gone");
    store_job_init(&in, QUEUED, 1, 1);
    store_job_submit(bed.store, &in);
    store_must(pen_store_worker_seen(bed.store, "w", 2, 60000, &st), &st, "seen");
    pen_store_close(bed.store);
    copy_file(bed.url, template_path);
}

static void clear_up(void)
{
    set_up();
    unlink(template_path);
    bed.store = store_bed_handle(&bed);
    store_bed_close(&bed);
}

static const char *id_of(int n)
{
    static char id[PEN_ID_BYTES];
    struct store_job in;
    store_job_init(&in, n, 1, 1);
    memcpy(id, in.id, sizeof id);
    return id;
}

typedef bool work_fn(struct pen_status *st);

/* With a key: whoever is told that it failed asks again with that. */
static bool work_submit(struct pen_status *st)
{
    static const unsigned char body[32] = {1};
    struct store_job in;
    struct pen_buf answer = {0};
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    store_job_init(&in, FRESH, 2, 2);
    in.job.idempotency_key = "key";
    in.job.body_sha256 = body;
    in.job.answer = "{}";
    bool ok = pen_store_submit(bed.store, &in.job, &result, &answer, st);
    ck_assert(!ok || result != PEN_SUBMIT_REUSED);
    pen_buf_release(&answer);
    return ok;
}

static bool work_claim(struct pen_status *st)
{
    struct pen_claim claim;
    bool found = false;
    bool ok = pen_store_claim(bed.store, "x", 60000, &claim, &found, st);
    ck_assert_msg(!ok || found, "there is nothing to claim");
    return ok;
}

static float rgb[STORE_JOB_TILE * STORE_JOB_TILE * 3];

static struct pen_result render_result(void)
{
    return (struct pen_result){
        .stats = "{}", .rgb = rgb, .pixels = STORE_JOB_TILE * STORE_JOB_TILE};
}

static bool work_commit(struct pen_status *st)
{
    struct pen_result result = render_result();
    return pen_store_commit(bed.store, &held[0], &result, st);
}

static bool work_commit_and_claim(struct pen_status *st)
{
    struct pen_result result = render_result();
    struct pen_next next = {.worker = "x", .lease_ms = 60000};
    return pen_store_commit_and_claim(bed.store, &held[1], &result, &next, st);
}

static bool work_assemble(struct pen_status *st)
{
    struct pen_result result = {.stats = "{}",
                                .layer = "beauty",
                                .format = "png",
                                .artefact = "picture",
                                .artefact_bytes = 7};
    return pen_store_commit(bed.store, &held[2], &result, st);
}

static bool work_cancel(struct pen_status *st)
{
    return pen_store_cancel(bed.store, id_of(HALF), st);
}

static bool work_delete(struct pen_status *st)
{
    return pen_store_delete(bed.store, id_of(ENDED), st);
}

static bool work_fail(struct pen_status *st)
{
    return pen_store_fail(bed.store, &held[0], "{}", st);
}

static bool work_release(struct pen_status *st)
{
    return pen_store_release(bed.store, &held[0], st);
}

static bool work_sweep(struct pen_status *st)
{
    int opened;
    return pen_store_sweep(bed.store, "gone", &opened, st);
}

static bool work_picture(struct pen_status *st)
{
    static char data[100000];
    return pen_store_artefact_put(bed.store, id_of(ENDED), 0, "beauty", "pfm", data, sizeof data,
                                  st);
}

static bool work_tidy(struct pen_status *st)
{
    return pen_store_tidy(bed.store, 0, st);
}

static bool work_open(struct pen_status *st)
{
    struct pen_store *store = pen_store_open(bed.url, st);
    pen_store_close(store);
    return store != NULL;
}

static const struct scenario {
    const char *name;
    work_fn *work;
    enum pen_code again; /* what a repeat says when the first time had its effect */
} scenarios[] = {
    {"submit", work_submit, PEN_OK},
    {"claim", work_claim, PEN_OK},
    {"commit", work_commit, PEN_OK},
    {"commit and claim", work_commit_and_claim, PEN_OK},
    {"assemble", work_assemble, PEN_OK},
    {"cancel", work_cancel, PEN_OK},
    {"delete", work_delete, PEN_NOT_FOUND},
    {"fail", work_fail, PEN_STALE},
    {"release", work_release, PEN_OK},
    {"sweep", work_sweep, PEN_OK},
    {"picture", work_picture, PEN_OK},
    {"tidy", work_tidy, PEN_OK},
    {"open", work_open, PEN_OK},
};
enum { SCENARIOS = (int)(sizeof scenarios / sizeof scenarios[0]) };

static const struct fault_plan plans[] = {
    {.calls = FAULT_WRITE, .mode = FAULT_ONCE, .error = ENOSPC},
    {.calls = FAULT_WRITE, .mode = FAULT_FROM, .error = ENOSPC, .torn = true},
    {.calls = FAULT_WRITE, .mode = FAULT_ONCE, .error = EIO, .torn = true},
    {.calls = FAULT_WRITE, .mode = FAULT_EVERY, .error = EIO},
    {.calls = FAULT_WRITE | FAULT_SYNC, .mode = FAULT_FROM, .error = EIO},
    {.calls = FAULT_SYNC, .mode = FAULT_ONCE, .error = EIO},
    {.calls = FAULT_SYNC, .mode = FAULT_EVERY, .error = EIO},
    {.calls = FAULT_SYNC, .mode = FAULT_FROM, .error = ENOSPC},
    {.calls = FAULT_READ, .mode = FAULT_ONCE, .error = EIO},
    {.calls = FAULT_READ, .mode = FAULT_FROM, .error = EIO},
    {.calls = FAULT_TRUNCATE | FAULT_SHM, .mode = FAULT_ONCE, .error = EIO},
    {.calls = FAULT_ALL, .mode = FAULT_FROM, .error = EIO},
};
enum { PLANS = (int)(sizeof plans / sizeof plans[0]) };

static struct pen_buf before, after;
static long injected; /* faults, over all */

static void describe(const struct scenario *s, const struct fault_plan *plan, char out[160])
{
    static const char *const modes[] = {"once at", "every", "from"};
    snprintf(out, 160, "%s, calls %u fail with %s %s %ld", s->name, plan->calls,
             strerror(plan->error), modes[plan->mode], plan->n);
}

static void check_refusal(const struct fault_plan *plan, const struct pen_status *st,
                          const char *what)
{
    bool full = st->code == PEN_STORAGE_FULL;
    ck_assert_msg(full || st->code == PEN_STORAGE, "%s: %s: %s", what, pen_code_name(st->code),
                  st->msg);
    ck_assert_msg(full == (plan->error == ENOSPC), "%s: %s", what, st->msg);
    ck_assert_msg(strstr(st->msg, bed.url) != NULL, "%s: %s", what, st->msg);
}

/* The disk works again: so must the handle, at once, with what was asked and with all else. */
static void check_healed(const struct scenario *s, bool done, const char *what)
{
    struct pen_status st = {0};
    bool claims = s->work == work_claim; /* again, it is another claim */
    if (s->work == work_open)
        bed.store = store_bed_handle(&bed);
    if (!(claims && done)) {
        bool ok = s->work(&st);
        ck_assert_msg(ok || (done && st.code == s->again), "%s, healed: %s", what, st.msg);
        struct pen_buf now = dump();
        ck_assert_msg(same(&now, &after), "%s, healed: the store is\n%s, not\n%s", what, now.data,
                      after.data);
        pen_buf_release(&now);
    }
    ck_assert_msg(pen_store_probe(bed.store, &st), "%s, healed: %s", what, st.msg);
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
}

/* Runs a scenario under a plan. Returns whether a fault was met. */
static bool run_faulty(const struct scenario *s, const struct fault_plan *plan)
{
    char what[160];
    struct pen_status st = {0};
    describe(s, plan, what);
    set_up();
    bed.store = s->work == work_open ? NULL : store_bed_handle(&bed);
    faults_arm(plan);
    bool ok = s->work(&st);
    long failed = faults_disarm();
    injected += failed;
    if (!ok)
        check_refusal(plan, &st, what);
    struct pen_buf now = dump();
    bool done = same(&now, &after);
    ck_assert_msg(done || (!ok && same(&now, &before)), "%s: %s, and the store is\n%s", what,
                  ok ? "succeeded" : "failed", now.data);
    pen_buf_release(&now);
    check_healed(s, done, what);
    ck_assert_msg(!faults_synced_again(), "%s: synced again after a failure", what);
    return failed > 0;
}

static void expect_effect(const struct scenario *s)
{
    struct pen_status st = {0};
    set_up();
    before = dump();
    bed.store = store_bed_handle(&bed);
    store_must(s->work(&st), &st, s->name);
    after = dump();
    pen_store_close(bed.store);
}

static void run_plans(int first, int end)
{
    pen_log_set_level(PEN_LOG_ERROR + 1); /* thousands of lines */
    faults_install();
    make_template();
    for (int i = 0; i < SCENARIOS; i++) {
        expect_effect(&scenarios[i]);
        long runs = 0;
        for (int k = first; k < end; k++) {
            struct fault_plan plan = plans[k];
            for (plan.n = 1; run_faulty(&scenarios[i], &plan); plan.n++)
                runs++;
        }
        printf("%s: %ld runs, %ld faults\n", scenarios[i].name, runs, injected);
        ck_assert(runs > 0 || scenarios[i].work == work_open); /* which only reads */
        pen_buf_release(&before);
        pen_buf_release(&after);
    }
    clear_up();
}

static void remove_store(void)
{
    set_up();
    unlink(bed.url);
}

/* A new store is there whole or not at all. */
static bool make_faulty(const struct fault_plan *plan)
{
    struct pen_status st = {0};
    struct stat info;
    remove_store();
    faults_arm(plan);
    bed.store = pen_store_open(bed.url, &st);
    bool failed = faults_disarm() > 0;
    bool there = stat(bed.url, &info) == 0;
    ck_assert(there || !bed.store);
    if (!bed.store)
        check_refusal(plan, &st, "make");
    pen_store_close(bed.store);
    bed.store = store_bed_handle(&bed);
    ck_assert(!there || pen_store_check(bed.store, &st));
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
    return failed;
}

START_TEST(test_faults__making_a_store)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install();
    make_template();
    for (int k = 0; k < PLANS; k++) {
        struct fault_plan plan = plans[k];
        for (plan.n = 1; make_faulty(&plan); plan.n++)
            continue;
    }
    clear_up();
}
END_TEST

/* Takes the template back to the schema before the workers' table. */
static void age_template(void)
{
    sqlite3 *db;
    ck_assert_int_eq(sqlite3_open_v2(template_path, &db, SQLITE_OPEN_READWRITE, "unix"), SQLITE_OK);
    ck_assert_int_eq(
        sqlite3_exec(db, "DROP TABLE worker; PRAGMA user_version = 3", NULL, NULL, NULL),
        SQLITE_OK);
    sqlite3_close(db);
}

static bool migrate_faulty(const struct fault_plan *plan)
{
    struct pen_status st = {0};
    set_up();
    faults_arm(plan);
    bed.store = pen_store_open(bed.url, &st);
    bool failed = faults_disarm() > 0;
    if (!bed.store)
        check_refusal(plan, &st, "migrate");
    pen_store_close(bed.store);
    bed.store = store_bed_handle(&bed);
    store_must(pen_store_worker_seen(bed.store, "w", 2, 60000, &st), &st, "seen");
    ck_assert_int_eq(store_job_state(bed.store, id_of(HALF)), PEN_JOB_RUNNING);
    ck_assert_int_eq(store_job_state(bed.store, id_of(ENDED)), PEN_JOB_SUCCEEDED);
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
    return failed;
}

START_TEST(test_faults__migration)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install();
    make_template();
    age_template();
    for (int k = 0; k < PLANS; k++) {
        struct fault_plan plan = plans[k];
        for (plan.n = 1; migrate_faulty(&plan); plan.n++)
            continue;
    }
    clear_up();
}
END_TEST

/* Does a scenario until the disk stops for good at call n, and cuts the power. */
static bool run_to_power_cut(const struct scenario *s, long n, uint64_t seed)
{
    char what[160];
    struct pen_status st = {0};
    struct fault_plan plan = {.calls = FAULT_WRITE | FAULT_SYNC | FAULT_TRUNCATE,
                              .mode = FAULT_FROM,
                              .n = n,
                              .error = EIO};
    describe(s, &plan, what);
    set_up();
    bed.store = store_bed_handle(&bed);
    faults_arm(&plan);
    bool ok = s->work(&st);
    pen_store_close(bed.store);
    bool failed = faults_disarm() > 0;
    faults_cut_power(seed);
    bed.store = store_bed_handle(&bed);
    struct pen_buf now = dump();
    ck_assert_msg(same(&now, &after) || (!ok && same(&now, &before)),
                  "%s, power cut with seed %llu: %s, and the store is\n%s", what,
                  (unsigned long long)seed, ok ? "succeeded" : "failed", now.data);
    pen_buf_release(&now);
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
    return failed;
}

START_TEST(test_faults__power_cuts)
{
    enum { SEEDS = 3 };
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install();
    faults_remember();
    make_template();
    for (int i = 0; i < SCENARIOS; i++) {
        if (scenarios[i].work == work_open)
            continue;
        expect_effect(&scenarios[i]);
        long cuts = 0;
        for (uint64_t seed = 1; seed <= SEEDS; seed++) {
            for (long n = 1; run_to_power_cut(&scenarios[i], n, seed * 1000 + (uint64_t)n); n++)
                cuts++;
        }
        printf("%s: %ld power cuts\n", scenarios[i].name, cuts);
        ck_assert_int_gt(cuts, 0);
        pen_buf_release(&before);
        pen_buf_release(&after);
    }
    clear_up();
}
END_TEST

START_TEST(test_faults__writes)
{
    run_plans(0, 5);
}
END_TEST

START_TEST(test_faults__syncs)
{
    run_plans(5, 8);
}
END_TEST

START_TEST(test_faults__reads_and_the_rest)
{
    run_plans(8, PLANS);
}
END_TEST

PEN_SUITE("store faults", test_faults__writes, test_faults__syncs, test_faults__reads_and_the_rest,
          test_faults__making_a_store, test_faults__migration, test_faults__power_cuts)

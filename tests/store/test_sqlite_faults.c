/* SPDX-License-Identifier: MIT */
/* A disk that fails below SQLite, at the n-th call for every n.
 *   - A call of the store that returns true has had its effect. A call that fails has had no
 *     effect, or its outcome is unknown: full effect or none. pen_store_failure says which.
 *   - After a full disk, a handle works once there is space. After an I/O error the handle is
 *     broken, and says so; a new handle works.
 *   - Damage that is noticed, such as a failed sync, is not written over: nothing is synced
 * again. */
#include <errno.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/fault_bed.h"
#include "support/random.h"
#include "support/store_rows.h"
#include "support/suite.h"

static struct fault_bed disk;

/* All rows of a store without their times. Values that are being written belong to nobody yet. */
static const char dump_sql[] =
    "SELECT 'job', id, state, revision, done_pixels, open_views, error IS NULL, charges, losses,"
    " work, removed_ms > 0 FROM job UNION ALL "
    "SELECT 'view', job, view, batches, open_batches, 0, 0, 0, 0, 0, 0 FROM view UNION ALL "
    "SELECT 'batch', number, state, attempt, worker, kind, stats, alone, revision, turn, 0"
    " FROM batch UNION ALL "
    "SELECT 'value', o.job, o.view, o.batch, o.layer, o.format, o.bytes, o.checksum,"
    " hex(substr(p.data, 1, 20)), length(p.data), 0 FROM object o, part p WHERE o.state = 1 AND "
    "p.object = o.number UNION ALL "
    "SELECT 'key', client, key, answer, hex(body_sha256), 0, 0, 0, 0, 0, 0 FROM key UNION ALL "
    "SELECT 'scene', number, hex(sha256), 0, 0, 0, 0, 0, 0, 0, 0 FROM scene UNION ALL "
    "SELECT 'removed', id, client, stats, 0, 0, 0, 0, 0, 0, 0 FROM removed UNION ALL "
    "SELECT 'worker', id, threads, lease_ms, 0, 0, 0, 0, 0, 0, 0 FROM worker";

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
    ck_assert_int_eq(sqlite3_open_v2(disk.bed.url, &db, SQLITE_OPEN_READWRITE, "unix"), SQLITE_OK);
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

typedef bool work_fn(struct pen_status *st);

enum { PART_BYTES = (1 << 20) + 1000 }; /* more than one part of a value */

/* With a key, as a client has that repeats a submit after a failure. */
static bool work_submit(struct pen_status *st)
{
    static const unsigned char body[32] = {1};
    struct store_job in;
    struct pen_buf answer = {0};
    enum pen_submit_result result = PEN_SUBMIT_REUSED;
    store_job_init(&in, FAULT_FRESH, 2, 2);
    in.job.idempotency_key = "key";
    in.job.body_sha256 = body;
    in.job.answer = "{}";
    bool ok = pen_store_submit(disk.bed.store, &in.job, &result, &answer, st);
    ck_assert(!ok || result != PEN_SUBMIT_REUSED);
    pen_buf_release(&answer);
    return ok;
}

static bool work_claim(struct pen_status *st)
{
    struct pen_claim claim;
    bool found = false;
    const bool ok = pen_store_claim(disk.bed.store, "x", 60000, 1, &claim, &found, st);
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
    return pen_store_commit(disk.bed.store, &disk.held[0], &result, NULL, st);
}

static bool work_commit_and_claim(struct pen_status *st)
{
    struct pen_result result = render_result();
    struct pen_next next = {.worker = "x", .lease_ms = 60000, .serial = 1};
    return pen_store_commit(disk.bed.store, &disk.held[1], &result, &next, st);
}

static bool work_assemble(struct pen_status *st)
{
    struct pen_result result = {.stats = "{}",
                                .layer = "beauty",
                                .format = "png",
                                .artefact = "picture",
                                .artefact_bytes = 7};
    return pen_store_commit(disk.bed.store, &disk.held[2], &result, NULL, st);
}

static bool work_cancel(struct pen_status *st)
{
    return pen_store_cancel(disk.bed.store, fault_bed_id(FAULT_HALF), NULL, st);
}

static bool work_delete(struct pen_status *st)
{
    return pen_store_delete(disk.bed.store, fault_bed_id(FAULT_ENDED), NULL, "{}", st);
}

static bool work_fail(struct pen_status *st)
{
    return pen_store_fail(disk.bed.store, &disk.held[0], "{}", st);
}

static bool work_release(struct pen_status *st)
{
    return pen_store_release(disk.bed.store, &disk.held[0], st);
}

static bool work_worker_ended(struct pen_status *st)
{
    const struct pen_worker_death death = {.worker = "gone", .end = PEN_WORKER_DIED};
    int opened;
    return pen_store_worker_ended(disk.bed.store, &death, &opened, st);
}

static bool work_keep(struct pen_status *st)
{
    static char part[PART_BYTES];
    const struct pen_kept_part parts[] = {{"part", part, sizeof part}};
    const struct pen_kept kept = {
        .done = -1, .data = "state", .bytes = 5, .parts = parts, .part_count = 1};
    bool outranked;
    return pen_store_keep(disk.bed.store, &disk.held[0], &kept, &outranked, st);
}

static bool work_picture(struct pen_status *st)
{
    static char data[100000];
    return pen_store_artefact_put(disk.bed.store, &disk.held[0], "depth", "pfm", data, sizeof data,
                                  st);
}

/* The rows of a job go after it was deleted. */
static bool work_purge(struct pen_status *st)
{
    bool more = true;
    if (!work_delete(st) && st->code != PEN_GONE)
        return false;
    while (more) {
        if (!pen_store_purge(disk.bed.store, &more, st))
            return false;
    }
    return true;
}

static bool work_open(struct pen_status *st)
{
    struct pen_store *store = pen_store_open(disk.bed.url, false, st);
    pen_store_close(store);
    return store != NULL;
}

static const struct scenario {
    const char *name;
    work_fn *work;
    enum pen_code again; /* the code of a repeat after the first call had its effect */
    bool slices;         /* several transactions, each with an effect */
} scenarios[] = {
    {"submit", work_submit, PEN_OK, false},
    {"claim", work_claim, PEN_OK, false},
    {"commit", work_commit, PEN_OK, false},
    {"commit and claim", work_commit_and_claim, PEN_OK, false},
    {"assemble", work_assemble, PEN_OK, false},
    {"keep", work_keep, PEN_OK, false},
    {"picture", work_picture, PEN_OK, false},
    {"cancel", work_cancel, PEN_OK, false},
    {"delete", work_delete, PEN_GONE, false},
    {"fail", work_fail, PEN_STALE, false},
    {"release", work_release, PEN_OK, false},
    {"worker ended", work_worker_ended, PEN_OK, false},
    {"purge", work_purge, PEN_OK, true},
    {"open", work_open, PEN_OK, false},
};
enum { SCENARIOS = (int)(sizeof scenarios / sizeof scenarios[0]) };

static struct pen_buf before, after;
static long injected, unknowns, unknowns_done; /* in all runs */

static void describe(const struct scenario *s, const struct fault_plan *plan, char out[160])
{
    static const char *const modes[] = {"once at", "every", "from"};
    snprintf(out, 160, "%s, calls %u fail with %s %s %ld", s->name, plan->calls,
             strerror(plan->error), modes[plan->mode], plan->n);
}

/* The disk works again, and so does the handle. */
static void check_healed(const struct scenario *s, bool ok, const char *what)
{
    struct pen_status st = {0};
    if (!disk.bed.store)
        disk.bed.store = store_bed_handle(&disk.bed);
    const bool again = s->work(&st);
    ck_assert_msg(again || st.code == s->again, "%s, healed: %s", what, st.msg);
    ck_assert_msg(again || !ok || s->again != PEN_OK, "%s, healed: %s", what, st.msg);
    struct pen_buf now = dump();
    ck_assert_msg(same(&now, &after), "%s, healed: the store is\n%s, not\n%s", what, now.data,
                  after.data);
    pen_buf_release(&now);
    ck_assert_int_eq(store_contradictions(disk.bed.url), 0);
    bool finished;
    store_must(pen_store_check(disk.bed.store, 0, &finished, &st), &st, what);
    pen_store_close(disk.bed.store);
}

/* Runs a scenario under a plan. Returns whether the plan made a call fail. */
static bool run_faulty(const struct scenario *s, const struct fault_plan *plan)
{
    char what[160];
    struct pen_status st = {0};
    bool unknown = false;
    describe(s, plan, what);
    fault_bed_renew(&disk);
    disk.bed.store = s->work == work_open ? NULL : store_bed_handle(&disk.bed);
    faults_arm(plan);
    const bool ok = s->work(&st);
    const long failed = faults_disarm();
    injected += failed;
    if (!ok) {
        fault_bed_check_refusal(&disk, plan, &st, what);
        unknown = disk.bed.store && pen_store_failure(disk.bed.store, &st) == PEN_FAILURE_UNKNOWN;
        ck_assert_msg(!disk.bed.store ||
                          (st.code == PEN_STORAGE) == pen_store_is_broken(disk.bed.store, NULL),
                      "%s: %s", what, st.msg);
    }
    if (disk.bed.store && pen_store_is_broken(disk.bed.store, NULL)) {
        pen_store_close(disk.bed.store); /* the next one recovers from the log */
        disk.bed.store = store_bed_handle(&disk.bed);
    }
    struct pen_buf now = dump();
    const bool done = same(&now, &after), undone = same(&now, &before);
    ck_assert_msg(ok ? done : undone || (unknown && done) || s->slices,
                  "%s: %s, and the store is\n%s", what,
                  ok        ? "succeeded"
                  : unknown ? "failed, unknown"
                            : "failed",
                  now.data);
    unknowns += unknown;
    unknowns_done += unknown && done;
    pen_buf_release(&now);
    check_healed(s, ok, what);
    ck_assert_msg(!faults_synced_again(), "%s: synced again after a failure", what);
    return failed > 0;
}

static void expect_effect(const struct scenario *s)
{
    struct pen_status st = {0};
    fault_bed_renew(&disk);
    before = dump();
    disk.bed.store = store_bed_handle(&disk.bed);
    store_must(s->work(&st), &st, s->name);
    after = dump();
    pen_store_close(disk.bed.store);
}

static void run_plans(int first, int end)
{
    fault_bed_open(&disk);
    for (int i = 0; i < SCENARIOS; i++) {
        expect_effect(&scenarios[i]);
        long runs = 0;
        for (int k = first; k < end; k++) {
            struct fault_plan plan = fault_plans[k];
            for (plan.n = 1; run_faulty(&scenarios[i], &plan); plan.n = fault_next(plan.n, k))
                runs++;
        }
        printf("%s: %ld runs, %ld faults, %ld unknown outcomes, %ld of them done\n",
               scenarios[i].name, runs, injected, unknowns, unknowns_done);
        ck_assert(runs > 0 || scenarios[i].work == work_open); /* opening only reads */
        pen_buf_release(&before);
        pen_buf_release(&after);
    }
    fault_bed_close(&disk);
}

/* Runs a scenario on a disk that stops for good at call n, then cuts the power. */
static bool run_to_power_cut(const struct scenario *s, long n, uint64_t seed)
{
    char what[160];
    struct pen_status st = {0};
    struct fault_plan plan = {.calls = FAULT_WRITE | FAULT_SYNC | FAULT_TRUNCATE,
                              .mode = FAULT_FROM,
                              .n = n,
                              .error = EIO};
    describe(s, &plan, what);
    fault_bed_renew(&disk);
    disk.bed.store = store_bed_handle(&disk.bed);
    faults_arm(&plan);
    bool ok = s->work(&st);
    pen_store_close(disk.bed.store);
    bool failed = faults_disarm() > 0;
    faults_cut_power(seed);
    disk.bed.store = store_bed_handle(&disk.bed);
    struct pen_buf now = dump();
    ck_assert_msg(same(&now, &after) || (!ok && (s->slices || same(&now, &before))),
                  "%s, power cut with seed %llu: %s, and the store is\n%s", what,
                  (unsigned long long)seed, ok ? "succeeded" : "failed", now.data);
    pen_buf_release(&now);
    ck_assert_int_eq(store_contradictions(disk.bed.url), 0);
    pen_store_close(disk.bed.store);
    return failed;
}

/* What a call that succeeded has done outlives a power cut right after it. */
static void cut_after_success(const struct scenario *s, uint64_t seed)
{
    struct pen_status st = {0};
    const struct fault_plan plan = {.calls = FAULT_WRITE | FAULT_SYNC | FAULT_TRUNCATE,
                                    .mode = FAULT_FROM,
                                    .n = 1,
                                    .error = EIO};
    fault_bed_renew(&disk);
    disk.bed.store = store_bed_handle(&disk.bed);
    store_must(s->work(&st), &st, s->name);
    faults_arm(&plan);
    pen_store_close(disk.bed.store);
    faults_disarm();
    faults_cut_power(seed);
    disk.bed.store = store_bed_handle(&disk.bed);
    struct pen_buf now = dump();
    ck_assert_msg(same(&now, &after), "%s, then a power cut: the store is\n%s", s->name, now.data);
    pen_buf_release(&now);
    pen_store_close(disk.bed.store);
}

START_TEST(test_sqlite_faults__power_cuts)
{
    enum { SEEDS = 3 };
    fault_bed_open(&disk);
    faults_remember();
    for (int i = 0; i < SCENARIOS; i++) {
        if (scenarios[i].work == work_open)
            continue;
        expect_effect(&scenarios[i]);
        long cuts = 0;
        cut_after_success(&scenarios[i], 7);
        for (uint64_t seed = 1; seed <= (uint64_t)random_some(SEEDS, 1); seed++) {
            for (long n = 1; run_to_power_cut(&scenarios[i], n, seed * 1000 + (uint64_t)n);
                 n += n < 20 || random_all() ? 1 : 7) /* a large value is written in many calls */
                cuts++;
        }
        printf("%s: %ld power cuts\n", scenarios[i].name, cuts);
        ck_assert_int_gt(cuts, 0);
        pen_buf_release(&before);
        pen_buf_release(&after);
    }
    fault_bed_close(&disk);
}
END_TEST

START_TEST(test_sqlite_faults__writes)
{
    run_plans(0, 5);
}
END_TEST

START_TEST(test_sqlite_faults__syncs)
{
    run_plans(5, 8);
}
END_TEST

START_TEST(test_sqlite_faults__reads_and_the_rest)
{
    run_plans(8, FAULT_PLANS);
}
END_TEST

PEN_SUITE("store faults", test_sqlite_faults__writes, test_sqlite_faults__syncs,
          test_sqlite_faults__reads_and_the_rest, test_sqlite_faults__power_cuts)

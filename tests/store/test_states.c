/* SPDX-License-Identifier: MIT */
/* The state machine, exhaustively: every public operation is applied to a job in every situation.
 * Each change of state of the job or of a batch must be an arrow of the tables in states.h, with
 * that operation as its function, and every arrow of the tables must be seen. */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "store/states.h"
#include "support/store.h"
#include "support/suite.h"

enum { BATCHES = 2, ALL_BATCHES = BATCHES + 1 }; /* and an assemble batch */

/* A situation of a job: the states of its batches, and how it ended. */
struct situation {
    const char *name;
    int committed, leased; /* batches, of those in order: render, render, assemble */
    enum { GOES_ON, CANCELLED, FAILED } end;
};

static const struct situation situations[] = {
    {"queued", 0, 0, GOES_ON},
    {"one leased", 0, 1, GOES_ON},
    {"both leased", 0, 2, GOES_ON},
    {"one committed", 1, 0, GOES_ON},
    {"one committed, one leased", 1, 1, GOES_ON},
    {"assemble open", 2, 0, GOES_ON},
    {"assemble leased", 2, 1, GOES_ON},
    {"succeeded", 3, 0, GOES_ON},
    {"cancelled before it began", 0, 0, CANCELLED},
    {"cancelled while leased", 0, 2, CANCELLED},
    {"cancelled half way", 1, 1, CANCELLED},
    {"failed", 0, 2, FAILED},
    {"failed half way", 1, 1, FAILED},
};
enum { SITUATIONS = (int)(sizeof situations / sizeof situations[0]) };

static const char *const operations[] = {
    "pen_store_submit", "pen_store_claim",         "pen_store_commit",       "pen_store_release",
    "pen_store_fail",   "pen_store_expire_leases", "pen_store_cancel",       "pen_store_delete",
    "pen_store_purge",  "pen_store_heartbeat",     "pen_store_worker_ended",
};
enum { OPERATIONS = (int)(sizeof operations / sizeof operations[0]) };

struct snapshot {
    bool exists;
    enum pen_job_state job;
    int batch_count;
    enum pen_batch_state batch[ALL_BATCHES];
};

static bool note_batch(void *user, const struct pen_batch_record *batch)
{
    struct snapshot *snapshot = user;
    ck_assert_int_lt(snapshot->batch_count, ALL_BATCHES);
    snapshot->batch[snapshot->batch_count++] = batch->state;
    return true;
}

static struct snapshot take_snapshot(struct pen_store *store, const char *id)
{
    struct pen_status st;
    struct snapshot snapshot = {0};
    struct pen_job_record job;
    snapshot.exists = pen_store_job(store, id, &job, &st);
    if (!snapshot.exists)
        return snapshot;
    snapshot.job = job.state;
    pen_job_record_release(&job);
    store_must(pen_store_batches(store, id, note_batch, &snapshot, &st), &st, "batches");
    return snapshot;
}

/* Brings a new job into a situation; *last is the last claim taken, if there was one. */
static void bring(struct pen_store *store, const struct store_job *in, const struct situation *to,
                  struct pen_claim *last)
{
    struct pen_status st;
    store_job_submit(store, in);
    for (int i = 0; i < to->committed + to->leased; i++) {
        *last = store_claim(store, "w");
        if (i < to->committed)
            ck_assert_int_eq(store_commit(store, last), PEN_OK);
    }
    if (to->end == FAILED)
        store_must(pen_store_fail(store, last, "{}", &st), &st, "fail");
    if (to->end == CANCELLED)
        store_must(pen_store_cancel(store, in->id, NULL, &st), &st, "cancel");
}

static char *death_error(void *user, const struct pen_claim *claim, int charges)
{
    (void)user;
    (void)claim;
    (void)charges;
    return strdup("{}");
}

/* The worker crashes; a job of one attempt fails by that. */
static void end_worker(struct pen_store *store, const struct store_job *in)
{
    struct pen_status st;
    int opened;
    struct pen_worker_death death = {
        .worker = "w", .end = PEN_WORKER_CRASHED, .error = death_error};
    store_must(pen_store_worker_ended(store, &death, &opened, &st), &st, in->id);
}

/* Applies an operation to the job, or under its last claim. The store may refuse it. */
static void apply(struct pen_store *store, const char *operation, const struct store_job *in,
                  struct pen_claim *last)
{
    struct pen_status st;
    struct pen_claim claim;
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    bool flag;
    int opened;
    if (strcmp(operation, "pen_store_submit") == 0) {
        store_must(pen_store_submit(store, &in->job, &result, &answer, &st), &st, "submit");
        ck_assert_int_eq(result, PEN_SUBMIT_KNOWN);
    } else if (strcmp(operation, "pen_store_claim") == 0)
        pen_store_claim(store, "x", 1000, &claim, &flag, &st);
    else if (strcmp(operation, "pen_store_commit") == 0)
        store_commit(store, last);
    else if (strcmp(operation, "pen_store_release") == 0)
        pen_store_release(store, last, &st);
    else if (strcmp(operation, "pen_store_fail") == 0)
        pen_store_fail(store, last, "{}", &st);
    else if (strcmp(operation, "pen_store_expire_leases") == 0)
        pen_store_expire_leases(store, "w", &opened, &st);
    else if (strcmp(operation, "pen_store_cancel") == 0)
        pen_store_cancel(store, in->id, NULL, &st);
    else if (strcmp(operation, "pen_store_delete") == 0)
        pen_store_delete(store, in->id, NULL, NULL, &st);
    else if (strcmp(operation, "pen_store_purge") == 0)
        pen_store_purge(store, 0, 0, &st);
    else if (strcmp(operation, "pen_store_worker_ended") == 0)
        end_worker(store, in);
    else
        pen_store_heartbeat(store, last, 1000, &flag, &st);
}

/* Marks the arrow as seen; fails the test when there is none. */
static void find_arrow(const struct pen_arrow *arrows, int count, bool *seen,
                       const struct pen_arrow *change, const char *situation)
{
    bool found = false;
    for (int i = 0; i < count; i++) {
        if (arrows[i].from == change->from && arrows[i].to == change->to &&
            strcmp(arrows[i].function, change->function) == 0)
            found = seen[i] = true;
    }
    if (!found)
        ck_abort_msg("%s: no arrow %d -> %d by %s", situation, change->from, change->to,
                     change->function);
}

static bool job_seen[32], batch_seen[32];

static void compare(const struct snapshot *before, const struct snapshot *after,
                    const char *operation, const char *situation)
{
    int jobs, batches;
    const struct pen_arrow *job_arrows = pen_job_arrows(&jobs);
    const struct pen_arrow *batch_arrows = pen_batch_arrows(&batches);
    if (!after->exists) {
        ck_assert_str_eq(operation, "pen_store_delete");
        ck_assert(pen_job_state_ended(before->job));
        return;
    }
    if (after->job != before->job)
        find_arrow(job_arrows, jobs, job_seen,
                   &(struct pen_arrow){(int)before->job, (int)after->job, operation}, situation);
    for (int i = 0; i < before->batch_count; i++) {
        if (after->batch[i] != before->batch[i])
            find_arrow(batch_arrows, batches, batch_seen,
                       &(struct pen_arrow){(int)before->batch[i], (int)after->batch[i], operation},
                       situation);
    }
    if (after->batch_count != before->batch_count) {
        ck_assert_str_eq(operation, "pen_store_commit");
        ck_assert_int_eq(after->batch[after->batch_count - 1], PEN_BATCH_OPEN);
    }
}

/* Tries one operation in one situation, in a store that is empty before and after. */
static void try_one(struct pen_store *store, int number, const struct situation *situation,
                    const char *operation, int max_attempts)
{
    struct store_job in;
    struct pen_claim last = {0};
    struct pen_status st;
    store_job_init(&in, number, 1, BATCHES);
    in.job.max_attempts = max_attempts;
    bring(store, &in, situation, &last);
    struct snapshot before = take_snapshot(store, in.id);
    apply(store, operation, &in, &last);
    struct snapshot after = take_snapshot(store, in.id);
    compare(&before, &after, operation, situation->name);
    store_audit_clean(store);
    pen_store_cancel(store, in.id, NULL, &st);
    pen_store_delete(store, in.id, NULL, NULL, &st);
}

#define expect(code_wanted, call)                                                                  \
    do {                                                                                           \
        struct pen_status st = {.code = PEN_OK};                                                   \
        (void)(call);                                                                              \
        ck_assert_msg(st.code == (code_wanted), "%s, %s: %s", situation->name, #call,              \
                      pen_code_name(st.code));                                                     \
    } while (0)

/* In one situation a client may do to its job what all may, and another client nothing. */
static void try_clients(struct pen_store *store, int number, const struct situation *situation)
{
    struct store_job in;
    struct pen_claim last = {0};
    store_job_init(&in, number, 1, BATCHES);
    in.job.client = "token:anna";
    bring(store, &in, situation, &last);
    struct snapshot before = take_snapshot(store, in.id);
    expect(PEN_FORBIDDEN, pen_store_cancel(store, in.id, "token:ann", &st));
    expect(PEN_FORBIDDEN, pen_store_delete(store, in.id, "address:anna", NULL, &st));
    expect(PEN_FORBIDDEN, pen_store_delete(store, in.id, "", "{}", &st));
    expect(PEN_FORBIDDEN, pen_store_check_client(store, in.id, "token:ann", &st));
    struct snapshot after = take_snapshot(store, in.id);
    ck_assert_int_eq(after.job, before.job);
    ck_assert_int_eq(after.batch_count, before.batch_count);
    ck_assert_mem_eq(after.batch, before.batch, sizeof before.batch);
    if (!pen_job_state_ended(before.job))
        expect(PEN_CONFLICT, pen_store_delete(store, in.id, "token:anna", "{}", &st));
    expect(PEN_OK, pen_store_cancel(store, in.id, "token:anna", &st));
    ck_assert(pen_job_state_ended(store_job_state(store, in.id)));
    expect(PEN_OK, pen_store_delete(store, in.id, "token:anna", "{}", &st));
    for (int purged = 0; purged < 2; purged++) {
        expect(PEN_GONE, pen_store_cancel(store, in.id, "token:ann", &st));
        expect(PEN_GONE, pen_store_delete(store, in.id, "token:ann", "{}", &st));
        expect(PEN_FORBIDDEN, pen_store_delete(store, in.id, "token:ann", NULL, &st));
        store_purge_slices(store);
    }
    expect(PEN_OK, pen_store_delete(store, in.id, "token:anna", NULL, &st));
    expect(PEN_GONE, pen_store_delete(store, in.id, "token:ann", NULL, &st));
    expect(PEN_NOT_FOUND, pen_store_cancel(store, "nobody", "token:ann", &st));
    expect(PEN_NOT_FOUND, pen_store_delete(store, "nobody", "token:ann", NULL, &st));
}

START_TEST(test_states__other_clients_neither_cancel_nor_delete)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    for (int s = 0; s < SITUATIONS; s++)
        try_clients(bed.store, s, &situations[s]);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_states__every_change_is_an_arrow_and_every_arrow_is_seen)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    for (int s = 0; s < SITUATIONS; s++) {
        for (int o = 0; o < 2 * OPERATIONS; o++)
            try_one(bed.store, 2 * s * OPERATIONS + o, &situations[s], operations[o / 2],
                    o % 2 ? 3 : 1);
    }
    store_bed_close(&bed);
    int count;
    const struct pen_arrow *arrows = pen_job_arrows(&count);
    for (int i = 0; i < count; i++)
        ck_assert_msg(job_seen[i], "job arrow %d -> %d by %s was never seen", arrows[i].from,
                      arrows[i].to, arrows[i].function);
    arrows = pen_batch_arrows(&count);
    for (int i = 0; i < count; i++)
        ck_assert_msg(batch_seen[i], "batch arrow %d -> %d by %s was never seen", arrows[i].from,
                      arrows[i].to, arrows[i].function);
}
END_TEST

START_TEST(test_states__no_arrow_leads_out_of_an_end)
{
    int count;
    const struct pen_arrow *arrows = pen_job_arrows(&count);
    for (int i = 0; i < count; i++) {
        ck_assert(!pen_job_state_ended((enum pen_job_state)arrows[i].from));
        ck_assert_int_ne(arrows[i].from, arrows[i].to);
    }
    arrows = pen_batch_arrows(&count);
    for (int i = 0; i < count; i++) {
        ck_assert(arrows[i].from != PEN_BATCH_DONE && arrows[i].from != PEN_BATCH_ENDED);
        ck_assert_int_ne(arrows[i].from, arrows[i].to);
    }
}
END_TEST

PEN_SUITE("store states", test_states__other_clients_neither_cancel_nor_delete,
          test_states__every_change_is_an_arrow_and_every_arrow_is_seen,
          test_states__no_arrow_leads_out_of_an_end)

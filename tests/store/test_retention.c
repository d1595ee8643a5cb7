/* SPDX-License-Identifier: MIT */
/* What a store keeps: by age, number and bytes, over a week of a clock that the test sets; when new
 * jobs are refused; and forms of pictures that are dropped for others. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/log.h"
#include "support/random.h"
#include "support/store_sql.h"
#include "support/suite.h"

static const int64_t hour_ms = 3600000;
static struct store_bed bed;
static int64_t time_ms;

static void open_bed(const struct pen_retention *keep)
{
    struct pen_status st;
    time_ms = INT64_C(1800000000000);
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &time_ms);
    store_must(pen_store_set_retention(bed.store, keep, &st), &st, "retention");
}

static enum pen_submit_result result; /* of the last submit */

static bool try_submit_with(int n, const char *key, struct pen_status *st)
{
    static const unsigned char body[32];
    struct store_job in;
    struct pen_buf answer = {0};
    store_job_init(&in, n, 1, 1);
    in.job.created_ms = time_ms;
    in.job.idempotency_key = key;
    in.job.body_sha256 = body;
    in.job.answer = "first";
    bool ok = pen_store_submit(bed.store, &in.job, &result, &answer, st);
    if (ok && result == PEN_SUBMIT_REPEATED)
        ck_assert_mem_eq(answer.data, "first", 5);
    pen_buf_release(&answer);
    return ok;
}

static bool try_submit(int n, struct pen_status *st)
{
    return try_submit_with(n, NULL, st);
}

/* A job that has ended, with a picture of so many bytes. */
static void add_job(int n, size_t bytes)
{
    static char picture[1 << 20];
    struct store_job in;
    struct pen_status st;
    store_must(try_submit(n, &st), &st, "submit");
    store_work_off(bed.store, "w");
    store_job_init(&in, n, 1, 1);
    picture[0] = (char)n;
    if (bytes)
        store_put(bed.store, &(struct store_artefact){in.id, 0, "depth", "pfm", picture, bytes});
}

/* What the worker's housekeeping does: removes what is too much, then in slices what that had. */
static int keep_house(void)
{
    char id[PEN_ID_BYTES];
    struct pen_status st;
    bool found = true;
    int removed = 0;
    for (;;) {
        store_must(pen_store_expired(bed.store, id, &found, &st), &st, "expired");
        if (found)
            store_must(pen_store_delete(bed.store, id, NULL, "{\"rays\": 1}", &st), &st, "delete");
        removed += found;
        if (store_purge_slices(bed.store) == 0 && !found)
            return removed;
    }
}

static bool is_kept(int n)
{
    struct store_job in;
    struct pen_job_record job;
    struct pen_status st;
    store_job_init(&in, n, 1, 1);
    if (pen_store_job(bed.store, in.id, &job, &st)) {
        pen_job_record_release(&job);
        return true;
    }
    ck_assert_msg(st.code == PEN_GONE, "%s", st.msg);
    return false;
}

START_TEST(test_retention__without_limits_nothing_is_removed)
{
    open_bed(&(struct pen_retention){0});
    for (int n = 0; n < 5; n++)
        add_job(n, 1 << 18);
    time_ms += 10000 * 24 * hour_ms;
    ck_assert_int_eq(keep_house(), 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__by_age_counts_from_the_end_of_a_job)
{
    open_bed(&(struct pen_retention){.keep_ms = 48 * hour_ms});
    for (int n = 0; n < 6; n++) {
        add_job(n, 0);
        time_ms += 12 * hour_ms;
    }
    /* 72 hours after the first end, 12 after the last one */
    ck_assert_int_eq(keep_house(), 2);
    for (int n = 0; n < 6; n++)
        ck_assert_int_eq(is_kept(n), n >= 2);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__by_number_keeps_those_that_ended_last)
{
    struct pen_status st;
    struct store_job in;
    open_bed(&(struct pen_retention){.keep_jobs = 3});
    store_must(try_submit(9, &st), &st, "submit");
    struct pen_claim late = store_claim(bed.store, "late"); /* the oldest job ends last */
    for (int n = 0; n < 5; n++) {
        time_ms += hour_ms;
        add_job(n, 0);
    }
    ck_assert_int_eq(keep_house(), 2);
    ck_assert(is_kept(9)); /* it is running */
    time_ms += hour_ms;
    ck_assert_int_eq(store_commit(bed.store, &late), PEN_OK);
    ck_assert_int_eq(keep_house(), 1);
    store_job_init(&in, 9, 1, 1);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
    for (int n = 0; n < 5; n++)
        ck_assert_int_eq(is_kept(n), n >= 3);
    store_bed_close(&bed);
}
END_TEST

static int64_t bytes_on_disk(void)
{
    char log[160];
    struct stat file, info;
    snprintf(log, sizeof log, "%s-wal", bed.url);
    ck_assert_int_eq(stat(bed.url, &file), 0);
    return (int64_t)file.st_size + (stat(log, &info) == 0 ? (int64_t)info.st_size : 0);
}

/* Every hour some jobs of random size; the store and its log stay within the limit. */
START_TEST(test_retention__a_week_of_load_stays_within_the_bytes)
{
    enum { MIB = 1 << 20, LIMIT = 40 * MIB, JOBS = 8 };
    const int hours = random_all() ? 7 * 24 : 3 * 24; /* three days replace all that is kept */
    struct random random = random_begin(14);
    struct pen_retention keep = {.keep_bytes = LIMIT}, read;
    struct pen_status st;
    int64_t longest = 0, stored = 0;
    int removed = 0;
    open_bed(&keep);
    store_must(pen_store_retention(bed.store, &read, &st), &st, "retention");
    ck_assert_mem_eq(&read, &keep, sizeof keep);
    for (int hour = 0, n = 0; hour < hours; hour++) {
        for (int i = 0; i < JOBS; i++, n++) {
            size_t bytes = (size_t)random_in(&random, 0, MIB);
            time_ms += hour_ms / JOBS;
            add_job(n, bytes);
            stored += (int64_t)bytes;
            removed += keep_house();
        }
        store_must(pen_store_purge(bed.store, 24 * hour_ms, 1827 * 24 * hour_ms, &st), &st,
                   "purge");
        longest = bytes_on_disk() > longest ? bytes_on_disk() : longest;
    }
    printf("%d jobs, %lld MiB stored, %d removed, at most %lld of %d MiB on disk\n", hours * JOBS,
           (long long)(stored / MIB), removed, (long long)(longest / MIB), LIMIT / MIB);
    ck_assert_int_gt(stored, 5 * (int64_t)LIMIT);
    ck_assert_int_gt(longest, LIMIT / 2);
    ck_assert_int_le(longest, LIMIT);
    ck_assert(is_kept(hours * JOBS - 1) && !is_kept(0));
    store_bed_close(&bed);
}
END_TEST

/* A job of so many pixels, whose results take what is expected of them: 10 bytes of a pixel. */
static bool try_submit_large(int n, int pixels, struct pen_status *st)
{
    struct store_job in;
    store_job_init(&in, n, 1, 1);
    in.job.created_ms = time_ms;
    in.view[0].width = pixels;
    in.view[0].height = 1;
    in.batch[0].pixels = pixels;
    return pen_store_submit(bed.store, &in.job, &result, NULL, st);
}

static bool work_off_large(struct random *random)
{
    static unsigned char picture[8 << 20];
    struct pen_claim claim;
    struct pen_status st;
    bool found;
    store_must(pen_store_claim(bed.store, "w", STORE_LEASE_MS, &claim, &found, &st), &st, "claim");
    if (!found)
        return false;
    const size_t bytes = (size_t)claim.pixels * 9;
    ck_assert_uint_le(bytes, sizeof picture);
    for (size_t i = 0; i < bytes; i += 8) {
        const uint64_t bits = random_bits(random);
        memcpy(picture + i, &bits, 8);
    }
    float *rgb = calloc((size_t)claim.pixels * 3, sizeof *rgb);
    ck_assert_ptr_nonnull(rgb);
    const struct pen_result large = {.rgb = rgb,
                                     .pixels = claim.pixels,
                                     .stats = "{}",
                                     .layer = "beauty",
                                     .format = "png",
                                     .artefact = picture,
                                     .artefact_bytes = bytes};
    store_must(pen_store_commit(bed.store, &claim, &large, &st), &st, "commit");
    free(rgb);
    return true;
}

/* Every hour more jobs with large results than the store may hold. Those that are accepted stay
 * within the limit, and some are accepted every hour, for which others that ended are removed. */
START_TEST(test_retention__a_queue_of_large_results_stays_within_the_bytes)
{
    enum {
        MIB = 1 << 20,
        LIMIT = 24 * MIB,
        LOG = 10 * MIB,
        HOURS = 12,
        JOBS = 30,
        PIXELS = 200000
    };
    struct random random = random_begin(15);
    struct pen_status st;
    int64_t longest = 0;
    int accepted = 0, n = 0;
    open_bed(&(struct pen_retention){.keep_bytes = LIMIT});
    for (int hour = 0; hour < HOURS; hour++, time_ms += hour_ms) {
        int now = 0;
        for (int i = 0; i < JOBS; i++, n++) {
            const bool ok = try_submit_large(n, PIXELS, &st);
            ck_assert_msg(ok || st.code == PEN_STORAGE_FULL, "%s", st.msg);
            now += ok;
            if (!ok) /* it is told to come again */
                keep_house();
        }
        ck_assert_int_gt(now, 0);
        accepted += now;
        while (work_off_large(&random))
            longest = bytes_on_disk() > longest ? bytes_on_disk() : longest;
        keep_house();
    }
    printf("half a day: %d of %d jobs accepted, at most %lld of %d MiB on disk\n", accepted,
           HOURS * JOBS, (long long)(longest / MIB), LIMIT / MIB);
    ck_assert_int_gt(accepted, 3 * HOURS);
    ck_assert_int_lt(accepted, HOURS * JOBS / 2);
    ck_assert_int_gt(longest, LIMIT / 2);
    ck_assert_int_le(longest, LIMIT + LOG);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__job_that_alone_takes_more_than_the_bytes_is_too_large)
{
    enum { MIB = 1 << 20, FITS = 400000 };
    struct pen_status st;
    open_bed(&(struct pen_retention){.keep_bytes = 8 * MIB});
    ck_assert(!try_submit_large(1, MIB, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_msg(strstr(st.msg, "(--keep-bytes)") != NULL, "%s", st.msg);
    /* the largest that fits is accepted alone, and the next one when that has ended and gone */
    store_must(try_submit_large(2, 2 * FITS, &st), &st, "submit");
    ck_assert(!try_submit_large(3, 1, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    struct random random = random_begin(16);
    ck_assert(work_off_large(&random));
    ck_assert(!try_submit_large(3, FITS, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert_int_eq(keep_house(), 0); /* for a minute it is kept for its client */
    time_ms += hour_ms;
    ck_assert_int_eq(keep_house(), 1);
    store_must(try_submit_large(3, FITS, &st), &st, "submit");
    /* What a job was expected to take is given back when it ends in any way. */
    struct store_job in;
    store_job_init(&in, 3, 1, 1);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    store_must(try_submit_large(4, FITS, &st), &st, "submit");
    /* A start counts anew; without a limit nothing is counted. */
    store_must(pen_store_set_retention(bed.store, &(struct pen_retention){0}, &st), &st, "none");
    store_must(try_submit_large(5, 100 * MIB, &st), &st, "submit");
    store_must(
        pen_store_set_retention(bed.store, &(struct pen_retention){.keep_bytes = 8 * MIB}, &st),
        &st, "again");
    store_audit_clean(bed.store);
    ck_assert(!try_submit_large(6, 1, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    store_bed_close(&bed);
}
END_TEST

/* Live jobs are never removed: new ones are refused instead, until they have ended. */
START_TEST(test_retention__intake_is_refused_at_the_limit_and_returns_by_itself)
{
    enum { MIB = 1 << 20 };
    static char picture[MIB];
    struct store_job in;
    struct pen_status st;
    open_bed(&(struct pen_retention){.keep_bytes = 4 * MIB});
    store_must(try_submit_with(1, "key", &st) && try_submit(3, &st), &st, "submit");
    struct pen_claim claim = store_claim(bed.store, "w");
    for (int view = 0; view < 5; view++)
        store_put(bed.store, &(struct store_artefact){claim.job_id, view, "depth", "pfm", picture,
                                                      sizeof picture});
    ck_assert_int_eq(keep_house(), 0);
    ck_assert(!try_submit(2, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert_msg(strstr(st.msg, "(--keep-bytes)") != NULL, "%s", st.msg);
    ck_assert(!pen_store_intake(bed.store, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    /* a submit that was answered before is answered again */
    store_must(try_submit_with(1, "key", &st), &st, "submit with a known key");
    ck_assert_int_eq(result, PEN_SUBMIT_REPEATED);
    store_must(try_submit(3, &st), &st, "submit of a known job");
    ck_assert_int_eq(result, PEN_SUBMIT_KNOWN);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK); /* what runs is finished */
    ck_assert_int_eq(keep_house(), 1); /* above the limit no minute is waited for its client */
    store_must(pen_store_intake(bed.store, &st), &st, "intake");
    store_must(try_submit(2, &st), &st, "submit");
    store_job_init(&in, 2, 1, 1);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_QUEUED);
    store_bed_close(&bed);
}
END_TEST

enum { STATE_MIB = 1 << 20 };
static char state[6 * STATE_MIB];

static enum pen_code keep_state(struct pen_store *store, const struct pen_claim *claim,
                                size_t bytes)
{
    const struct pen_kept kept = {.done = -1, .data = state, .bytes = bytes};
    struct pen_status st;
    bool outranked;
    return pen_store_keep(store, claim, &kept, &outranked, &st) ? PEN_OK : st.code;
}

static size_t kept_bytes(const struct pen_claim *claim)
{
    struct pen_buf out = {0};
    struct pen_status st;
    store_must(pen_store_kept(bed.store, claim, PEN_KEPT_STATE, &out, &st), &st, "kept");
    const size_t bytes = out.bytes;
    pen_buf_release(&out);
    return bytes;
}

/* A state that is replaced takes its space until it is gone. One that is refused costs nothing: the
 * one before it stays, and jobs are accepted. */
START_TEST(test_retention__states_are_kept_within_the_bytes)
{
    struct pen_status st;
    open_bed(&(struct pen_retention){.keep_bytes = 8 * STATE_MIB});
    store_must(try_submit(1, &st), &st, "submit");
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(keep_state(bed.store, &claim, 3 * STATE_MIB), PEN_OK);
    ck_assert_int_eq(keep_state(bed.store, &claim, 3 * STATE_MIB - 1), PEN_OK);
    ck_assert_int_eq(keep_state(bed.store, &claim, 3 * STATE_MIB), PEN_STORAGE_FULL);
    store_purge_slices(bed.store);
    ck_assert_int_eq(keep_state(bed.store, &claim, 5 * STATE_MIB), PEN_STORAGE_FULL);
    ck_assert_uint_eq(kept_bytes(&claim), 3 * STATE_MIB - 1);
    store_must(try_submit(2, &st), &st, "submit");
    ck_assert_int_eq(keep_state(bed.store, &claim, 3 * STATE_MIB), PEN_OK);
    store_purge_slices(bed.store);
    /* what unfinished jobs are expected to store is left free */
    store_must(try_submit_large(3, 398000, &st), &st, "submit");
    ck_assert_int_eq(keep_state(bed.store, &claim, 2 * STATE_MIB), PEN_STORAGE_FULL);
    ck_assert_int_eq(keep_state(bed.store, &claim, 1000), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

struct keeping {
    struct pen_store *store;
    struct pen_claim claim;
    enum pen_code code;
};

static void *keep_beside(void *user)
{
    struct keeping *keeping = user;
    keeping->code = keep_state(keeping->store, &keeping->claim, 5 * STATE_MIB);
    return NULL;
}

START_TEST(test_retention__states_kept_at_once_are_within_the_bytes_together)
{
    struct keeping keeping[2];
    struct pen_status st;
    pthread_t threads[2];
    open_bed(&(struct pen_retention){.keep_bytes = 8 * STATE_MIB});
    for (int i = 0; i < 2; i++) {
        store_must(try_submit(i, &st), &st, "submit");
        keeping[i].claim = store_claim(bed.store, i ? "w" : "v");
        keeping[i].store = store_bed_handle(&bed);
    }
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, keep_beside, &keeping[i]), 0);
    for (int i = 0; i < 2; i++)
        pthread_join(threads[i], NULL);
    ck_assert(keeping[0].code == PEN_STORAGE_FULL || keeping[1].code == PEN_STORAGE_FULL);
    for (int i = 0; i < 2; i++)
        pen_store_close(keeping[i].store);
    store_purge_slices(bed.store);
    ck_assert_int_eq(keep_state(bed.store, &keeping[0].claim, 1000), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

/* If nothing else is left, statistics go, too, those of jobs that were removed first before others.
 */
START_TEST(test_retention__statistics_are_within_the_bytes_too)
{
    enum { MIB = 1 << 20, JOBS = 150 };
    static char stats[64 << 10];
    struct store_job in;
    struct pen_status st;
    struct pen_buf out = {0};
    open_bed(&(struct pen_retention){.keep_bytes = 8 * MIB});
    memset(stats, 'x', sizeof stats - 1);
    for (int n = 0; n < JOBS; n++) {
        time_ms += hour_ms;
        store_must(try_submit(n, &st) || st.code == PEN_STORAGE_FULL, &st, "submit");
        store_work_off(bed.store, "w");
        store_job_init(&in, n, 1, 1);
        pen_store_delete(bed.store, in.id, NULL, stats, &st);
        store_purge_slices(bed.store);
        if (n % 10 == 9)
            keep_house();
    }
    store_must(pen_store_removed_stats(bed.store, in.id, &out, &st), &st, "statistics");
    store_job_init(&in, 0, 1, 1);
    ck_assert(!pen_store_removed_stats(bed.store, in.id, &out, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert_int_le(bytes_on_disk(), 8 * MIB + 4 * MIB);
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

static bool has_stats(int n)
{
    struct store_job in;
    struct pen_status st;
    struct pen_buf out = {0};
    store_job_init(&in, n, 1, 1);
    const bool ok = pen_store_removed_stats(bed.store, in.id, &out, &st);
    pen_buf_release(&out);
    ck_assert_msg(ok || st.code == PEN_NOT_FOUND, "%s", st.msg);
    return ok;
}

/* They have an eighth of the bytes, 7 of these; older ones go before any job. */
START_TEST(test_retention__old_statistics_go_before_fresh_results)
{
    enum { MIB = 1 << 20, JOBS = 54, KEPT = 7 };
    static char stats[64 << 10];
    const struct pen_retention none = {0}, keep = {.keep_bytes = 4 * MIB};
    struct store_job in;
    struct pen_status st;
    open_bed(&keep);
    memset(stats, 'x', sizeof stats - 1);
    for (int n = 0; n < JOBS; n++, time_ms += hour_ms) {
        add_job(n, 0);
        store_job_init(&in, n, 1, 1);
        store_must(pen_store_delete(bed.store, in.id, NULL, stats, &st), &st, "delete");
        store_purge_slices(bed.store);
    }
    add_job(JOBS, 0);
    time_ms += 61000;
    ck_assert_int_eq(keep_house(), 0);
    ck_assert(is_kept(JOBS));
    for (int n = 0; n < JOBS; n++)
        ck_assert_int_eq(has_stats(n), n >= JOBS - KEPT);
    /* Some that are dropped make space for others; a start counts anew. */
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "drop");
    store_audit_clean(bed.store);
    store_must(pen_store_set_retention(bed.store, &none, &st), &st, "none");
    add_job(JOBS + 1, 0);
    store_job_init(&in, JOBS + 1, 1, 1);
    store_must(pen_store_delete(bed.store, in.id, NULL, stats, &st), &st, "delete");
    store_must(pen_store_set_retention(bed.store, &keep, &st), &st, "again");
    ck_assert_int_eq(keep_house(), 0);
    ck_assert(has_stats(JOBS - KEPT) && has_stats(JOBS + 1));
    store_bed_close(&bed);
}
END_TEST

/* What is too large are other things: here keys, as stores of earlier versions have them. */
START_TEST(test_retention__nothing_goes_for_nothing)
{
    enum { MIB = 1 << 20, KEYS = 5 };
    static char answer[MIB];
    static const unsigned char body[32];
    struct store_job in;
    struct pen_status st;
    struct pen_buf out = {0};
    int n = 0;
    pen_log_set_level(PEN_LOG_ERROR);
    open_bed(&(struct pen_retention){.keep_bytes = 4 * MIB});
    add_job(1, 1 << 16);
    add_job(2, 0);
    store_job_init(&in, 2, 1, 1);
    store_must(pen_store_delete(bed.store, in.id, NULL, "{}", &st), &st, "delete");
    memset(answer, 'x', sizeof answer - 1);
    for (; n < KEYS; n++) {
        char key[20];
        snprintf(key, sizeof key, "key %d", n);
        store_job_init(&in, 10 + n, 1, 1);
        in.job.idempotency_key = key;
        in.job.body_sha256 = body;
        in.job.answer = answer;
        if (!pen_store_submit(bed.store, &in.job, &result, &out, &st)) {
            ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
            break;
        }
        store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
        store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    }
    time_ms += 2 * 60000;
    ck_assert_int_eq(keep_house(), 0);
    ck_assert(is_kept(1));
    store_job_init(&in, 2, 1, 1);
    store_must(pen_store_removed_stats(bed.store, in.id, &out, &st), &st, "statistics");
    ck_assert_int_lt(n, KEYS);
    for (int half = 0; half < 2; half++) { /* the clock does not jump */
        time_ms += 25 * hour_ms / 2;
        store_must(pen_store_purge(bed.store, 24 * hour_ms, 1827 * 24 * hour_ms, &st), &st,
                   "purge");
    }
    ck_assert_int_eq(keep_house(), 0);
    store_job_init(&in, 20, 1, 1);
    store_must(pen_store_submit(bed.store, &in.job, &result, &out, &st), &st, "submit");
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

/* A clock that was three days behind when a job ended, and was corrected: the job is seconds old.
 */
START_TEST(test_retention__by_age_waits_a_day_after_the_clock_has_jumped_ahead)
{
    const int64_t day_ms = 24 * hour_ms;
    struct pen_status st;
    open_bed(&(struct pen_retention){.keep_ms = day_ms});
    ck_assert_int_eq(keep_house(), 0);
    store_must(try_submit_with(1, "key", &st), &st, "submit");
    store_work_off(bed.store, "w");
    time_ms += 3 * day_ms;
    for (int hour = 0; hour < 24; hour++, time_ms += hour_ms) {
        ck_assert_int_eq(keep_house(), 0);
        store_must(pen_store_purge(bed.store, day_ms, day_ms, &st), &st, "purge");
        store_must(try_submit_with(1, "key", &st), &st, "submit");
        ck_assert_int_eq(result, PEN_SUBMIT_REPEATED);
    }
    ck_assert_int_eq(keep_house(), 1);
    store_bed_close(&bed);
}
END_TEST

/* A clock that jumped ahead and is right again: nothing waits for the day of the jump. */
START_TEST(test_retention__by_age_waits_no_longer_if_the_clock_is_set_back)
{
    const int64_t day_ms = 24 * hour_ms;
    open_bed(&(struct pen_retention){.keep_ms = day_ms});
    add_job(1, 0);
    ck_assert_int_eq(keep_house(), 0);
    time_ms += 300 * day_ms;
    ck_assert_int_eq(keep_house(), 0);
    time_ms -= 300 * day_ms;
    ck_assert_int_eq(keep_house(), 0);
    time_ms += day_ms;
    ck_assert_int_eq(keep_house(), 0);
    time_ms++;
    ck_assert_int_eq(keep_house(), 1);
    store_bed_close(&bed);
}
END_TEST

/* A clock that was a year ahead, and was set back. */
START_TEST(test_retention__jobs_of_a_clock_that_was_ahead_count_from_when_it_was_set_back)
{
    const int64_t day_ms = 24 * hour_ms, year_ms = 365 * day_ms;
    open_bed(&(struct pen_retention){.keep_ms = 2 * day_ms});
    add_job(1, 0);
    time_ms += year_ms;
    add_job(2, 0);
    time_ms -= year_ms;
    for (int day = 0; day < 2; day++) {
        ck_assert_int_eq(keep_house(), 0);
        time_ms += day_ms / 2;
        add_job(10 + day, 0);
        ck_assert_int_eq(keep_house(), 0);
        time_ms += day_ms / 2;
    }
    time_ms++;
    ck_assert_int_eq(keep_house(), 2);
    ck_assert(!is_kept(1) && !is_kept(2) && is_kept(10) && is_kept(11));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__jobs_of_a_clock_that_was_ahead_go_before_later_ones)
{
    enum { MIB = 1 << 20 };
    open_bed(&(struct pen_retention){.keep_bytes = 6 * MIB});
    time_ms += hour_ms;
    for (int n = 0; n < 4; n++)
        add_job(n, MIB);
    time_ms -= hour_ms;
    add_job(4, MIB);
    ck_assert_int_eq(keep_house(), 0); /* a minute for their clients, as ever */
    time_ms += 61000;
    add_job(5, MIB / 2);
    ck_assert_int_eq(keep_house(), 1);
    for (int n = 0; n < 6; n++)
        ck_assert_int_eq(is_kept(n), n >= 1);
    store_bed_close(&bed);
}
END_TEST

/* Another range of a large value was written just now. */
static void write_range(void)
{
    char sql[100];
    snprintf(sql, sizeof sql, "INSERT OR REPLACE INTO large_object VALUES (1, 9999, %lld)",
             (long long)time_ms + 60000);
    store_run_sql(&bed, sql, NULL, 0);
}

/* It may replace another value soon; but not all of many that follow each other do. */
START_TEST(test_retention__waits_a_minute_for_values_that_are_being_written)
{
    enum { MIB = 1 << 20, ROUND_MS = 10000 };
    open_bed(&(struct pen_retention){.keep_bytes = 8 * MIB});
    for (int n = 0; n < 7; n++, time_ms += hour_ms)
        add_job(n, MIB);
    for (int i = 0; i < 2; i++, time_ms += ROUND_MS) {
        write_range();
        ck_assert_int_eq(keep_house(), 0);
    }
    time_ms += 60000; /* its writer has died: it goes, and then jobs */
    ck_assert_int_eq(keep_house(), 1);
    ck_assert(is_kept(1) && !is_kept(0));
    add_job(7, MIB);
    time_ms += hour_ms;
    int removed = 0, rounds = 0;
    for (; removed == 0 && rounds < 20; rounds++, time_ms += ROUND_MS) {
        write_range();
        removed = keep_house();
    }
    ck_assert_int_eq(removed, 1);
    ck_assert_int_gt(rounds, 60000 / ROUND_MS);
    time_ms += 60000;
    keep_house();
    store_bed_close(&bed);
}
END_TEST

/* A job whose document has so many bytes, which are those of every such job. */
static void submit_with_document(int n, size_t bytes)
{
    static char document[2 << 20];
    struct store_job in;
    struct pen_status st;
    struct random random = random_begin(18);
    for (size_t i = 0; i < bytes; i++) /* it cannot be compressed */
        document[i] = (char)random_bits(&random);
    store_job_init(&in, n, 1, 1);
    in.job.created_ms = time_ms;
    in.job.scene = document;
    in.job.scene_bytes = bytes;
    memset(in.sha256, 0xd0, sizeof in.sha256);
    store_must(pen_store_submit(bed.store, &in.job, &result, NULL, &st), &st, "submit");
}

/* One document counts once, and not at all while it stays for an unfinished job. */
START_TEST(test_retention__jobs_that_share_a_document_do_not_go_for_nothing)
{
    enum { MIB = 1 << 20, JOBS = 6, DOCUMENT = 3 * MIB / 2 };
    static char picture[29 * MIB / 10];
    pen_log_set_level(PEN_LOG_ERROR);
    open_bed(&(struct pen_retention){.keep_bytes = 8 * MIB});
    for (int n = 0; n < JOBS; n++) {
        submit_with_document(n, DOCUMENT);
        store_work_off(bed.store, "w");
    }
    submit_with_document(JOBS, DOCUMENT);
    const struct pen_claim claim = store_claim(bed.store, "w");
    for (int view = 0; view < 2; view++)
        store_put(bed.store, &(struct store_artefact){.id = claim.job_id,
                                                      .view = view,
                                                      .layer = "depth",
                                                      .format = "pfm",
                                                      .data = picture,
                                                      .bytes = sizeof picture});
    time_ms += hour_ms;
    ck_assert_int_eq(keep_house(), 0);
    for (int n = 0; n < JOBS; n++)
        ck_assert(is_kept(n));
    /* Once all of them have ended they go, the one with the large pictures last. */
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    time_ms += hour_ms;
    ck_assert_int_eq(keep_house(), JOBS + 1);
    store_bed_close(&bed);
}
END_TEST

static bool has_form(const char *id, int view)
{
    struct pen_buf out = {0};
    struct pen_status st;
    bool ok = pen_store_artefact(bed.store, id, view, "beauty", "pfm", &out, &st);
    ck_assert(ok || st.code == PEN_NOT_FOUND);
    pen_buf_release(&out);
    return ok;
}

START_TEST(test_retention__cached_forms_are_bounded_and_the_least_used_go)
{
    enum { MIB = 1 << 20, FORMS = 8 }; /* an eighth of 32 MiB is 4 forms */
    static char picture[MIB + MIB / 4];
    struct store_job in;
    struct pen_status st;
    open_bed(&(struct pen_retention){.keep_bytes = 32 * MIB});
    add_job(1, 0);
    store_job_init(&in, 1, 1, 1);
    for (int view = 0; view < FORMS; view++) {
        time_ms += hour_ms;
        store_must(pen_store_cache_put(bed.store, in.id, view, "beauty", "pfm", picture, MIB, &st),
                   &st, "form");
        time_ms += hour_ms;
        ck_assert(has_form(in.id, 0)); /* it is used all the time */
    }
    for (int view = 0; view < FORMS; view++)
        ck_assert_int_eq(has_form(in.id, view), view == 0 || view >= FORMS - 3);
    /* One that is larger than all may be is not stored; another limit lets others go */
    static char large[5 * MIB];
    store_must(pen_store_cache_put(bed.store, in.id, 20, "beauty", "pfm", large, sizeof large, &st),
               &st, "large form");
    ck_assert(!has_form(in.id, 20));
    store_must(
        pen_store_set_retention(bed.store, &(struct pen_retention){.keep_bytes = 16 * MIB}, &st),
        &st, "retention");
    int evicted = 0;
    for (bool more = true; more; evicted += more)
        store_must(pen_store_evict(bed.store, &more, &st), &st, "evict");
    ck_assert_int_eq(evicted, 2);
    struct pen_buf out = {0};
    store_must(pen_store_artefact(bed.store, in.id, 0, "beauty", "png", &out, &st), &st,
               "the job's own picture");
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

/* As the housekeeping does. */
static void evict_forms(void)
{
    struct pen_status st;
    for (bool more = true; more;) {
        store_must(pen_store_evict(bed.store, &more, &st), &st, "evict");
        store_purge_slices(bed.store);
    }
}

static void put_forms(int count)
{
    static char form[1 << 20];
    struct store_job in;
    struct pen_status st;
    store_job_init(&in, 0, 1, 1);
    for (int view = 0; view < count; view++)
        store_must(
            pen_store_cache_put(bed.store, in.id, view, "beauty", "pfm", form, sizeof form, &st),
            &st, "form");
}

static int count_forms(int count)
{
    struct store_job in;
    int stored = 0;
    store_job_init(&in, 0, 1, 1);
    for (int view = 0; view < count; view++)
        stored += has_form(in.id, view);
    return stored;
}

enum { FULL_MIB = 32, FORMS = 4 }; /* an eighth of it; another eighth is where retention begins */

/* With jobs of a MiB each that retention leaves alone, and with forms on top. */
static void open_full_bed(int jobs)
{
    open_bed(&(struct pen_retention){.keep_bytes = (int64_t)FULL_MIB << 20});
    for (int n = 0; n < jobs; n++)
        add_job(n, 1 << 20);
    put_forms(FORMS);
}

START_TEST(test_retention__no_job_is_removed_for_forms)
{
    enum { JOBS = 26 };
    open_full_bed(JOBS);
    ck_assert_int_eq(count_forms(FORMS), FORMS);
    time_ms += hour_ms;
    evict_forms();
    ck_assert_int_eq(keep_house(), 0);
    ck_assert(is_kept(0));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_retention__forms_give_way_to_jobs_within_their_minute)
{
    enum { JOBS = 29, MORE = 2 };
    open_full_bed(JOBS);
    const int before = count_forms(FORMS);
    ck_assert_int_gt(before, 0);
    ck_assert_int_lt(before, FORMS); /* what does not fit is not stored */
    for (int n = JOBS; n < JOBS + MORE; n++) {
        add_job(n, 1 << 20);
        evict_forms();
        ck_assert_int_eq(keep_house(), 0);
    }
    ck_assert_int_lt(count_forms(FORMS), before);
    ck_assert(is_kept(0));
    store_bed_close(&bed);
}
END_TEST

/* Each takes the place of another, and is stored only when that is gone. */
START_TEST(test_retention__forms_that_are_removed_count_until_they_are_gone)
{
    enum { MIB = 1 << 20, TRIES = 10, MOST = 16 * MIB, LOG = 10 * MIB };
    static char form[4 * MIB];
    struct store_job in;
    struct pen_status st;
    open_bed(&(struct pen_retention){.keep_bytes = 8 * MOST});
    add_job(0, 0);
    store_job_init(&in, 0, 1, 1);
    for (int view = 0; view < TRIES; view++)
        store_must(
            pen_store_cache_put(bed.store, in.id, view, "beauty", "pfm", form, sizeof form, &st),
            &st, "form");
    ck_assert_int_le(bytes_on_disk(), MOST + LOG);
    store_purge_slices(bed.store);
    store_must(
        pen_store_cache_put(bed.store, in.id, TRIES, "beauty", "pfm", form, sizeof form, &st), &st,
        "form");
    ck_assert(has_form(in.id, TRIES));
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("what a store keeps", test_retention__without_limits_nothing_is_removed,
          test_retention__by_age_counts_from_the_end_of_a_job,
          test_retention__by_number_keeps_those_that_ended_last,
          test_retention__a_week_of_load_stays_within_the_bytes,
          test_retention__a_queue_of_large_results_stays_within_the_bytes,
          test_retention__job_that_alone_takes_more_than_the_bytes_is_too_large,
          test_retention__intake_is_refused_at_the_limit_and_returns_by_itself,
          test_retention__states_are_kept_within_the_bytes,
          test_retention__states_kept_at_once_are_within_the_bytes_together,
          test_retention__statistics_are_within_the_bytes_too,
          test_retention__old_statistics_go_before_fresh_results,
          test_retention__nothing_goes_for_nothing,
          test_retention__by_age_waits_a_day_after_the_clock_has_jumped_ahead,
          test_retention__by_age_waits_no_longer_if_the_clock_is_set_back,
          test_retention__jobs_of_a_clock_that_was_ahead_count_from_when_it_was_set_back,
          test_retention__jobs_of_a_clock_that_was_ahead_go_before_later_ones,
          test_retention__jobs_that_share_a_document_do_not_go_for_nothing,
          test_retention__waits_a_minute_for_values_that_are_being_written,
          test_retention__cached_forms_are_bounded_and_the_least_used_go,
          test_retention__no_job_is_removed_for_forms,
          test_retention__forms_give_way_to_jobs_within_their_minute,
          test_retention__forms_that_are_removed_count_until_they_are_gone)

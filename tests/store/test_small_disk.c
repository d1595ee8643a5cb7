/* SPDX-License-Identifier: MIT */
/* A disk of 8 MiB whose space ends. While readers keep the write-ahead log from being copied, jobs
 * can be removed, and with that the store takes new ones again. A result that is too large for what
 * is free waits, and others go on. Takes root's rights; without them nothing is tested. */
#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "support/small_disk.h"
#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

enum { DISK_MIB = 8, PICTURE_BYTES = 64000 };

static struct store_bed bed;

static int64_t time_ms;

static bool open_small_disk(int mib)
{
    struct pen_status st;
    store_bed_make(&bed);
    if (!small_disk_mount(bed.folder, mib))
        return false;
    store_bed_open(&bed);
    store_must(pen_store_reserve(bed.store, &st), &st, "reserve");
    return true;
}

static void close_small_disk(void)
{
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
    small_disk_unmount(bed.folder);
}

static int64_t file_bytes(const char *ending)
{
    struct stat info;
    char path[128];
    snprintf(path, sizeof path, "%s%s", bed.url, ending);
    ck_assert_int_eq(stat(path, &info), 0);
    return info.st_size;
}

static int64_t log_bytes(void)
{
    return file_bytes("-wal");
}

static bool submit(int n, struct pen_status *st)
{
    struct store_job in;
    enum pen_submit_result result;
    store_job_init(&in, n, 1, 1);
    return pen_store_submit(bed.store, &in.job, &result, NULL, st);
}

static bool put_picture(const struct pen_claim *claim, int name, struct pen_status *st)
{
    static char picture[PICTURE_BYTES];
    char layer[16];
    snprintf(layer, sizeof layer, "layer-%d", name);
    memset(picture, name + 1, sizeof picture);
    return pen_store_artefact_put(bed.store, claim, layer, "pfm", picture, sizeof picture, st);
}

static void remove_jobs(int count)
{
    struct pen_status st;
    struct store_job in;
    for (int n = 0; n < count; n++) {
        store_job_init(&in, n, 1, 1);
        store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
        store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    }
}

static void pause_ms(int ms)
{
    const struct timespec pause = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    nanosleep(&pause, NULL);
}

static sqlite3 *begin_read(void)
{
    sqlite3 *db;
    ck_assert_int_eq(sqlite3_open(bed.url, &db), SQLITE_OK);
    ck_assert_int_eq(sqlite3_busy_timeout(db, 5000), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(db, "BEGIN; SELECT count(*) FROM job", NULL, NULL, NULL),
                     SQLITE_OK);
    return db;
}

static void end_read(sqlite3 *db)
{
    ck_assert_int_eq(sqlite3_exec(db, "COMMIT", NULL, NULL, NULL), SQLITE_OK);
    ck_assert_int_eq(sqlite3_close(db), SQLITE_OK);
}

/* The store takes jobs again by itself, soon: it tries to recover again within a minute, however
 * long its last try took. */
static void submit_in_time(int n)
{
    enum { RECOVERY_MS = 1000 * SUITE_HANG_S, STEP_MS = 50 };
    struct pen_status st;
    int waited_ms = 0;
    for (; !submit(n, &st) && waited_ms < RECOVERY_MS; waited_ms += STEP_MS)
        pause_ms(STEP_MS);
    ck_assert_int_lt(waited_ms, RECOVERY_MS);
}

/* Nothing that is written meanwhile can be copied from the log. What is left of the disk must be
 * enough to copy it afterwards. */
static void write_beside_reader(bool removes)
{
    enum { TRIES = 2000 };
    struct pen_status st = {0};
    int jobs = 0, pictures = 0;
    if (!open_small_disk(DISK_MIB))
        return;
    store_must(submit(jobs++, &st), &st, "submit");
    const struct pen_claim claim = store_claim(bed.store, "w");
    sqlite3 *reader = begin_read();
    while (pictures < TRIES && put_picture(&claim, pictures, &st))
        pictures++;
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert(!submit(jobs, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    printf("# %d pictures, log of %lld bytes\n", pictures, (long long)log_bytes());
    ck_assert_int_gt(pictures, DISK_MIB * (1 << 20) / PICTURE_BYTES / 4);
    end_read(reader);
    if (removes) {
        remove_jobs(jobs);
        store_purge_slices(bed.store);
    }
    submit_in_time(jobs);
    close_small_disk();
}

START_TEST(test_small_disk__long_reader_leaves_space_to_copy_the_log)
{
    write_beside_reader(false);
}
END_TEST

START_TEST(test_small_disk__long_reader_leaves_space_to_remove_jobs)
{
    write_beside_reader(true);
}
END_TEST

enum { READERS = 2 };

static atomic_bool end; /* sequentially consistent; tells the readers to end */

static struct reader {
    pthread_t thread;
    _Atomic int64_t begun_ns, longest_ns; /* sequentially consistent: its read, and the longest */
} readers[READERS];

/* Reads again and again; of two such threads one always has a state of the store that is older
 * than the last commit. */
static void *read_on(void *user)
{
    enum { READ_MS = 30 };
    struct reader *reader = user;
    while (!end) {
        sqlite3 *db = begin_read();
        pause_ms(READ_MS);
        end_read(db);
        const int64_t now_ns = pen_clock_ns(), took_ns = now_ns - reader->begun_ns;
        if (took_ns > reader->longest_ns)
            reader->longest_ns = took_ns;
        reader->begun_ns = now_ns;
    }
    return NULL;
}

/* Whether the machine has ever kept a reader inside a read for longer than commits wait for one.
 * Then the log may be long, and the disk full for a while. */
static bool was_held_up(void)
{
    enum { HELD_UP_MS = 300 };
    int64_t longest_ns = 0;
    for (int i = 0; i < READERS; i++) {
        const int64_t now_ns = pen_clock_ns() - readers[i].begun_ns,
                      before_ns = readers[i].longest_ns;
        longest_ns = now_ns > longest_ns ? now_ns : longest_ns;
        longest_ns = before_ns > longest_ns ? before_ns : longest_ns;
    }
    return longest_ns > HELD_UP_MS * INT64_C(1000000);
}

/* Whether a call that has failed is to be repeated, since it found the disk full and a reader was
 * held up. Waits until then. */
static bool once_more(int *tries, const struct pen_status *st)
{
    enum { STEP_MS = 50, TRIES = 1000 * SUITE_HANG_S / STEP_MS };
    if (st->code != PEN_STORAGE_FULL || !was_held_up() || ++*tries > TRIES)
        return false;
    pause_ms(STEP_MS);
    return true;
}

static void put_in_time(const struct pen_claim *claim)
{
    struct pen_status st;
    int tries = 0;
    bool put = put_picture(claim, 0, &st);
    while (!put && once_more(&tries, &st))
        put = put_picture(claim, 0, &st);
    store_must(put, &st, "put");
}

/* On a full disk, which is filled again meanwhile: others take what becomes free. */
static void remove_in_time(int n)
{
    struct pen_status st;
    struct store_job in;
    int tries = 0;
    store_job_init(&in, n, 1, 1);
    small_disk_fill(bed.folder, 0);
    bool cancelled = pen_store_cancel(bed.store, in.id, NULL, &st);
    while (!cancelled && once_more(&tries, &st))
        cancelled = pen_store_cancel(bed.store, in.id, NULL, &st);
    store_must(cancelled, &st, "cancel");
    small_disk_fill(bed.folder, 0);
    bool deleted = pen_store_delete(bed.store, in.id, NULL, NULL, &st);
    while (!deleted && once_more(&tries, &st))
        deleted = pen_store_delete(bed.store, in.id, NULL, NULL, &st);
    store_must(deleted, &st, "delete");
}

START_TEST(test_small_disk__overlapping_readers_let_jobs_be_removed)
{
    enum { JOBS = 20, PICTURES = 300, LOG_BYTES_MAX = 2 << 20 };
    struct pen_status st;
    struct pen_claim claims[JOBS];
    if (!open_small_disk(DISK_MIB))
        return;
    for (int n = 0; n < JOBS; n++) {
        store_must(submit(n, &st), &st, "submit");
        claims[n] = store_claim(bed.store, "w");
    }
    for (int i = 0; i < READERS; i++) {
        readers[i].begun_ns = pen_clock_ns();
        ck_assert_int_eq(pthread_create(&readers[i].thread, NULL, read_on, &readers[i]), 0);
        pause_ms(15);
    }
    for (int i = 0; i < PICTURES; i++) /* the same few, so that only the log grows */
        put_in_time(&claims[i % JOBS]);
    printf("# log of %lld bytes\n", (long long)log_bytes());
    ck_assert(log_bytes() < LOG_BYTES_MAX || was_held_up());
    for (int n = 0; n < JOBS; n++)
        remove_in_time(n);
    end = true;
    for (int i = 0; i < READERS; i++)
        pthread_join(readers[i].thread, NULL);
    close_small_disk();
}
END_TEST

static int64_t own_bytes(void)
{
    return file_bytes("") + file_bytes("-wal") + file_bytes("-reserve");
}

/* Others take what becomes free meanwhile. */
static void remove_job_of_full_disk(int n)
{
    struct pen_status st;
    struct store_job in;
    store_job_init(&in, n, 1, 1);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    small_disk_fill(bed.folder, 0);
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    small_disk_fill(bed.folder, 0);
}

static void remove_jobs_of_full_disk(int count)
{
    for (int n = 0; n < count; n++)
        remove_job_of_full_disk(n);
}

/* Others take what becomes free, so nothing of the reserve may become free: what is cut from it is
 * added to the store's own files. Jobs are removed until so much of the reserve was used. */
static void remove_until_used(bool has_reader, int64_t used_bytes)
{
    enum { JOBS = 200, LOST_BYTES_MAX = 4 * 4096 };
    struct pen_status st;
    if (!open_small_disk(DISK_MIB))
        return;
    for (int n = 0; n < JOBS; n++)
        store_must(submit(n, &st), &st, "submit");
    sqlite3 *reader = has_reader ? begin_read() : NULL;
    small_disk_fill(bed.folder, 0);
    const int64_t reserve = file_bytes("-reserve"), own = own_bytes();
    for (int n = 0; n < JOBS && file_bytes("-reserve") > reserve - used_bytes; n++)
        remove_job_of_full_disk(n);
    printf("# reserve of %lld bytes, then %lld; with file and log %lld, then %lld\n",
           (long long)reserve, (long long)file_bytes("-reserve"), (long long)own,
           (long long)own_bytes());
    ck_assert_int_le(file_bytes("-reserve"), reserve - used_bytes);
    ck_assert_int_ge(own_bytes(), own - LOST_BYTES_MAX);
    if (reader)
        end_read(reader);
    close_small_disk();
}

START_TEST(test_small_disk__others_get_nothing_of_the_reserve_for_the_file)
{
    remove_until_used(false, 5 * 4096);
}
END_TEST

START_TEST(test_small_disk__others_get_nothing_of_the_reserve_for_the_log)
{
    remove_until_used(true, 100 << 10);
}
END_TEST

/* The first part of the log's index is for so many pages of the log. */
enum { PART_BYTES = 32768, PART_PAGES = 4062, LOG_FRAME_BYTES = 4096 + 24 };

/* Writes until the log needs the second part soon. */
static void write_part(const struct pen_claim *claim)
{
    enum { BYTES = (PART_PAGES - 10) * LOG_FRAME_BYTES };
    static char picture[1 << 20];
    struct pen_status st;
    int fill = 0;
    for (int64_t lacks; (lacks = BYTES - log_bytes()) > 0; fill++) {
        const size_t bytes = (size_t)lacks < sizeof picture ? (size_t)lacks : sizeof picture;
        memset(picture, fill, sizeof picture); /* what is as before is not written */
        store_must(pen_store_artefact_put(bed.store, claim, "beauty", "pfm", picture, bytes, &st),
                   &st, "put");
    }
    ck_assert_int_le(log_bytes(), PART_PAGES * LOG_FRAME_BYTES);
}

/* It is made longer before the disk is full. */
START_TEST(test_small_disk__index_of_the_log_is_ahead)
{
    enum { MIB = 128, JOBS = 4 };
    struct pen_status st;
    if (!open_small_disk(MIB))
        return;
    for (int n = 0; n < JOBS; n++)
        store_must(submit(n, &st), &st, "submit");
    const struct pen_claim claim = store_claim(bed.store, "w");
    sqlite3 *reader = begin_read();
    write_part(&claim);
    ck_assert_int_eq(file_bytes("-shm"), 2 * PART_BYTES);
    small_disk_fill(bed.folder, 0);
    remove_jobs_of_full_disk(JOBS);
    ck_assert_int_gt(log_bytes(), PART_PAGES * LOG_FRAME_BYTES);
    ck_assert_int_eq(file_bytes("-shm"), 2 * PART_BYTES);
    end_read(reader);
    close_small_disk();
}
END_TEST

/* As after a crash: nobody has the store open, whose log is long, and was copied. */
static void leave_long_log(int jobs)
{
    struct pen_status st;
    char index[128];
    for (int n = 0; n < jobs; n++)
        store_must(submit(n, &st), &st, "submit");
    const struct pen_claim claim = store_claim(bed.store, "w");
    sqlite3 *db = begin_read();
    write_part(&claim);
    ck_assert_int_eq(sqlite3_exec(db, "COMMIT; PRAGMA wal_checkpoint", NULL, NULL, NULL),
                     SQLITE_OK);
    ck_assert_int_eq(sqlite3_db_config(db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL), SQLITE_OK);
    pen_store_close(bed.store);
    ck_assert_int_eq(sqlite3_close(db), SQLITE_OK);
    snprintf(index, sizeof index, "%s-shm", bed.url);
    ck_assert_int_eq(unlink(index), 0);
}

/* The first handle makes the index anew, at first only as long as the log needs it. For both the
 * reserve has the space, of which others get a part in between. */
START_TEST(test_small_disk__jobs_are_removed_after_a_start_on_a_full_disk)
{
    enum { MIB = 128, JOBS = 4 };
    if (!open_small_disk(MIB))
        return;
    leave_long_log(JOBS);
    const int64_t reserve = file_bytes("-reserve");
    small_disk_fill(bed.folder, 0);
    bed.store = store_bed_handle(&bed);
    small_disk_fill(bed.folder, 0);
    remove_jobs_of_full_disk(JOBS);
    ck_assert_int_eq(file_bytes("-shm"), 2 * PART_BYTES);
    ck_assert_int_ge(file_bytes("-reserve"), reserve - 3 * PART_BYTES);
    close_small_disk();
}
END_TEST

/* Commits a job of one batch with a large picture. */
static bool commit_large(const struct pen_claim *claim, struct pen_status *st)
{
    enum { LARGE_BYTES = 2 << 20 };
    static char picture[LARGE_BYTES];
    static float rgb[STORE_JOB_TILE * STORE_JOB_TILE * 3];
    const struct pen_result result = {.rgb = rgb,
                                      .pixels = claim->pixels,
                                      .stats = "{}",
                                      .layer = "beauty",
                                      .format = "png",
                                      .artefact = picture,
                                      .artefact_bytes = LARGE_BYTES};
    return pen_store_commit(bed.store, claim, &result, st);
}

START_TEST(test_small_disk__large_result_waits_for_space_and_small_ones_go_on)
{
    enum { FREE_BYTES = 2 << 20 }; /* less than twice the picture */
    struct pen_status st;
    struct store_job in;
    bool set_back = true;
    if (!open_small_disk(DISK_MIB))
        return;
    time_ms = INT64_C(1800000000000);
    store_bed_set_clock(&bed, &time_ms);
    store_must(submit(0, &st), &st, "submit");
    struct pen_claim claim = store_claim(bed.store, "w");
    small_disk_fill(bed.folder, FREE_BYTES);
    store_must(submit(1, &st), &st, "submit");
    ck_assert(!commit_large(&claim, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    ck_assert(pen_store_lacks_space(bed.store));
    for (int i = 0; i < 2; i++) { /* nobody is told that jobs are taken */
        ck_assert(!pen_store_intake(bed.store, &st));
        ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
        ck_assert(!submit(2, &st));
        ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
        pause_ms(600); /* the next call tries to recover the store */
    }
    store_must(pen_store_set_back(bed.store, &claim, "{}", false, &set_back, &st), &st, "set back");
    ck_assert(set_back);
    claim = store_claim(bed.store, "w");
    store_job_init(&in, 1, 1, 1);
    ck_assert_str_eq(claim.job_id, in.id);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert(!submit(2, &st));
    small_disk_free(bed.folder);
    submit_in_time(2);
    for (int i = 0; i < 2; i++) {
        claim = store_claim(bed.store, "w");
        store_must(commit_large(&claim, &st), &st, "commit");
    }
    close_small_disk();
}
END_TEST

/* A job that is cancelled wants no space any more. */
START_TEST(test_small_disk__job_that_is_cancelled_waits_for_no_space)
{
    enum { FREE_BYTES = 2 << 20 };
    struct pen_status st;
    if (!open_small_disk(DISK_MIB))
        return;
    store_must(submit(0, &st), &st, "submit");
    struct pen_claim claim = store_claim(bed.store, "w");
    small_disk_fill(bed.folder, FREE_BYTES);
    ck_assert(!commit_large(&claim, &st));
    ck_assert(!submit(1, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    store_must(pen_store_cancel(bed.store, claim.job_id, NULL, &st), &st, "cancel");
    ck_assert(!commit_large(&claim, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    submit_in_time(1);
    close_small_disk();
}
END_TEST

static int count_free_bytes(void)
{
    return store_number(bed.url, "PRAGMA freelist_count") * 4096;
}

static int count_objects(void)
{
    return store_number(bed.url, "SELECT count(*) FROM large_object");
}

/* The disk fills up, and its log was just begun anew, while a job is removed or when only its space
 * is left to be returned. */
static void fill_during_removal(bool all_removed)
{
    enum { MIB = 40, VIEWS = 6, BYTES = 3 << 20, EARLY_BYTES = 8 << 20, TRIES = 400, STEP_MS = 50 };
    static char picture[BYTES];
    struct store_job in;
    struct pen_status st = {0};
    bool more = true;
    int tries = 0;
    if (!open_small_disk(MIB))
        return;
    store_must(submit(0, &st), &st, "submit");
    store_work_off(bed.store, "w");
    store_job_init(&in, 0, 1, 1);
    for (int view = 0; view < VIEWS; view++)
        store_put(bed.store,
                  &(struct store_artefact){in.id, view, "beauty", "pfm", picture, BYTES});
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    do
        store_must(pen_store_purge_slice(bed.store, &more, &st), &st, "slice");
    while (all_removed ? count_objects() > 0 : count_free_bytes() <= EARLY_BYTES);
    ck_assert_int_gt(count_free_bytes(), 1 << 20);
    pen_store_close(bed.store);
    bed.store = store_bed_handle(&bed);
    small_disk_fill(bed.folder, 0);
    while ((count_objects() > 0 || count_free_bytes() > 0) && tries++ < TRIES) {
        if (!pen_store_purge_slice(bed.store, &more, &st)) {
            ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
            pause_ms(STEP_MS);
        }
    }
    ck_assert_int_lt(tries, TRIES);
    submit_in_time(1);
    close_small_disk();
}

/* Space is returned before more is removed. If it cannot be, the reserve is there for what is
 * removed. */
START_TEST(test_small_disk__job_is_removed_from_a_full_disk)
{
    fill_during_removal(false);
}
END_TEST

START_TEST(test_small_disk__space_is_returned_to_a_full_disk)
{
    fill_during_removal(true);
}
END_TEST

enum { FORM_BYTES = 2 << 20, FORM_DISK_MIB = 64, INTAKE_BYTES = (FORM_DISK_MIB << 20) / 32 };

static void put_form(int view)
{
    static char form[FORM_BYTES];
    struct pen_status st;
    struct store_job in;
    store_job_init(&in, 0, 1, 1);
    store_must(pen_store_cache_put(bed.store, in.id, view, "beauty", "pfm", form, sizeof form, &st),
               &st, "form");
}

static bool has_form(int view)
{
    struct pen_buf out = {0};
    struct pen_status st;
    struct store_job in;
    store_job_init(&in, 0, 1, 1);
    const bool has = pen_store_artefact(bed.store, in.id, view, "beauty", "pfm", &out, &st);
    ck_assert(has || st.code == PEN_NOT_FOUND);
    pen_buf_release(&out);
    return has;
}

/* As the housekeeping does. Returns how many forms were dropped. */
static int evict_forms(void)
{
    struct pen_status st;
    int evicted = 0;
    for (bool more = true; more; evicted += more) {
        store_must(pen_store_evict(bed.store, &more, &st), &st, "evict");
        store_purge_slices(bed.store);
    }
    return evicted;
}

static int64_t disk_free_bytes(void)
{
    struct statvfs info;
    ck_assert_int_eq(statvfs(bed.folder, &info), 0);
    return (int64_t)info.f_bavail * (int64_t)info.f_frsize;
}

START_TEST(test_small_disk__forms_of_pictures_leave_what_intake_needs)
{
    enum { FREE_BYTES = 14 << 20, FORMS = 10, LESS_BYTES = 3 << 20 };
    struct pen_status st;
    int stored = 0;
    if (!open_small_disk(FORM_DISK_MIB))
        return;
    store_must(submit(0, &st), &st, "submit");
    store_work_off(bed.store, "w");
    small_disk_fill(bed.folder, FREE_BYTES);
    for (int view = 0; view < FORMS; view++) {
        put_form(view);
        ck_assert_int_ge(disk_free_bytes(), 2 * INTAKE_BYTES);
        store_must(submit(view + 1, &st), &st, "submit");
    }
    for (int view = 0; view < FORMS; view++)
        stored += has_form(view);
    ck_assert_int_gt(stored, 1);
    /* the oldest give way to others, at the latest when they are gone */
    evict_forms();
    for (int i = 0; i < 2; i++) {
        put_form(FORMS);
        evict_forms();
    }
    ck_assert(has_form(FORMS) && !has_form(0));
    /* when the disk has less, the oldest go, and no more than must */
    small_disk_fill(bed.folder, LESS_BYTES);
    ck_assert_int_gt(evict_forms(), 0);
    ck_assert_int_ge(disk_free_bytes(), 2 * INTAKE_BYTES);
    ck_assert(has_form(FORMS));
    close_small_disk();
}
END_TEST

PEN_SUITE("small disk", test_small_disk__long_reader_leaves_space_to_copy_the_log,
          test_small_disk__long_reader_leaves_space_to_remove_jobs,
          test_small_disk__overlapping_readers_let_jobs_be_removed,
          test_small_disk__others_get_nothing_of_the_reserve_for_the_file,
          test_small_disk__others_get_nothing_of_the_reserve_for_the_log,
          test_small_disk__index_of_the_log_is_ahead,
          test_small_disk__jobs_are_removed_after_a_start_on_a_full_disk,
          test_small_disk__large_result_waits_for_space_and_small_ones_go_on,
          test_small_disk__job_that_is_cancelled_waits_for_no_space,
          test_small_disk__job_is_removed_from_a_full_disk,
          test_small_disk__space_is_returned_to_a_full_disk,
          test_small_disk__forms_of_pictures_leave_what_intake_needs)

/* SPDX-License-Identifier: MIT */
/* A disk of 8 MiB whose space ends while readers keep the write-ahead log from being copied: jobs
 * can be removed, and with that the store takes new ones again. The disk is a tmpfs in a mount
 * namespace of the test's own, which takes root's rights; without them nothing is tested. */
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "support/store.h"
#include "support/suite.h"

enum { DISK_MIB = 8, PICTURE_BYTES = 64000, PAGE_BYTES = 4096 };

static struct store_bed bed;

static bool open_small_disk(void)
{
    struct pen_status st;
    char size[32];
    store_bed_make(&bed);
    snprintf(size, sizeof size, "size=%dm", DISK_MIB);
    if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0 ||
        mount("none", bed.folder, "tmpfs", 0, size) != 0) {
        const int error = errno;
        rmdir(bed.folder);
        printf("not tested: a tmpfs cannot be mounted here: %s\n", strerror(error));
        ck_assert(error == EPERM || error == EACCES); /* not root, or only that of a container */
        return false;
    }
    store_bed_open(&bed);
    store_must(pen_store_reserve(bed.store, &st), &st, "reserve");
    return true;
}

static void close_small_disk(void)
{
    store_audit_clean(bed.store);
    pen_store_close(bed.store);
    ck_assert_int_eq(umount(bed.folder), 0);
    ck_assert_int_eq(rmdir(bed.folder), 0);
}

static int64_t log_bytes(void)
{
    struct stat info;
    char path[128];
    snprintf(path, sizeof path, "%s-wal", bed.url);
    ck_assert_int_eq(stat(path, &info), 0);
    return info.st_size;
}

static bool submit(int n, struct pen_status *st)
{
    struct store_job in;
    enum pen_submit_result result;
    store_job_init(&in, n, 1, 1);
    return pen_store_submit(bed.store, &in.job, &result, NULL, st);
}

static bool put_picture(int job, int name, struct pen_status *st)
{
    static char picture[PICTURE_BYTES];
    char layer[16];
    struct store_job in;
    store_job_init(&in, job, 1, 1);
    snprintf(layer, sizeof layer, "layer-%d", name);
    memset(picture, name + 1, sizeof picture);
    return pen_store_artefact_put(bed.store, in.id, 0, layer, "pfm", picture, sizeof picture, st);
}

static void remove_jobs(int count)
{
    struct pen_status st;
    struct store_job in;
    for (int n = 0; n < count; n++) {
        store_job_init(&in, n, 1, 1);
        store_must(pen_store_cancel(bed.store, in.id, &st), &st, "cancel");
        store_must(pen_store_delete(bed.store, in.id, NULL, &st), &st, "delete");
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

/* Nothing that is written meanwhile can be copied from the log. What is left of the disk must be
 * enough to copy it afterwards. */
static void write_beside_reader(bool removes)
{
    enum { TRIES = 2000, RECOVERY_MS = 20000, STEP_MS = 50 };
    struct pen_status st = {0};
    int jobs = 0, pictures = 0;
    if (!open_small_disk())
        return;
    store_must(submit(jobs++, &st), &st, "submit");
    sqlite3 *reader = begin_read();
    while (pictures < TRIES && put_picture(0, pictures, &st))
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
    int waited_ms = 0;
    for (; !submit(jobs, &st) && waited_ms < RECOVERY_MS; waited_ms += STEP_MS)
        pause_ms(STEP_MS);
    ck_assert_int_lt(waited_ms, RECOVERY_MS);
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

static atomic_bool end; /* sequentially consistent; tells the readers to end */

/* Reads again and again; of two such threads one always has a state of the store that is older
 * than the last commit. */
static void *read_on(void *unused)
{
    enum { READ_MS = 30 };
    (void)unused;
    while (!end) {
        sqlite3 *reader = begin_read();
        pause_ms(READ_MS);
        end_read(reader);
    }
    return NULL;
}

static void fill_disk(void)
{
    static char zeros[PAGE_BYTES];
    char path[128];
    snprintf(path, sizeof path, "%s/ballast", bed.folder);
    const int fd = open(path, O_WRONLY | O_CREAT | O_APPEND, 0600);
    ck_assert_int_ge(fd, 0);
    while (write(fd, zeros, sizeof zeros) > 0)
        continue;
    close(fd);
}

START_TEST(test_small_disk__overlapping_readers_let_jobs_be_removed)
{
    enum { JOBS = 20, PICTURES = 300, LOG_BYTES_MAX = 2 << 20 };
    struct pen_status st;
    pthread_t readers[2];
    if (!open_small_disk())
        return;
    for (int n = 0; n < JOBS; n++)
        store_must(submit(n, &st), &st, "submit");
    for (int i = 0; i < 2; i++) {
        ck_assert_int_eq(pthread_create(&readers[i], NULL, read_on, NULL), 0);
        pause_ms(15);
    }
    for (int i = 0; i < PICTURES; i++) /* the same few, so that only the log grows */
        store_must(put_picture(i % JOBS, 0, &st), &st, "put");
    printf("# log of %lld bytes\n", (long long)log_bytes());
    ck_assert_int_lt(log_bytes(), LOG_BYTES_MAX);
    for (int n = 0; n < JOBS; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 1);
        fill_disk(); /* again: others take what becomes free */
        store_must(pen_store_cancel(bed.store, in.id, &st), &st, "cancel");
        fill_disk();
        store_must(pen_store_delete(bed.store, in.id, NULL, &st), &st, "delete");
    }
    end = true;
    for (int i = 0; i < 2; i++)
        pthread_join(readers[i], NULL);
    close_small_disk();
}
END_TEST

PEN_SUITE("small disk", test_small_disk__long_reader_leaves_space_to_copy_the_log,
          test_small_disk__long_reader_leaves_space_to_remove_jobs,
          test_small_disk__overlapping_readers_let_jobs_be_removed)

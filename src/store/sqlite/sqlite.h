/* SPDX-License-Identifier: MIT */
/* Inside the SQLite driver: the handle, its statements, and the list of its operations.
 *
 * Invariants
 *  - A write transaction takes the write lock before it reads (BEGIN IMMEDIATE), so what it has
 *    read does not change before it writes.
 *  - A statement is prepared once per handle and always reset before its function returns, so
 *    that no forgotten read keeps the write-ahead log from being reset.
 *  - SQL is in schema.c, sql.c and audit.c; open.c, check.c and backup.c have a few lines. */
#ifndef PEN_STORE_SQLITE_SQLITE_H
#define PEN_STORE_SQLITE_SQLITE_H

#include <sqlite3.h>
#include <sys/stat.h>

#include "store/internal/compress.h"
#include "store/internal/driver.h"

enum { PEN_SQLITE_PAGE_BYTES = 4096 };

/* What the results of a row j of job are expected to take, in bytes: of each pixel of its views its
 * colour, as stored and in the picture (measured: 2 to 8), and of each further layer three floats.
 */
#define PEN_SQLITE_EXPECTED_BYTES                                                                  \
    "(SELECT coalesce(sum(v.width * v.height), 0) FROM view v WHERE v.job = j.number)"             \
    " * (10 + 12 * max(0, coalesce(json_array_length(j.request, '$.layers'), 1) - 1))"

/* What the statistics of a removed job take, with their row. */
#define PEN_SQLITE_STATS_BYTES "iif(stats IS NULL, 0, length(CAST(stats AS BLOB)) + 512)"

/* The statements; their texts are in sql.c, in this order. */
enum pen_sqlite_sql {
    SQL_BEGIN_READ,
    SQL_BEGIN_WRITE,
    SQL_COMMIT,
    SQL_ROLLBACK,
    SQL_META_GET,
    SQL_META_PUT,
    SQL_PROBE,
    SQL_KEY_ADD,
    SQL_KEY_GET,
    SQL_KEYS_REMOVE,
    SQL_SCENE_FIND,
    SQL_SCENE_ADD,
    SQL_SCENE_OF_JOB,
    SQL_SCENE_REMOVE_UNUSED,
    SQL_SCENES_REMOVE_UNUSED,
    SQL_JOB_ADD,
    SQL_VIEW_ADD,
    SQL_BATCH_ADD,
    SQL_JOB_GET,
    SQL_JOB_LIST,
    SQL_JOB_LIST_STATE,
    SQL_JOB_LIST_KIND,
    SQL_JOB_LIST_NAME,
    SQL_JOB_LIST_LABEL,
    SQL_JOB_ATTRIBUTES,
    SQL_JOB_FIND,
    SQL_JOB_IS_OF,
    SQL_JOB_COUNTS,
    SQL_BATCH_COUNTS,
    SQL_OLDEST_QUEUED,
    SQL_JOB_START,
    SQL_JOB_ELAPSE,
    SQL_JOB_PROGRESS,
    SQL_BATCH_WORK,
    SQL_JOB_COST_MAP,
    SQL_JOB_VIEW_ENDED,
    SQL_JOB_SUCCEED,
    SQL_JOB_END,
    SQL_JOB_END_BATCHES,
    SQL_JOB_REMOVE,
    SQL_JOB_MARK_REMOVED,
    SQL_REMOVED_NEXT,
    SQL_ARTEFACTS_OF_JOB,
    SQL_ARTEFACT_REMOVE,
    SQL_BATCHES_OF_JOB,
    SQL_BATCH_REMOVE,
    SQL_FIRST_ENDED,
    SQL_COUNT_ENDED,
    SQL_BYTES_OF_ENDED,
    SQL_BYTES_OF_STATS,
    SQL_REMOVED_ADD,
    SQL_REMOVED_GET,
    SQL_REMOVED_DROP_STATS,
    SQL_REMOVED_PURGE,
    SQL_STATS_COUNT,
    SQL_STATS_DROP,
    SQL_STATS_ENTER,
    SQL_STATS_LEAVE,
    SQL_STATS_PURGE,
    SQL_ANY_OPEN,
    SQL_OPEN_ABOVE,
    SQL_OPEN_AGED,
    SQL_OPEN_BESIDE,
    SQL_OPEN_ELSEWHERE,
    SQL_EXPECTED_COUNT,
    SQL_EXPECTED_DROP,
    SQL_EXPECTED_OF_JOB,
    SQL_EXPECTED_ENTER,
    SQL_EXPECTED_LEAVE,
    SQL_NEXT_PEER,
    SQL_NEXT_OLDEST,
    SQL_NEXT_LEAST,
    SQL_FIRST_OPEN,
    SQL_HELD_BY,
    SQL_FIRST_HELD,
    SQL_BATCH_GET,
    SQL_BATCH_LEASE,
    SQL_BATCH_OPEN,
    SQL_BATCH_REST,
    SQL_BATCH_CUT,
    SQL_VIEW_SPLIT,
    SQL_BATCH_DONE,
    SQL_BATCH_EXTEND,
    SQL_LEVEL_SPEND,
    SQL_PEER_SPEND,
    SQL_JOB_SPEND,
    SQL_BATCH_SPEND,
    SQL_LEASES_OF_JOB,
    SQL_PEER_ADD,
    SQL_LEVEL_ADD,
    SQL_PEER_ENTER,
    SQL_PEER_SERVED,
    SQL_PEER_LEAVE,
    SQL_PEERS_REMOVE,
    SQL_JOB_PEER,
    SQL_QUEUE_LENGTHS,
    SQL_QUEUE,
    SQL_QUEUE_FACTS,
    SQL_NEXT_SCENE,
    SQL_NEXT_PIXELS,
    SQL_NEXT_ARTEFACT,
    SQL_VIEW_BATCH_DONE,
    SQL_TIMES_AHEAD,
    SQL_PEERS_MEND,
    SQL_WORKERS_MEND,
    SQL_LEASES_MEND,
    SQL_ANY_LOST,
    SQL_LOST_JOBS,
    SQL_OPEN_LOST,
    SQL_JOB_SET_DEATHS,
    SQL_JOB_SET_CHARGES,
    SQL_PIXELS_ADD,
    SQL_PIXELS_PAGE,
    SQL_ARTEFACT_PUT,
    SQL_ARTEFACT_FIND,
    SQL_ARTEFACTS_DROP,
    SQL_JOB_ARTEFACTS_DROP,
    SQL_PIXELS_PART,
    SQL_ARTEFACT_PART,
    SQL_OBJECT_ADD,
    SQL_OBJECT_TOUCH,
    SQL_OBJECT_PART_ADD,
    SQL_OBJECT_USE,
    SQL_OBJECT_RELEASE,
    SQL_OBJECT_UNUSED,
    SQL_OBJECT_RELEASED_BYTES,
    SQL_OBJECT_PARTS_REMOVE,
    SQL_OBJECT_REMOVE,
    SQL_CACHED_PUT,
    SQL_CACHED_TOUCH,
    SQL_CACHED_BYTES,
    SQL_CACHED_FIRST,
    SQL_STATS_PAGE,
    SQL_BATCH_PAGE,
    SQL_COMMIT_PAGE,
    SQL_WORKER_PUT,
    SQL_WORKER_LOCK_FILE,
    SQL_WORKER_REMOVE,
    SQL_WORKERS_REMOVE,
    SQL_WORKER_LIST,
    SQL_WORKER_IDS,
    SQL_FREE_PAGES,
    SQL_PAGES,
    SQL_VACUUM,
    SQL_COUNT
};

/* Columns that several statements select, and one function reads. sql.c makes a list of SQL from
 * each of these lists, and the reading function the columns' numbers, JOB_NAME and CLAIM_NAME. */
#define PEN_SQLITE_JOB_COLUMNS(FIRST, NEXT)                                                        \
    FIRST(number)                                                                                  \
    NEXT(id)                                                                                       \
    NEXT(state)                                                                                    \
    NEXT(revision)                                                                                 \
    NEXT(kind)                                                                                     \
    NEXT(request)                                                                                  \
    NEXT(error)                                                                                    \
    NEXT(priority)                                                                                 \
    NEXT(max_attempts)                                                                             \
    NEXT(charges)                                                                                  \
    NEXT(timeout_ms)                                                                               \
    NEXT(created_ms)                                                                               \
    NEXT(started_ms)                                                                               \
    NEXT(finished_ms)                                                                              \
    NEXT(updated_ms)                                                                               \
    NEXT(done_pixels)                                                                              \
    NEXT(total_pixels)                                                                             \
    NEXT(work)                                                                                     \
    NEXT(estimate_ms)                                                                              \
    NEXT(told_us)                                                                                  \
    NEXT(told_elapsed_us)                                                                          \
    NEXT(elapsed_us)                                                                               \
    NEXT(queue_us)                                                                                 \
    NEXT(scene)
#define PEN_SQLITE_CLAIM_COLUMNS(FIRST, NEXT)                                                      \
    FIRST(batch, b.id)                                                                             \
    NEXT(attempt, b.attempt)                                                                       \
    NEXT(kind, b.kind)                                                                             \
    NEXT(job, b.job)                                                                               \
    NEXT(view, b.view)                                                                             \
    NEXT(first_tile, b.first_tile)                                                                 \
    NEXT(tile_count, b.tile_count)                                                                 \
    NEXT(pixels, b.pixels)                                                                         \
    NEXT(view_batches, v.batches)                                                                  \
    NEXT(job_id, j.id)                                                                             \
    NEXT(submitted_ms, j.created_ms)                                                               \
    NEXT(started_ms, j.started_ms)                                                                 \
    NEXT(timeout_ms, j.timeout_ms)                                                                 \
    NEXT(job_spent_us, j.spent_us)                                                                 \
    NEXT(job_work, j.work - b.work)                                                                \
    NEXT(scene_sha256, s.sha256)

struct pen_wake;

/* The longest path of a store's file, its ending included. */
enum { PEN_SQLITE_PATH_BYTES = 4112 };

/* SQLite's files beside the store, which must keep their names while it is in use: the one ending
 * in -wal, and the one ending in -shm, through which processes share what the log has. */
enum { PEN_SQLITE_LOG, PEN_SQLITE_SHM, PEN_SQLITE_BESIDE };
extern const char *const pen_sqlite_beside[PEN_SQLITE_BESIDE]; /* how they end; in meta.c */

struct pen_sqlite_store {
    struct pen_driver base;
    sqlite3 *db;
    char *path;         /* without symbolic links, see pen_sqlite_resolve */
    const char *wanted; /* the identity that the store must have, "": any, and nothing is made;
                           NULL: any, and a missing store may be made */
    char identity[PEN_STORE_IDENTITY_BYTES];
    struct pen_wake *wake;
    int64_t patience_ms; /* how long to wait for locks of other handles */
    bool took_aged;      /* the last claim took what had waited long, see next_open */
    int wal_pages;       /* length of the write-ahead log after the last commit */
    int log_pages;       /* the length from which on commits copy it, see checkpoint.c */
    int uncopied_pages;  /* of the log, which could not be copied the last time */
    int vain_pages;      /* copied when a commit last waited for readers in vain; -1: it did not */
    int64_t index_parts; /* how long the log's index is at least, see index.c */
    struct stat opened;  /* the file when it was first opened, for device and inode */
    bool says_log;       /* the file itself says that it needs its log, as last looked at */
    /* The files beside it when this connection was opened, for device and inode; has_beside: there
     * was such a file. */
    struct stat beside[PEN_SQLITE_BESIDE];
    bool has_beside[PEN_SQLITE_BESIDE];
    bool commits;      /* a transaction is being committed */
    bool sound;        /* opened without a fault, and none met since: closing may write */
    int lock_fd;       /* holds the lock of a worker; -1: none */
    ino_t lock_file;   /* the inode of lock_fd */
    int supervisor_fd; /* of the file itself, for the supervisor's lock; -1: none */
    sqlite3_stmt *stmt[SQL_COUNT];
};

static inline struct pen_sqlite_store *pen_sqlite_of(struct pen_driver *driver)
{
    return (struct pen_sqlite_store *)driver;
}

/* A statement that is being bound and stepped. Errors of binding are kept in rc, and the next step
 * reports them. */
struct pen_sqlite_query {
    struct pen_sqlite_store *store;
    sqlite3_stmt *stmt;
    int bound, rc;
};

/* The text of a statement. */
const char *pen_sqlite_sql_text(enum pen_sqlite_sql sql);

/* Begins a statement, compiled at its first use. Each binding call binds the next parameter. */
struct pen_sqlite_query pen_sqlite_query(struct pen_sqlite_store *store, enum pen_sqlite_sql sql);
void pen_sqlite_int(struct pen_sqlite_query *query, int64_t value);
void pen_sqlite_text(struct pen_sqlite_query *query, const char *text); /* NULL binds SQL's NULL */
void pen_sqlite_blob(struct pen_sqlite_query *query, const void *data, size_t bytes);

/* Steps once. *row: there is a row to read. The step without a row resets the statement; a caller
 * that stops earlier calls pen_sqlite_end. Fails: as pen_sqlite_error. */
bool pen_sqlite_next(struct pen_sqlite_query *query, bool *row, struct pen_status *st);
void pen_sqlite_end(struct pen_sqlite_query *query);

/* The same for loops over rows: returns true if there is a row to read, false after the last row
 * and after a failure; *ok: there was no failure. */
bool pen_sqlite_next_row(struct pen_sqlite_query *query, bool *ok, struct pen_status *st);

/* Runs a statement that gives no rows. */
bool pen_sqlite_run(struct pen_sqlite_query *query, struct pen_status *st);

/* Columns of the current row. pen_sqlite_column_dup returns a malloc()ed copy of a text, NULL for
 * SQL's NULL; *ok becomes false when out of memory. */
int64_t pen_sqlite_column_int(const struct pen_sqlite_query *query, int column);
const char *pen_sqlite_column_text(const struct pen_sqlite_query *query, int column);
struct pen_bytes pen_sqlite_column_blob(const struct pen_sqlite_query *query, int column);
char *pen_sqlite_column_dup(const struct pen_sqlite_query *query, int column, bool *ok);

/* Turns a result code of SQLite into a status, and notes the fault that it stands for:
 * PEN_STORAGE_FULL, PEN_STORAGE (input, output, damage), PEN_UNAVAILABLE (busy), PEN_NO_MEMORY,
 * PEN_TOO_LARGE, else PEN_INTERNAL with SQLite's message. Fails: always. */
bool pen_sqlite_error(struct pen_sqlite_store *store, int rc, struct pen_status *st);

/* The same for a result of a file's methods, with its errno (0: unknown). */
bool pen_sqlite_io_error(struct pen_sqlite_store *store, int rc, int error, struct pen_status *st);

/* A file of the store, with that ending, has lost its name. Fails: always. */
bool pen_sqlite_lost_name(const struct pen_sqlite_store *store, const char *ending,
                          struct pen_status *st);

/* Tells whether a result that means damage comes from a read that the disk refused. SQLite reports
 * such a read as a corrupt file. */
bool pen_sqlite_is_refused_read(struct pen_sqlite_store *store, int rc);

/* Notes damage. The message tells what was found and what to do. Fails: always, PEN_STORAGE. */
bool pen_sqlite_damaged(struct pen_sqlite_store *store, struct pen_status *st, const char *format,
                        ...) __attribute__((format(printf, 3, 4)));

/* Compiles the statements that begin and end transactions, so that a lack of memory leaves none
 * open with the write lock. Called last when opening: a change of the connection or of its triggers
 * invalidates statements, which are then compiled again when they run. */
bool pen_sqlite_prepare(struct pen_sqlite_store *store, struct pen_status *st);

/* Runs SQL text without results, for opening. */
bool pen_sqlite_exec(struct pen_sqlite_store *store, const char *sql, struct pen_status *st);

/* Reads the number that a pragma, given as SQL text, has as its value. */
bool pen_sqlite_pragma(struct pen_sqlite_store *store, const char *sql, int64_t *value,
                       struct pen_status *st);

/* room.c: the size of the reserve, which depends on that of the disk; what is free on the disk;
 * sets the reserve aside, or what is missing of it, if `more` bytes are free beside it. */
int64_t pen_sqlite_reserve_bytes(const struct pen_sqlite_store *store);
int64_t pen_sqlite_free_bytes(const struct pen_sqlite_store *store);
bool pen_sqlite_reserve_allocate(struct pen_sqlite_store *store, int64_t more,
                                 struct pen_status *st);

/* room.c: moves of the reserve to the file what it lacks for the log to be copied, which this does.
 * If it lacks nothing, as where a file system copies what is overwritten, a part of the reserve
 * becomes free. Returns whether there was any. */
bool pen_sqlite_reserve_for_file(struct pen_sqlite_store *store);

/* room.c: makes so much of the reserve free as the log's index lacks. Returns whether it was of
 * use. */
bool pen_sqlite_reserve_for_index(struct pen_sqlite_store *store);

/* index.c: makes the log's index long enough for a transaction, at its beginning. */
bool pen_sqlite_index_keep_ahead(struct pen_sqlite_store *store, struct pen_status *st);

/* index.c: how many bytes the log's index lacks, in whole pages, for a transaction to begin;
 * whether the disk has not so many. */
int64_t pen_sqlite_index_lacks(const struct pen_sqlite_store *store);
bool pen_sqlite_index_is_refused(const struct pen_sqlite_store *store);

/* objects.c: notes that a row has the large object from now on. Fails: PEN_UNAVAILABLE, if it was
 * removed meanwhile. */
bool pen_sqlite_object_use(struct pen_sqlite_store *store, int64_t number, struct pen_status *st);

/* objects.c: reads a range from the large object of row `number`, whose parts the statement reads;
 * *got is how many bytes of it there are, 0 if the row has no large object. */
bool pen_sqlite_object_read(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t number,
                            size_t offset, void *to, size_t bytes, size_t *got,
                            struct pen_status *st);

/* room.c: tells whether the disk has space for a value of so many bytes, before it is written, of
 * which the log has log_bytes at most at a time. Fails: PEN_STORAGE_FULL, and sets the driver's
 * wanted_bytes. */
bool pen_sqlite_blob_fits(struct pen_sqlite_store *store, size_t bytes, size_t log_bytes,
                          struct pen_status *st);

/* checkpoint.c: sets the lengths of the log by the size of the disk, when opening; keeps them,
 * after a commit. */
bool pen_sqlite_limit_log(struct pen_sqlite_store *store, struct pen_status *st);
void pen_sqlite_keep_log_limits(struct pen_sqlite_store *store);

/* checkpoint.c: copies the log into the database and truncates it, if readers finish soon enough.
 */
void pen_sqlite_truncate_log(struct pen_sqlite_store *store);

/* checkpoint.c: tells whether there is space for what could not be copied from the log, in the
 * reserve or else on the disk. */
bool pen_sqlite_log_fits(const struct pen_sqlite_store *store);

/* schema.c: makes the schema in a new file; checks and upgrades a file of an older schema; installs
 * the triggers that refuse illegal changes of state. */
bool pen_sqlite_make_schema(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_migrate(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_guard_states(struct pen_sqlite_store *store, struct pen_status *st);

/* open.c: opens a store of any schema for reading; makes none. Close it with
 * pen_sqlite_close_unwritten. Fails: as pen_store_open, and PEN_NOT_FOUND. */
bool pen_sqlite_open_to_read(struct pen_sqlite_store *store, struct pen_status *st);
void pen_sqlite_close_unwritten(struct pen_sqlite_store *store);

/* files.c: the path without symbolic links; of a file that does not exist, that of its folder and
 * its name. The names of the files beside the store are made from it, as SQLite makes them, so that
 * all programs mean the same files, by whatever links they know the store. Owns: free() it. Fails:
 * NULL with errno. */
char *pen_sqlite_resolve(const char *path);

/* files.c: tells whether both are of one file, and whether the path names the open file. */
bool pen_sqlite_same_file(const struct stat *a, const struct stat *b);
bool pen_sqlite_is_named(int fd, const char *path);

/* files.c: the path of the store's file with this ending, such as "-wal"; tells whether there is
 * such a file, and its length, 0 if there is none. */
void pen_sqlite_path(const struct pen_sqlite_store *store, const char *ending,
                     char path[PEN_SQLITE_PATH_BYTES]);
bool pen_sqlite_file_bytes(const struct pen_sqlite_store *store, const char *ending,
                           int64_t *bytes);

/* files.c: a lock that was waited for in vain is held by another process. Fails: always, with its
 * number. */
bool pen_sqlite_lock_is_held(int fd, const char *path, struct pen_status *st);

/* files.c: renames a file, unless the new name exists (EEXIST); syncs the folder of a path. Fail
 * with errno. */
bool pen_sqlite_name_new_file(const char *from, const char *to);
bool pen_sqlite_sync_folder(const char *path);

/* meta.c: tells whether a new store may be made; whether the files beside the store are its own,
 * before it is opened; enters the store in the -wake file, after it was opened. Fail: PEN_STORAGE,
 * and as any read or write. */
bool pen_sqlite_may_make(const struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_check_company(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_join_company(struct pen_sqlite_store *store, struct pen_status *st);

/* meta.c: gives a copy an identity of its own, and notes that it needs no log. */
bool pen_sqlite_make_independent(sqlite3 *db);

/* meta.c: notes which files are beside the store, for this handle, and the -shm file for those that
 * are opened later; returns the ending of a file that has lost its name since, or NULL. */
void pen_sqlite_note_beside(struct pen_sqlite_store *store);
const char *pen_sqlite_lost_beside(const struct pen_sqlite_store *store);

/* check.c: look for damage in the pages; in the log and the pages. For a store of any schema. */
bool pen_sqlite_check_pages(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_check_file(struct pen_sqlite_store *store, struct pen_status *st);

/* wal.c: looks for damage in the write-ahead log. */
bool pen_sqlite_check_log(struct pen_sqlite_store *store, struct pen_status *st);

/* PRAGMA application_id of a Penumbra store: "Penm". */
enum { SQL_APPLICATION_ID = 0x50656e6d };

/* Every operation of struct pen_driver_ops, once. PEN_SQLITE_DECLARE declares pen_sqlite_NAME for
 * each NAME; the table in ops.c is made from the same list. */
#define PEN_SQLITE_OPS(OP)                                                                         \
    OP(close)                                                                                      \
    OP(reopen)                                                                                     \
    OP(check)                                                                                      \
    OP(check_start)                                                                                \
    OP(probe)                                                                                      \
    OP(space)                                                                                      \
    OP(room)                                                                                       \
    OP(reserve_make)                                                                               \
    OP(reserve_move)                                                                               \
    OP(reserve_is_out)                                                                             \
    OP(meta_get)                                                                                   \
    OP(meta_put)                                                                                   \
    OP(restart_log)                                                                                \
    OP(checkpoint)                                                                                 \
    OP(identity)                                                                                   \
    OP(settle)                                                                                     \
    OP(keep_log_short)                                                                             \
    OP(reclaim)                                                                                    \
    OP(audit)                                                                                      \
    OP(now)                                                                                        \
    OP(wait)                                                                                       \
    OP(wake)                                                                                       \
    OP(health_words)                                                                               \
    OP(tallies)                                                                                    \
    OP(repair_lock)                                                                                \
    OP(repair_unlock)                                                                              \
    OP(begin_read)                                                                                 \
    OP(begin_write)                                                                                \
    OP(commit)                                                                                     \
    OP(rollback)                                                                                   \
    OP(key_add)                                                                                    \
    OP(key_get)                                                                                    \
    OP(scene_find)                                                                                 \
    OP(scene_add)                                                                                  \
    OP(job_add)                                                                                    \
    OP(view_add)                                                                                   \
    OP(batch_add)                                                                                  \
    OP(job_get)                                                                                    \
    OP(job_page)                                                                                   \
    OP(job_find)                                                                                   \
    OP(job_is_of)                                                                                  \
    OP(job_counts)                                                                                 \
    OP(job_start)                                                                                  \
    OP(job_progress)                                                                               \
    OP(job_cost_map)                                                                               \
    OP(job_view_ended)                                                                             \
    OP(job_succeed)                                                                                \
    OP(job_end)                                                                                    \
    OP(job_end_batches)                                                                            \
    OP(job_remove)                                                                                 \
    OP(job_mark_removed)                                                                           \
    OP(job_shrink)                                                                                 \
    OP(removed_next)                                                                               \
    OP(ended_bytes)                                                                                \
    OP(count_ended)                                                                                \
    OP(first_ended)                                                                                \
    OP(removed_add)                                                                                \
    OP(removed_get)                                                                                \
    OP(removed_drop_stats)                                                                         \
    OP(removed_purge)                                                                              \
    OP(stats_count)                                                                                \
    OP(scene_remove_unused)                                                                        \
    OP(keys_remove)                                                                                \
    OP(any_open)                                                                                   \
    OP(next_open)                                                                                  \
    OP(open_elsewhere)                                                                             \
    OP(open_above)                                                                                 \
    OP(held_by)                                                                                    \
    OP(first_held)                                                                                 \
    OP(batch_get)                                                                                  \
    OP(batch_lease)                                                                                \
    OP(batch_open)                                                                                 \
    OP(batch_split)                                                                                \
    OP(batch_done)                                                                                 \
    OP(batch_extend)                                                                               \
    OP(batch_spend)                                                                                \
    OP(job_charge_leases)                                                                          \
    OP(share_served)                                                                               \
    OP(expected_count)                                                                             \
    OP(expected_enter)                                                                             \
    OP(queue_lengths)                                                                              \
    OP(queue)                                                                                      \
    OP(blob_next)                                                                                  \
    OP(peers_remove)                                                                               \
    OP(view_batch_done)                                                                            \
    OP(times_ahead)                                                                                \
    OP(times_mend)                                                                                 \
    OP(any_lost)                                                                                   \
    OP(lost_jobs)                                                                                  \
    OP(open_lost)                                                                                  \
    OP(job_set_deaths)                                                                             \
    OP(job_set_charges)                                                                            \
    OP(blob_write)                                                                                 \
    OP(blob_read)                                                                                  \
    OP(pixels_add)                                                                                 \
    OP(pixels_page)                                                                                \
    OP(artefact_put)                                                                               \
    OP(artefact_find)                                                                              \
    OP(artefacts_drop)                                                                             \
    OP(job_artefacts_drop)                                                                         \
    OP(object_add)                                                                                 \
    OP(object_write)                                                                               \
    OP(object_release)                                                                             \
    OP(object_unused)                                                                              \
    OP(object_released_bytes)                                                                      \
    OP(object_shrink)                                                                              \
    OP(cached_put)                                                                                 \
    OP(cached_touch)                                                                               \
    OP(cached_bytes)                                                                               \
    OP(cached_evict)                                                                               \
    OP(scene_of_job)                                                                               \
    OP(stats_page)                                                                                 \
    OP(batch_page)                                                                                 \
    OP(commit_page)                                                                                \
    OP(worker_put)                                                                                 \
    OP(worker_remove)                                                                              \
    OP(workers_remove)                                                                             \
    OP(worker_list)                                                                                \
    OP(worker_id_page)                                                                             \
    OP(worker_lock)                                                                                \
    OP(worker_lives)                                                                               \
    OP(supervise)
#define PEN_SQLITE_DECLARE(name) __typeof__(*((struct pen_driver_ops *)0)->name) pen_sqlite_##name;
PEN_SQLITE_OPS(PEN_SQLITE_DECLARE)
#undef PEN_SQLITE_DECLARE

/* shares.c: counts a new job into its peer, and out of it when it has ended. */
bool pen_sqlite_share_enter(struct pen_driver *driver, const struct pen_job_new *job,
                            int64_t number, struct pen_status *st);
bool pen_sqlite_share_leave(struct pen_driver *driver, int64_t job, struct pen_status *st);

/* batches.c: finds the first open batch of a job. */
bool pen_sqlite_first_open(struct pen_driver *driver, int64_t job, bool quarantined,
                           struct pen_claim *claim, int64_t *number, bool *found,
                           struct pen_status *st);

/* ops.c: the table of these operations. */
const struct pen_driver_ops *pen_sqlite_ops(void);

/* Runs a statement; *changed: it changed a row. */
bool pen_sqlite_run_changed(struct pen_sqlite_query *query, bool *changed, struct pen_status *st);

/* Runs a statement whose last parameter is the most rows that it changes; *more: it changed so
 * many. */
bool pen_sqlite_run_limited(struct pen_sqlite_query *query, int limit, bool *more,
                            struct pen_status *st);

/* Runs a statement whose only parameter is a number. */
bool pen_sqlite_run_with(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t number,
                         struct pen_status *st);

/* Reads the one number that a query has as its result; 0 if it has no row. */
bool pen_sqlite_value(struct pen_sqlite_query *query, int64_t *value, struct pen_status *st);

/* jobs.c: reads the next row of a query for a job's number, state and scene. */
bool pen_sqlite_next_job_key(struct pen_sqlite_query *query, struct pen_job_key *job, bool *found,
                             struct pen_status *st);

/* Copies a text column to an arena; NULL for SQL's NULL. *ok becomes false when out of memory. */
const char *pen_sqlite_column_keep(const struct pen_sqlite_query *query, int column,
                                   struct pen_arena *arena, bool *ok);

#endif

/* SPDX-License-Identifier: MIT */
/* Inside the SQLite driver: the handle, its statements, and the list of its operations.
 *
 * Invariants
 *  - A write transaction takes the write lock before it reads (BEGIN IMMEDIATE): what was read is
 *    still so when it is changed.
 *  - A statement is prepared once per handle and is always reset before its function returns, so
 *    no forgotten read keeps the write-ahead log from being wound back.
 *  - Only schema.c, sql.c and audit.c contain SQL, and check.c and backup.c a line each. */
#ifndef PEN_STORE_SQLITE_SQLITE_H
#define PEN_STORE_SQLITE_SQLITE_H

#include <sqlite3.h>
#include <sys/stat.h>

#include "store/internal/compress.h"
#include "store/internal/driver.h"

/* The statements; their text is in sql.c, in this order. */
enum pen_sqlite_sql {
    SQL_BEGIN_READ,
    SQL_BEGIN_WRITE,
    SQL_COMMIT,
    SQL_ROLLBACK,
    SQL_PROBE,
    SQL_PROBE_LARGE,
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
    SQL_JOB_FIND,
    SQL_JOB_COUNTS,
    SQL_BATCH_COUNTS,
    SQL_JOB_START,
    SQL_JOB_PROGRESS,
    SQL_JOB_VIEW_ENDED,
    SQL_JOB_SUCCEED,
    SQL_JOB_END,
    SQL_JOB_END_BATCHES,
    SQL_JOB_REMOVE,
    SQL_ANY_OPEN,
    SQL_NEXT_OPEN,
    SQL_HELD_BY,
    SQL_FIRST_HELD,
    SQL_BATCH_GET,
    SQL_BATCH_LEASE,
    SQL_BATCH_OPEN,
    SQL_BATCH_DONE,
    SQL_BATCH_EXTEND,
    SQL_VIEW_BATCH_DONE,
    SQL_ANY_LOST,
    SQL_LOST_JOBS,
    SQL_OPEN_LOST,
    SQL_JOB_SET_DEATHS,
    SQL_JOB_SET_CHARGES,
    SQL_PIXELS_ADD,
    SQL_PIXELS_PAGE,
    SQL_ARTEFACT_PUT,
    SQL_ARTEFACT_FIND,
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
    SQL_VACUUM,
    SQL_COUNT
};

struct pen_wake;

struct pen_sqlite_store {
    struct pen_driver base;
    sqlite3 *db;
    char *path;
    struct pen_wake *wake;
    int64_t patience_ms; /* how long to wait for another's write */
    int wal_pages;       /* length of the write-ahead log after the last commit */
    struct stat opened;  /* the file as first opened: device and inode */
    bool sound;          /* opened without fault, and none since: closing may write */
    int lock_fd;         /* holds the lock of a worker; -1: none */
    ino_t lock_file;     /* the inode of lock_fd */
    sqlite3_stmt *stmt[SQL_COUNT];
};

static inline struct pen_sqlite_store *pen_sqlite_of(struct pen_driver *driver)
{
    return (struct pen_sqlite_store *)driver;
}

/* A statement being bound and stepped. Binding errors are kept and reported by the step. */
struct pen_sqlite_query {
    struct pen_sqlite_store *store;
    sqlite3_stmt *stmt;
    int bound, rc;
};

/* Statement text by number. */
const char *pen_sqlite_sql_text(enum pen_sqlite_sql sql);

struct pen_sqlite_query pen_sqlite_query(struct pen_sqlite_store *store, enum pen_sqlite_sql sql);
void pen_sqlite_int(struct pen_sqlite_query *query, int64_t value);
void pen_sqlite_text(struct pen_sqlite_query *query, const char *text); /* NULL is allowed */
void pen_sqlite_blob(struct pen_sqlite_query *query, const void *data, size_t bytes);

/* Steps once. *row: whether there is a row to look at. The last step, one without a row, resets
 * the statement; leave earlier by pen_sqlite_end. Fails: as pen_sqlite_error. */
bool pen_sqlite_next(struct pen_sqlite_query *query, bool *row, struct pen_status *st);
void pen_sqlite_end(struct pen_sqlite_query *query);

/* Runs a statement that gives no rows. */
bool pen_sqlite_run(struct pen_sqlite_query *query, struct pen_status *st);

/* Rows changed by the last pen_sqlite_run. */
int pen_sqlite_changes(const struct pen_sqlite_store *store);

/* Columns of the current row. pen_sqlite_column_dup gives a malloc()ed copy of a text, NULL for
 * null; *ok becomes false when out of memory. */
int64_t pen_sqlite_column_int(const struct pen_sqlite_query *query, int column);
const char *pen_sqlite_column_text(const struct pen_sqlite_query *query, int column);
struct pen_bytes pen_sqlite_column_blob(const struct pen_sqlite_query *query, int column);
char *pen_sqlite_column_dup(const struct pen_sqlite_query *query, int column, bool *ok);

/* Turns an SQLite result into a status, and takes note of what it says of the store's health:
 * PEN_STORAGE_FULL, PEN_STORAGE (input, output, damage), PEN_UNAVAILABLE (busy), PEN_NO_MEMORY,
 * PEN_TOO_LARGE, else PEN_INTERNAL with SQLite's words. */
bool pen_sqlite_error(struct pen_sqlite_store *store, int rc, struct pen_status *st);

/* The same for a result of a file's own methods, with its errno (0: not known). */
bool pen_sqlite_io_error(struct pen_sqlite_store *store, int rc, int error, struct pen_status *st);

/* Whether what looks like damage is a read that the disk refused: SQLite then takes the file system
 * for corrupt. */
bool pen_sqlite_is_refused_read(struct pen_sqlite_store *store, int rc);

/* Notes damage; the message is what was found and what to do. Fails: always, PEN_STORAGE. */
bool pen_sqlite_damaged(struct pen_sqlite_store *store, struct pen_status *st, const char *format,
                        ...) __attribute__((format(printf, 3, 4)));

/* Prepares what transactions themselves need, so that none is left open, with the lock of all
 * writers, for want of memory. Comes last: whatever changes the connection or its triggers outdates
 * statements, and those are compiled anew when they are run. */
bool pen_sqlite_prepare(struct pen_sqlite_store *store, struct pen_status *st);

/* Runs SQL text without results, for opening. */
bool pen_sqlite_exec(struct pen_sqlite_store *store, const char *sql, struct pen_status *st);

/* Copies the write-ahead log into the database and empties it, if readers leave soon enough. */
void pen_sqlite_wind_back_log(struct pen_sqlite_store *store);

/* schema.c: makes the schema in a new file; upgrades an older one, once it was checked;
 * installs the rules on changes of state. */
bool pen_sqlite_make_schema(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_migrate(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_guard_states(struct pen_sqlite_store *store, struct pen_status *st);

/* open.c. Opens a store that is there, of any schema, to be read alone; close it without
 * writing to it. Fails: as pen_store_open, and PEN_NOT_FOUND. */
bool pen_sqlite_open_to_read(struct pen_sqlite_store *store, struct pen_status *st);
void pen_sqlite_close_unwritten(struct pen_sqlite_store *store);

/* files.c. Gives a file its name, unless that is taken (EEXIST); puts names on the disk. */
bool pen_sqlite_name_new_file(const char *from, const char *to);
bool pen_sqlite_sync_folder(const char *path);

/* check.c: the pages; the whole of the file and of its log, of any schema. */
bool pen_sqlite_check_pages(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_check_file(struct pen_sqlite_store *store, struct pen_status *st);

/* wal.c: whether the write-ahead log is one that SQLite has written, up to its torn end. */
bool pen_sqlite_check_log(struct pen_sqlite_store *store, struct pen_status *st);

/* What marks a file as a Penumbra store: PRAGMA application_id, "Penm". */
enum { SQL_APPLICATION_ID = 0x50656e6d };

/* Every operation of struct pen_driver_ops, once. PEN_SQLITE_DECLARE makes of each NAME the
 * declaration of pen_sqlite_NAME; the table in driver.c is made of the same list. */
#define PEN_SQLITE_OPS(OP)                                                                         \
    OP(close)                                                                                      \
    OP(reopen)                                                                                     \
    OP(check)                                                                                      \
    OP(probe)                                                                                      \
    OP(space)                                                                                      \
    OP(checkpoint)                                                                                 \
    OP(reclaim)                                                                                    \
    OP(audit)                                                                                      \
    OP(now)                                                                                        \
    OP(wait)                                                                                       \
    OP(wake)                                                                                       \
    OP(health_words)                                                                               \
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
    OP(job_counts)                                                                                 \
    OP(job_start)                                                                                  \
    OP(job_progress)                                                                               \
    OP(job_view_ended)                                                                             \
    OP(job_succeed)                                                                                \
    OP(job_end)                                                                                    \
    OP(job_end_batches)                                                                            \
    OP(job_remove)                                                                                 \
    OP(scene_remove_unused)                                                                        \
    OP(keys_remove)                                                                                \
    OP(any_open)                                                                                   \
    OP(next_open)                                                                                  \
    OP(held_by)                                                                                    \
    OP(first_held)                                                                                 \
    OP(batch_get)                                                                                  \
    OP(batch_lease)                                                                                \
    OP(batch_open)                                                                                 \
    OP(batch_done)                                                                                 \
    OP(batch_extend)                                                                               \
    OP(view_batch_done)                                                                            \
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
    OP(worker_lives)
#define PEN_SQLITE_DECLARE(name) __typeof__(*((struct pen_driver_ops *)0)->name) pen_sqlite_##name;
PEN_SQLITE_OPS(PEN_SQLITE_DECLARE)
#undef PEN_SQLITE_DECLARE

/* driver.c: the table of these operations. */
const struct pen_driver_ops *pen_sqlite_ops(void);

/* Reads a row of BATCH_COLUMNS (sql.c) as a claim of its present attempt; *job: its number. */
void pen_sqlite_read_claim(const struct pen_sqlite_query *row, struct pen_claim *claim,
                           int64_t *job);

/* Runs a statement; *changed: whether it changed a row. */
bool pen_sqlite_run_changed(struct pen_sqlite_query *query, bool *changed, struct pen_status *st);

/* A copy of a text column in an arena, NULL for null; *ok becomes false when out of memory. */
const char *pen_sqlite_column_keep(const struct pen_sqlite_query *query, int column,
                                   struct pen_arena *arena, bool *ok);

#endif

/* SPDX-License-Identifier: MIT */
/* Inside the SQLite engine: the handle, its statements, and transactions.
 *
 * Invariants
 *  - Every change is made inside pen_sqlite_transaction, which takes the write lock before it reads
 *    (BEGIN IMMEDIATE): what was read is still so when it is changed.
 *  - A statement is prepared once per handle and is always reset before its function returns, so
 *    no forgotten read keeps the write-ahead log from being wound back.
 *  - Only sqlite_schema.c and sqlite_sql.c contain SQL. */
#ifndef PEN_STORE_SQLITE_SQLITE_H
#define PEN_STORE_SQLITE_SQLITE_H

#include <sqlite3.h>
#include <sys/stat.h>

#include "store/internal/compress.h"
#include "store/internal/ops.h"

/* The statements; their text is in sqlite_sql.c, in this order. */
enum pen_sqlite_sql {
    SQL_BEGIN_READ,
    SQL_BEGIN_WRITE,
    SQL_COMMIT,
    SQL_ROLLBACK,
    SQL_PROBE,
    SQL_PROBE_LARGE,
    SQL_KEY_FIND,
    SQL_KEY_ADD,
    SQL_SCENE_FIND,
    SQL_SCENE_ADD,
    SQL_JOB_ADD,
    SQL_VIEW_ADD,
    SQL_BATCH_ADD,
    SQL_JOB_GET,
    SQL_JOB_LIST,
    SQL_JOB_LIST_STATE,
    SQL_JOB_NUMBER,
    SQL_SCENE_GET,
    SQL_JOB_END,
    SQL_BATCHES_END,
    SQL_JOB_REMOVE,
    SQL_SCENE_REMOVE_UNUSED,
    SQL_OPEN_ANY,
    SQL_OPEN_NEXT,
    SQL_HELD_BY,
    SQL_BATCH_LEASE,
    SQL_JOB_START,
    SQL_BATCH_GET,
    SQL_BATCH_DONE,
    SQL_PIXELS_ADD,
    SQL_VIEW_COUNT_DOWN,
    SQL_VIEW_GET,
    SQL_JOB_PROGRESS,
    SQL_STUDY_PROGRESS,
    SQL_JOB_VIEW_ENDED,
    SQL_BATCH_OPEN,
    SQL_LEASE_EXTEND,
    SQL_LOST_ANY,
    SQL_LOST_JOBS,
    SQL_LOST_OPEN,
    SQL_LEFT_OPEN,
    SQL_CHARGE_WHOM,
    SQL_CHARGE,
    SQL_PIXELS_LIST,
    SQL_STATS_LIST,
    SQL_BATCH_LIST,
    SQL_COMMIT_LIST,
    SQL_ARTEFACT_GET,
    SQL_ARTEFACT_PUT,
    SQL_WORKER_SEEN,
    SQL_WORKER_GONE,
    SQL_WORKER_LIST,
    SQL_TIDY_WORKERS,
    SQL_TIDY_KEYS,
    SQL_TIDY_SCENES,
    SQL_FREE_PAGES,
    SQL_VACUUM,
    SQL_COUNT
};

struct pen_sqlite_store {
    struct pen_store base;
    sqlite3 *db;
    char *path;
    struct pen_compressor *packer;
    struct pen_pixels *pixels; /* of results that come unpacked; NULL before the first */
    float *rgb;                /* unpacked pixels, kept from batch to batch */
    size_t rgb_pixels;         /* what it has room for */
    int64_t patience_ms;       /* how long to wait for another's write */
    int wal_pages;             /* length of the write-ahead log after the last commit */
    struct stat opened;        /* the file as first opened: device and inode */
    bool sound;                /* opened without fault, and none since: closing may write */
    sqlite3_stmt *stmt[SQL_COUNT];
};

static inline struct pen_sqlite_store *pen_sqlite_of(struct pen_store *store)
{
    return (struct pen_sqlite_store *)store;
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

/* Runs `body` in a write transaction: committed if it returns true, else rolled back. */
typedef bool pen_sqlite_body(struct pen_sqlite_store *store, void *arg, struct pen_status *st);
bool pen_sqlite_transaction(struct pen_sqlite_store *store, pen_sqlite_body *body, void *arg,
                            struct pen_status *st);

/* Runs `body` against one unchanging state of the database. */
bool pen_sqlite_snapshot(struct pen_sqlite_store *store, pen_sqlite_body *body, void *arg,
                         struct pen_status *st);

/* Runs SQL text without results, for opening. */
bool pen_sqlite_exec(struct pen_sqlite_store *store, const char *sql, struct pen_status *st);

/* The entry of the ops table. */
bool pen_sqlite_checkpoint(struct pen_store *store, struct pen_status *st);

/* Copies the write-ahead log into the database and empties it, if readers leave soon enough. */
void pen_sqlite_wind_back_log(struct pen_sqlite_store *store);

/* The job's number. Fails: PEN_NOT_FOUND. */
bool pen_sqlite_job_number(struct pen_sqlite_store *store, const char *id, int64_t *number,
                           struct pen_status *st);

/* sqlite_schema.c: makes the schema in a new file; upgrades an older one, once it was checked;
 * installs the rules on changes of state. */
bool pen_sqlite_make_schema(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_migrate(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_guard_states(struct pen_sqlite_store *store, struct pen_status *st);

/* sqlite_open.c. Opens a store that is there, of any schema, to be read alone; close it without
 * writing to it. Fails: as pen_store_open, and PEN_NOT_FOUND. */
bool pen_sqlite_open_to_read(struct pen_sqlite_store *store, struct pen_status *st);
void pen_sqlite_close_unwritten(struct pen_sqlite_store *store);

/* sqlite_files.c. Gives a file its name, unless that is taken (EEXIST); puts names on the disk. */
bool pen_sqlite_name_new_file(const char *from, const char *to);
bool pen_sqlite_sync_folder(const char *path);

/* sqlite_check.c: the pages; the whole of the file and of its log, of any schema; of this one. */
bool pen_sqlite_check_pages(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_check_file(struct pen_sqlite_store *store, struct pen_status *st);
bool pen_sqlite_check(struct pen_store *store, struct pen_status *st);

/* sqlite_wal.c: whether the write-ahead log is one that SQLite has written, up to its torn end. */
bool pen_sqlite_check_log(struct pen_sqlite_store *store, struct pen_status *st);

/* What marks a file as a Penumbra store: PRAGMA application_id, "Penm". */
enum { SQL_APPLICATION_ID = 0x50656e6d };

/* The entries of the ops table, by file. */
bool pen_sqlite_submit(struct pen_store *store, const struct pen_job_new *job,
                       enum pen_submit_result *result, struct pen_buf *first_answer,
                       struct pen_status *st);

bool pen_sqlite_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                    struct pen_status *st);
bool pen_sqlite_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                     struct pen_job_record **jobs, int *count, struct pen_status *st);
bool pen_sqlite_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                      struct pen_status *st);
bool pen_sqlite_cancel(struct pen_store *store, const char *id, struct pen_status *st);
bool pen_sqlite_remove(struct pen_store *store, const char *id, struct pen_status *st);
bool pen_sqlite_purge(struct pen_store *store, int64_t key_age_ms, struct pen_status *st);

bool pen_sqlite_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                      struct pen_claim *claim, bool *found, struct pen_status *st);
bool pen_sqlite_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                         struct pen_status *st);
bool pen_sqlite_release(struct pen_store *store, const struct pen_claim *claim,
                        struct pen_status *st);
bool pen_sqlite_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                     struct pen_status *st);
bool pen_sqlite_heartbeat(struct pen_store *store, const struct pen_claim *claim, int64_t lease_ms,
                          bool *held, struct pen_status *st);

bool pen_sqlite_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                              struct pen_status *st);
bool pen_sqlite_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                             int *opened, struct pen_status *st);

bool pen_sqlite_commit(struct pen_store *store, const struct pen_claim *claim,
                       const struct pen_result *result, struct pen_next *next,
                       struct pen_status *st);

bool pen_sqlite_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                       void *user, struct pen_status *st);
bool pen_sqlite_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                      struct pen_status *st);
bool pen_sqlite_batches(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                        struct pen_status *st);
bool pen_sqlite_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                        void *user, struct pen_status *st);
bool pen_sqlite_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, struct pen_buf *out, struct pen_status *st);
bool pen_sqlite_artefact_put(struct pen_store *store, const char *id, int view, const char *layer,
                             const char *format, const void *data, size_t bytes,
                             struct pen_status *st);

bool pen_sqlite_worker_seen(struct pen_store *store, const char *name, int threads,
                            int64_t lease_ms, struct pen_status *st);
bool pen_sqlite_worker_gone(struct pen_store *store, const char *name, struct pen_status *st);
bool pen_sqlite_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                        struct pen_status *st);

bool pen_sqlite_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                      struct pen_status *st);

/* Ends a job as cancelled or failed, with its open and leased batches; inside a transaction. */
bool pen_sqlite_end_job(struct pen_sqlite_store *store, int64_t number, enum pen_job_state state,
                        const char *error, struct pen_status *st);

/* What a row of BATCH_COLUMNS is as a claim of its present attempt. */
void pen_sqlite_read_claim(const struct pen_sqlite_query *row, struct pen_claim *claim,
                           int64_t *job);

/* Whether a query gives a row at all; reading first spares an idle worker the write. */
bool pen_sqlite_any_row(struct pen_sqlite_query *query, bool *any, struct pen_status *st);

/* Leases the next open batch, inside a transaction. */
bool pen_sqlite_take_next(struct pen_sqlite_store *store, struct pen_next *next,
                          struct pen_status *st);

/* How a batch stands against a claim. */
struct pen_sqlite_standing {
    bool exists, held; /* held: leased under the claim's attempt */
    enum pen_batch_state state;
    int64_t job, attempt, pixels, lease_until_ms;
    int view;
    enum pen_batch_kind kind;
};
bool pen_sqlite_standing(struct pen_sqlite_store *store, const struct pen_claim *claim,
                         struct pen_sqlite_standing *standing, struct pen_status *st);

#endif

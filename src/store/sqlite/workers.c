/* SPDX-License-Identifier: MIT */
/* Rows of workers, and their locks: of the file of the wake-up signals, the byte whose number is
 * that of the worker's id. Open file description locks (fcntl(2), F_OFD_SETLK) belong to the
 * handle's own descriptor: closing another one of the same file keeps them, and the end of the
 * process ends them. They do not collide with the locks of the whole file by flock(2). */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "store/sqlite/sqlite.h"

bool pen_sqlite_worker_put(struct pen_driver *driver, const struct pen_worker_new *worker,
                           int64_t now_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKER_PUT);
    pen_sqlite_text(&query, worker->id);
    pen_sqlite_text(&query, worker->host);
    pen_sqlite_int(&query, worker->pid);
    pen_sqlite_int(&query, worker->threads);
    pen_sqlite_int(&query, worker->lease_ms);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_worker_remove(struct pen_driver *driver, const char *id, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKER_REMOVE);
    pen_sqlite_text(&query, id);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_workers_remove(struct pen_driver *driver, int64_t before_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKERS_REMOVE);
    pen_sqlite_int(&query, before_ms);
    return pen_sqlite_run(&query, st);
}

/* Rows in an arena: a full array is copied into one of twice its length. */
struct rows {
    struct pen_arena *arena;
    struct pen_worker_record *list;
    int count, capacity;
};

static struct pen_worker_record *add_row(struct rows *rows)
{
    if (rows->count == rows->capacity) {
        int capacity = rows->capacity ? 2 * rows->capacity : 16;
        struct pen_worker_record *list =
            pen_arena_alloc(rows->arena, (size_t)capacity, sizeof *list);
        if (!list)
            return NULL;
        if (rows->count)
            memcpy(list, rows->list, (size_t)rows->count * sizeof *list);
        rows->list = list;
        rows->capacity = capacity;
    }
    return &rows->list[rows->count++];
}

static bool fill_worker(const struct pen_sqlite_query *query, struct rows *rows)
{
    struct pen_worker_record *worker = add_row(rows);
    bool ok = worker != NULL;
    if (!ok)
        return false;
    *worker = (struct pen_worker_record){
        .id = pen_sqlite_column_keep(query, 0, rows->arena, &ok),
        .host = pen_sqlite_column_keep(query, 1, rows->arena, &ok),
        .pid = pen_sqlite_column_int(query, 2),
        .threads = (int)pen_sqlite_column_int(query, 3),
        .started_ms = pen_sqlite_column_int(query, 4),
        .seen_ms = pen_sqlite_column_int(query, 5),
        .job_id = pen_sqlite_column_keep(query, 6, rows->arena, &ok),
        .view = pen_sqlite_column_keep(query, 7, rows->arena, &ok),
        .batch = pen_sqlite_column_int(query, 8),
        .attempt = pen_sqlite_column_int(query, 9),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(query, 10),
        .pixels = pen_sqlite_column_int(query, 11),
    };
    return ok;
}

bool pen_sqlite_worker_list(struct pen_driver *driver, struct pen_arena *arena,
                            struct pen_worker_record **rows, int *count, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKER_LIST);
    struct rows found = {.arena = arena};
    bool row = true, kept = true;
    while (row && kept) {
        if (!pen_sqlite_next(&query, &row, st))
            return false;
        kept = !row || fill_worker(&query, &found);
    }
    pen_sqlite_end(&query);
    *rows = found.list;
    *count = found.count;
    return kept || pen_fail(st, PEN_NO_MEMORY, "no memory for a list of workers");
}

bool pen_sqlite_worker_id_page(struct pen_driver *driver, const char *after,
                               struct pen_arena *arena, const char **ids, int capacity, int *count,
                               struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKER_IDS);
    bool row = true, ok = true;
    pen_sqlite_text(&query, after);
    pen_sqlite_int(&query, capacity);
    *count = 0;
    while (row) {
        if (!pen_sqlite_next(&query, &row, st))
            return false;
        if (row)
            ids[(*count)++] = pen_sqlite_column_keep(&query, 0, arena, &ok);
    }
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for a list of workers");
}

/* The byte of an id: its checksum, without the sign and beyond the bytes of the file itself. */
static struct flock lock_of(const char *id)
{
    int64_t at = pen_checksum(id, strlen(id)) & (INT64_MAX >> 1);
    return (struct flock){
        .l_type = F_WRLCK, .l_whence = SEEK_SET, .l_start = (off_t)(at | 1 << 16), .l_len = 1};
}

static int open_lock_file(const struct pen_sqlite_store *store)
{
    char path[4112];
    snprintf(path, sizeof path, "%s-wake", store->path);
    return open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
}

static bool cannot_lock(const struct pen_sqlite_store *store, int error, struct pen_status *st)
{
    return pen_fail(st, PEN_STORAGE, "cannot lock the file %s-wake: %s", store->path,
                    strerror(error));
}

bool pen_sqlite_worker_lock(struct pen_driver *driver, const char *id, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct flock lock = lock_of(id);
    if (store->lock_fd < 0)
        store->lock_fd = open_lock_file(store);
    if (store->lock_fd >= 0 && fcntl(store->lock_fd, F_OFD_SETLK, &lock) == 0)
        return true;
    if (errno == EAGAIN || errno == EACCES)
        return pen_fail(st, PEN_CONFLICT, "there is another worker %s", id);
    return cannot_lock(store, errno, st);
}

/* F_OFD_GETLK does not see the locks of its own descriptor: a new one sees all. */
bool pen_sqlite_worker_lives(struct pen_driver *driver, const char *id, bool *lives,
                             struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct flock lock = lock_of(id);
    int fd = open_lock_file(store);
    bool ok = fd >= 0 && fcntl(fd, F_OFD_GETLK, &lock) == 0;
    int error = errno;
    if (fd >= 0)
        close(fd);
    *lives = ok && lock.l_type != F_UNLCK;
    return ok || cannot_lock(store, error, st);
}

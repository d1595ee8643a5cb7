/* SPDX-License-Identifier: MIT */
/* Rows of workers, and their locks.
 *
 * A worker locks one byte of the file ending in -wake; the checksum of its id says which. The lock
 * is an open file description lock (fcntl(2), F_OFD_SETLK): it belongs to the handle's own
 * descriptor, so closing another descriptor of the file keeps it, and the end of the process ends
 * it. It does not collide with the locks of the whole file by flock(2).
 *
 * The file may be removed or replaced while workers live; their locks then are in a file that
 * nobody else finds. So a worker's row names the inode that it has locked, and a worker counts as
 * dead only if its byte is free in that very file. While the worker lives, its descriptor keeps the
 * inode from being reused, so another file never passes for it. If the file is another one, or
 * missing, the worker counts as living, and its leases expire in their time. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "store/sqlite/sqlite.h"

bool pen_sqlite_worker_put(struct pen_driver *driver, const struct pen_worker_new *worker,
                           int64_t now_ms, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_WORKER_PUT);
    pen_sqlite_text(&query, worker->id);
    pen_sqlite_text(&query, worker->host);
    pen_sqlite_int(&query, worker->pid);
    pen_sqlite_int(&query, worker->threads);
    pen_sqlite_int(&query, worker->lease_ms);
    pen_sqlite_int(&query, now_ms);
    if (store->lock_fd >= 0)
        pen_sqlite_int(&query, (int64_t)store->lock_file);
    else
        pen_sqlite_text(&query, NULL);
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
        .job_kind = pen_sqlite_column_keep(query, 7, rows->arena, &ok),
        .view = pen_sqlite_column_keep(query, 8, rows->arena, &ok),
        .batch = pen_sqlite_column_int(query, 9),
        .attempt = pen_sqlite_column_int(query, 10),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(query, 11),
        .pixels = pen_sqlite_column_int(query, 12),
    };
    return ok;
}

bool pen_sqlite_worker_list(struct pen_driver *driver, struct pen_arena *arena,
                            struct pen_worker_record **rows, int *count, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKER_LIST);
    struct rows found = {.arena = arena};
    bool ok, memory = true;
    while (memory && pen_sqlite_next_row(&query, &ok, st))
        memory = fill_worker(&query, &found);
    pen_sqlite_end(&query);
    *rows = found.list;
    *count = found.count;
    return ok && (memory || pen_fail(st, PEN_NO_MEMORY, "no memory for a list of workers"));
}

bool pen_sqlite_worker_id_page(struct pen_driver *driver, const char *after,
                               struct pen_arena *arena, const char **ids, int capacity, int *count,
                               struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_WORKER_IDS);
    bool ok, memory = true;
    pen_sqlite_text(&query, after);
    pen_sqlite_int(&query, capacity);
    *count = 0;
    while (pen_sqlite_next_row(&query, &ok, st))
        ids[(*count)++] = pen_sqlite_column_keep(&query, 0, arena, &memory);
    return ok && (memory || pen_fail(st, PEN_NO_MEMORY, "no memory for a list of workers"));
}

/* The byte of an id: its checksum, without the sign and beyond the bytes of the file itself. */
static struct flock lock_of(const char *id)
{
    int64_t at = pen_checksum(id, strlen(id)) & (INT64_MAX >> 1);
    return (struct flock){
        .l_type = F_WRLCK, .l_whence = SEEK_SET, .l_start = (off_t)(at | 1 << 16), .l_len = 1};
}

/* Opens the file of the locks; *inode is its number. Returns -1 with errno. */
static int open_lock_file(const struct pen_sqlite_store *store, int flags, ino_t *inode)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    pen_sqlite_path(store, "-wake", path);
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW | flags, 0600);
    if (fd >= 0 && fstat(fd, &info) != 0) {
        int error = errno;
        close(fd);
        errno = error;
        return -1;
    }
    if (fd >= 0)
        *inode = info.st_ino;
    return fd;
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
        store->lock_fd = open_lock_file(store, O_CREAT, &store->lock_file);
    if (store->lock_fd < 0)
        return cannot_lock(store, errno, st);
    if (fcntl(store->lock_fd, F_OFD_SETLK, &lock) == 0)
        return true;
    if (errno == EAGAIN || errno == EACCES)
        return pen_fail(st, PEN_CONFLICT, "there is another worker %s", id);
    return cannot_lock(store, errno, st);
}

/* Tells whether the worker may have locked a byte of another file than this one. A worker whose row
 * names no file, or that has no row, is judged by this file. */
static bool locked_elsewhere(struct pen_sqlite_store *store, const char *id, ino_t file,
                             bool *elsewhere, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_WORKER_LOCK_FILE);
    bool row;
    pen_sqlite_text(&query, id);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    *elsewhere = row && (ino_t)pen_sqlite_column_int(&query, 0) != file;
    if (row)
        pen_sqlite_end(&query);
    if (*elsewhere)
        pen_log(PEN_LOG_WARN,
                "cannot tell whether worker %s lives: the file %s-wake was replaced; its leases "
                "expire in their time",
                id, store->path);
    return true;
}

/* Asks for the lock through a new descriptor, since F_OFD_GETLK does not see the locks of the
 * descriptor that it is called with. */
static bool is_locked(struct pen_sqlite_store *store, int fd, const char *id, bool *locked,
                      struct pen_status *st)
{
    struct flock lock = lock_of(id);
    if (fcntl(fd, F_OFD_GETLK, &lock) != 0)
        return cannot_lock(store, errno, st);
    *locked = lock.l_type != F_UNLCK;
    return true;
}

bool pen_sqlite_worker_lives(struct pen_driver *driver, const char *id, bool *lives,
                             struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    ino_t file;
    int fd = open_lock_file(store, 0, &file);
    *lives = true;
    if (fd < 0)
        return errno == ENOENT || cannot_lock(store, errno, st);
    bool elsewhere, ok = locked_elsewhere(store, id, file, &elsewhere, st);
    if (ok && !elsewhere)
        ok = is_locked(store, fd, id, lives, st);
    close(fd);
    return ok;
}

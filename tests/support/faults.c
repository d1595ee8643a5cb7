/* SPDX-License-Identifier: MIT */
#include "support/faults.h"

#include <check.h>
#include <errno.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/random.h"

enum { FILES_MAX = 16, SECTOR_BYTES = 512 };

/* The contents of a file that are known to be on the disk. */
struct durable {
    char path[256];
    unsigned char *data;
    sqlite3_int64 bytes;
};

struct file {
    sqlite3_file base; /* must be first */
    struct durable *durable;
    bool sync_failed;
    sqlite3_file *real; /* behind this structure */
};

static struct {
    sqlite3_vfs vfs;
    sqlite3_vfs *system;
    struct fault_plan plan;
    bool armed, synced_again, remembers;
    long count, failed;
    int last_errno;
    struct durable file[FILES_MAX];
    int file_count;
} disk;

static bool fails(enum fault_call call)
{
    if (!disk.armed || !(disk.plan.calls & (unsigned)call))
        return false;
    long i = ++disk.count;
    const struct fault_plan *plan = &disk.plan;
    bool now = plan->mode == FAULT_ONCE    ? i == plan->n
               : plan->mode == FAULT_EVERY ? i % plan->n == 0
                                           : i >= plan->n;
    if (now) {
        disk.failed++;
        disk.last_errno = plan->error;
    }
    return now;
}

static struct file *of(sqlite3_file *base)
{
    return (struct file *)base;
}

static const struct sqlite3_io_methods *below(sqlite3_file *base)
{
    return of(base)->real->pMethods;
}

static void remember(struct file *file)
{
    struct durable *durable = file->durable;
    sqlite3_int64 bytes = 0;
    if (!disk.remembers || !durable ||
        file->real->pMethods->xFileSize(file->real, &bytes) != SQLITE_OK)
        return;
    durable->data = realloc(durable->data, (size_t)bytes + 1);
    ck_assert_ptr_nonnull(durable->data);
    durable->bytes = bytes;
    if (bytes > 0)
        ck_assert_int_eq(file->real->pMethods->xRead(file->real, durable->data, (int)bytes, 0),
                         SQLITE_OK);
}

static int file_close(sqlite3_file *base)
{
    return below(base)->xClose(of(base)->real);
}

static int file_read(sqlite3_file *base, void *out, int bytes, sqlite3_int64 at)
{
    if (fails(FAULT_READ)) /* as the system's VFS does */
        return disk.plan.error == EIO ? SQLITE_IOERR_CORRUPTFS : SQLITE_IOERR_READ;
    return below(base)->xRead(of(base)->real, out, bytes, at);
}

static int file_write(sqlite3_file *base, const void *data, int bytes, sqlite3_int64 at)
{
    if (!fails(FAULT_WRITE))
        return below(base)->xWrite(of(base)->real, data, bytes, at);
    if (disk.plan.torn && bytes > 1)
        below(base)->xWrite(of(base)->real, data, bytes / 2, at);
    return disk.plan.error == ENOSPC ? SQLITE_FULL : SQLITE_IOERR_WRITE;
}

static int file_truncate(sqlite3_file *base, sqlite3_int64 bytes)
{
    if (fails(FAULT_TRUNCATE))
        return SQLITE_IOERR_TRUNCATE;
    return below(base)->xTruncate(of(base)->real, bytes);
}

static int file_sync(sqlite3_file *base, int flags)
{
    (void)flags;
    struct file *file = of(base);
    disk.synced_again = disk.synced_again || file->sync_failed;
    if (fails(FAULT_SYNC)) {
        file->sync_failed = true;
        return SQLITE_IOERR_FSYNC;
    }
    remember(file);
    return SQLITE_OK;
}

static int file_size(sqlite3_file *base, sqlite3_int64 *bytes)
{
    return below(base)->xFileSize(of(base)->real, bytes);
}

static int file_lock(sqlite3_file *base, int lock)
{
    return below(base)->xLock(of(base)->real, lock);
}

static int file_unlock(sqlite3_file *base, int lock)
{
    return below(base)->xUnlock(of(base)->real, lock);
}

static int file_check_lock(sqlite3_file *base, int *out)
{
    return below(base)->xCheckReservedLock(of(base)->real, out);
}

static int file_control(sqlite3_file *base, int op, void *arg)
{
    if (op == SQLITE_FCNTL_LAST_ERRNO && disk.last_errno) {
        *(int *)arg = disk.last_errno;
        return SQLITE_OK;
    }
    return below(base)->xFileControl(of(base)->real, op, arg);
}

static int file_sector(sqlite3_file *base)
{
    return below(base)->xSectorSize(of(base)->real);
}

static int file_device(sqlite3_file *base)
{
    return below(base)->xDeviceCharacteristics(of(base)->real);
}

static int file_shm_map(sqlite3_file *base, int page, int bytes, int extend, void volatile **out)
{
    if (fails(FAULT_SHM)) {
        errno = disk.plan.error;
        return SQLITE_IOERR_SHMSIZE;
    }
    return below(base)->xShmMap(of(base)->real, page, bytes, extend, out);
}

static int file_shm_lock(sqlite3_file *base, int offset, int n, int flags)
{
    return below(base)->xShmLock(of(base)->real, offset, n, flags);
}

static void file_shm_barrier(sqlite3_file *base)
{
    below(base)->xShmBarrier(of(base)->real);
}

static int file_shm_unmap(sqlite3_file *base, int remove)
{
    return below(base)->xShmUnmap(of(base)->real, remove);
}

static const sqlite3_io_methods methods = {
    .iVersion = 2,
    .xClose = file_close,
    .xRead = file_read,
    .xWrite = file_write,
    .xTruncate = file_truncate,
    .xSync = file_sync,
    .xFileSize = file_size,
    .xLock = file_lock,
    .xUnlock = file_unlock,
    .xCheckReservedLock = file_check_lock,
    .xFileControl = file_control,
    .xSectorSize = file_sector,
    .xDeviceCharacteristics = file_device,
    .xShmMap = file_shm_map,
    .xShmLock = file_shm_lock,
    .xShmBarrier = file_shm_barrier,
    .xShmUnmap = file_shm_unmap,
};

static struct durable *find_durable(const char *path)
{
    for (int i = 0; i < disk.file_count; i++) {
        if (strcmp(disk.file[i].path, path) == 0)
            return &disk.file[i];
    }
    return NULL;
}

/* A file that is seen for the first time counts as synced. */
static void open_durable(struct file *file, const char *path)
{
    file->durable = path ? find_durable(path) : NULL;
    if (file->durable || !path || disk.file_count == FILES_MAX)
        return;
    file->durable = &disk.file[disk.file_count++];
    *file->durable = (struct durable){0};
    snprintf(file->durable->path, sizeof file->durable->path, "%s", path);
    remember(file);
}

static int vfs_open(sqlite3_vfs *vfs, const char *path, sqlite3_file *base, int flags, int *out)
{
    (void)vfs;
    struct file *file = of(base);
    *file = (struct file){.real = (sqlite3_file *)(void *)(file + 1)};
    if (fails(FAULT_OPEN))
        return SQLITE_CANTOPEN;
    int rc = disk.system->xOpen(disk.system, path, file->real, flags, out);
    if (rc != SQLITE_OK)
        return rc;
    base->pMethods = &methods;
    open_durable(file, path);
    return SQLITE_OK;
}

static int vfs_delete(sqlite3_vfs *vfs, const char *path, int sync)
{
    (void)vfs;
    struct durable *durable = find_durable(path);
    if (durable)
        durable->path[0] = '\0';
    return disk.system->xDelete(disk.system, path, sync);
}

static int vfs_access(sqlite3_vfs *vfs, const char *path, int flags, int *out)
{
    (void)vfs;
    return disk.system->xAccess(disk.system, path, flags, out);
}

static int vfs_path(sqlite3_vfs *vfs, const char *path, int bytes, char *out)
{
    (void)vfs;
    return disk.system->xFullPathname(disk.system, path, bytes, out);
}

static int vfs_random(sqlite3_vfs *vfs, int bytes, char *out)
{
    (void)vfs;
    return disk.system->xRandomness(disk.system, bytes, out);
}

static int vfs_sleep(sqlite3_vfs *vfs, int us)
{
    (void)vfs;
    return disk.system->xSleep(disk.system, us);
}

static int vfs_time(sqlite3_vfs *vfs, sqlite3_int64 *out)
{
    (void)vfs;
    return disk.system->xCurrentTimeInt64(disk.system, out);
}

static int vfs_error(sqlite3_vfs *vfs, int bytes, char *out)
{
    (void)vfs;
    if (disk.armed && disk.last_errno)
        return disk.last_errno;
    return disk.system->xGetLastError(disk.system, bytes, out);
}

void faults_install(void)
{
    if (disk.system)
        return;
    disk.system = sqlite3_vfs_find(NULL);
    ck_assert_ptr_nonnull(disk.system);
    disk.vfs = *disk.system;
    disk.vfs.szOsFile = (int)sizeof(struct file) + disk.system->szOsFile;
    disk.vfs.zName = "faults";
    disk.vfs.xOpen = vfs_open;
    disk.vfs.xDelete = vfs_delete;
    disk.vfs.xAccess = vfs_access;
    disk.vfs.xFullPathname = vfs_path;
    disk.vfs.xRandomness = vfs_random;
    disk.vfs.xSleep = vfs_sleep;
    disk.vfs.xCurrentTimeInt64 = vfs_time;
    disk.vfs.xGetLastError = vfs_error;
    ck_assert_int_eq(sqlite3_vfs_register(&disk.vfs, 1), SQLITE_OK);
}

void faults_remember(void)
{
    disk.remembers = true;
}

void faults_arm(const struct fault_plan *plan)
{
    disk.plan = *plan;
    disk.count = disk.failed = 0;
    disk.last_errno = 0;
    disk.armed = true;
}

long faults_disarm(void)
{
    disk.armed = false;
    return disk.failed;
}

bool faults_synced_again(void)
{
    return disk.synced_again;
}

static unsigned char *read_file(const char *path, sqlite3_int64 *bytes)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    fseek(file, 0, SEEK_END);
    *bytes = ftell(file);
    rewind(file);
    unsigned char *data = malloc((size_t)*bytes + 1);
    ck_assert_ptr_nonnull(data);
    ck_assert_int_eq((sqlite3_int64)fread(data, 1, (size_t)*bytes, file), *bytes);
    fclose(file);
    return data;
}

/* For each sector that differs, chooses either the synced or the written contents. */
static void lose_unsynced(const struct durable *durable, struct random *random)
{
    sqlite3_int64 bytes = 0;
    unsigned char *data = read_file(durable->path, &bytes);
    if (!data)
        return;
    for (sqlite3_int64 at = 0; at < durable->bytes && at < bytes; at += SECTOR_BYTES) {
        sqlite3_int64 end = durable->bytes < bytes ? durable->bytes : bytes;
        size_t part = end - at < SECTOR_BYTES ? (size_t)(end - at) : SECTOR_BYTES;
        if (random_bits(random) & 1)
            memcpy(data + at, durable->data + at, part);
    }
    for (sqlite3_int64 at = durable->bytes; at < bytes; at += SECTOR_BYTES) {
        if (random_bits(random) & 1)
            memset(data + at, 0, bytes - at < SECTOR_BYTES ? (size_t)(bytes - at) : SECTOR_BYTES);
    }
    FILE *file = fopen(durable->path, "wb");
    ck_assert_ptr_nonnull(file);
    fwrite(data, 1, (size_t)bytes, file);
    if (bytes < durable->bytes) /* a truncation that was not synced */
        fwrite(durable->data + bytes, 1, (size_t)(durable->bytes - bytes), file);
    fclose(file);
    free(data);
}

void faults_cut_power(uint64_t seed)
{
    struct random random = {seed, seed};
    for (int i = 0; i < disk.file_count; i++) {
        char shm[300];
        if (!disk.file[i].path[0])
            continue;
        lose_unsynced(&disk.file[i], &random);
        snprintf(shm, sizeof shm, "%s-shm", disk.file[i].path);
        unlink(shm);
    }
}

void faults_forget(void)
{
    for (int i = 0; i < disk.file_count; i++)
        free(disk.file[i].data);
    disk.file_count = 0;
}

/* SPDX-License-Identifier: MIT */
/* The paths of a store's files, symbolic links in them, renaming a complete file to its final name,
 * syncing the folder to make the name durable, and who holds the lock of a file. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "store/sqlite/sqlite.h"

char *pen_sqlite_resolve(const char *path)
{
    char *resolved = realpath(path, NULL);
    if (resolved || errno != ENOENT)
        return resolved;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    char *above = slash ? strndup(path, (size_t)(name - path)) : strdup(".");
    char *folder = above ? realpath(above, NULL) : NULL;
    if (folder && asprintf(&resolved, "%s/%s", strcmp(folder, "/") == 0 ? "" : folder, name) < 0)
        resolved = NULL;
    free(folder);
    free(above);
    return resolved;
}

bool pen_sqlite_same_file(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

bool pen_sqlite_is_named(int fd, const char *path)
{
    struct stat open_file, named;
    return fstat(fd, &open_file) == 0 && stat(path, &named) == 0 &&
           pen_sqlite_same_file(&open_file, &named);
}

void pen_sqlite_path(const struct pen_sqlite_store *store, const char *ending,
                     char path[PEN_SQLITE_PATH_BYTES])
{
    snprintf(path, PEN_SQLITE_PATH_BYTES, "%s%s", store->path, ending);
}

bool pen_sqlite_file_bytes(const struct pen_sqlite_store *store, const char *ending, int64_t *bytes)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    pen_sqlite_path(store, ending, path);
    const bool found = stat(path, &info) == 0;
    *bytes = found ? (int64_t)info.st_size : 0;
    return found;
}

bool pen_sqlite_sync_folder(const char *path)
{
    char folder[4096];
    snprintf(folder, sizeof folder, "%s", path);
    char *slash = strrchr(folder, '/');
    if (slash)
        slash[slash == folder] = '\0';
    int fd = open(slash ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    bool ok = fd >= 0 && fsync(fd) == 0;
    int error = errno;
    if (fd >= 0)
        close(fd);
    errno = error;
    return ok;
}

/* Not every file system supports RENAME_NOREPLACE; for the others the name is looked up first. */
bool pen_sqlite_name_new_file(const char *from, const char *to)
{
    if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0)
        return true;
    if (errno != EINVAL && errno != ENOSYS)
        return false;
    if (access(to, F_OK) != 0)
        return rename(from, to) == 0;
    errno = EEXIST;
    return false;
}

/* The process that holds a lock (flock) on the file; 0: it is not known, for it may run in another
 * namespace. Each line of /proc/locks is like "1: FLOCK ADVISORY WRITE 4711 08:01:123456 0 EOF",
 * whose third last word has device and inode. */
static long holder_of(int fd)
{
    char line[256], kind[16];
    struct stat info;
    unsigned long inode;
    long pid, found = 0;
    FILE *locks = fopen("/proc/locks", "re");
    if (!locks)
        return 0;
    while (fstat(fd, &info) == 0 && !found && fgets(line, sizeof line, locks)) {
        if (sscanf(line, "%*s %15s %*s %*s %ld %*x:%*x:%lu", kind, &pid, &inode) == 3 &&
            strcmp(kind, "FLOCK") == 0 && inode == (unsigned long)info.st_ino)
            found = pid;
    }
    fclose(locks);
    return found;
}

bool pen_sqlite_lock_is_held(int fd, const char *path, struct pen_status *st)
{
    char who[48] = "another process";
    long pid = holder_of(fd);
    if (pid > 0)
        snprintf(who, sizeof who, "process %ld", pid);
    return pen_fail(st, PEN_UNAVAILABLE, "the store cannot be opened: %s holds the lock on %s", who,
                    path);
}

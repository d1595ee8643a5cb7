/* SPDX-License-Identifier: MIT */
/* Simulates a failing disk under a running daemon. When preloaded, this library replaces the
 * functions with which SQLite accesses files whose path begins with $FAULTS_STORE. It reads the
 * file $FAULTS_CONTROL at every call. Each line of it makes an operation fail:
 *
 *     write ENOSPC       every write; or EIO, or SHORT: half is written, then the disk is full
 *     sync EIO 3         every third sync of a process
 *     read EIO           every read
 *
 * Truncation fails with `write`. With an empty or missing file no operation fails. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

enum { SHORT_WRITE = 10000 };

static atomic_long calls; /* of failing operations; a counter without order */

/* Defines system_NAME, the replaced function. ISO C has no cast from dlsym's object pointer to a
 * function pointer, so its bytes are copied. */
#define SYSTEM(type, name)                                                                         \
    static type system_##name;                                                                     \
    if (!system_##name) {                                                                          \
        void *found = dlsym(RTLD_NEXT, #name);                                                     \
        memcpy(&system_##name, &found, sizeof found);                                              \
    }

static bool is_store_file(int fd)
{
    char link[40], path[512];
    const char *store = getenv("FAULTS_STORE");
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = store ? readlink(link, path, sizeof path - 1) : -1;
    if (length < 0)
        return false;
    path[length] = '\0';
    return strncmp(path, store, strlen(store)) == 0;
}

static int error_of(const char *name)
{
    return strcmp(name, "ENOSPC") == 0 ? ENOSPC : strcmp(name, "SHORT") == 0 ? SHORT_WRITE : EIO;
}

/* The control file's fault for an operation: an errno, SHORT_WRITE, or 0 for none. */
static int fault_of(const char *operation)
{
    char text[256], *rest = text, *line;
    const char *control = getenv("FAULTS_CONTROL");
    int fd = control ? (int)syscall(SYS_openat, AT_FDCWD, control, O_RDONLY | O_CLOEXEC) : -1;
    long length = fd >= 0 ? syscall(SYS_read, fd, text, sizeof text - 1) : 0;
    if (fd >= 0)
        syscall(SYS_close, fd);
    text[length > 0 ? length : 0] = '\0';
    while ((line = strsep(&rest, "\n")) != NULL) {
        char name[16], error[16];
        long every = 1;
        if (sscanf(line, "%15s %15s %ld", name, error, &every) >= 2 && strcmp(name, operation) == 0)
            return ++calls % (every > 0 ? every : 1) == 0 ? error_of(error) : 0;
    }
    return 0;
}

static bool fails(int fd, const char *operation, int *error)
{
    int saved = errno;
    *error = is_store_file(fd) ? fault_of(operation) : 0;
    errno = *error && *error != SHORT_WRITE ? *error : saved;
    return *error != 0;
}

static size_t written_bytes(size_t bytes, int error)
{
    return error == SHORT_WRITE ? bytes / 2 : 0;
}

typedef ssize_t write_at(int, const void *, size_t, off_t);
typedef ssize_t read_at(int, void *, size_t, off_t);
typedef int sync_fd(int);
typedef int truncate_fd(int, off_t);

ssize_t pwrite64(int fd, const void *data, size_t bytes, off_t at)
{
    int error;
    SYSTEM(write_at *, pwrite64)
    if (!fails(fd, "write", &error))
        return system_pwrite64(fd, data, bytes, at);
    if (written_bytes(bytes, error))
        return system_pwrite64(fd, data, written_bytes(bytes, error), at);
    errno = error == SHORT_WRITE ? ENOSPC : error;
    return -1;
}

ssize_t pwrite(int fd, const void *data, size_t bytes, off_t at)
{
    return pwrite64(fd, data, bytes, at);
}

ssize_t pread64(int fd, void *data, size_t bytes, off_t at)
{
    int error;
    SYSTEM(read_at *, pread64)
    return fails(fd, "read", &error) ? -1 : system_pread64(fd, data, bytes, at);
}

ssize_t pread(int fd, void *data, size_t bytes, off_t at)
{
    return pread64(fd, data, bytes, at);
}

int fsync(int fd)
{
    int error;
    SYSTEM(sync_fd *, fsync)
    return fails(fd, "sync", &error) ? -1 : system_fsync(fd);
}

int fdatasync(int fd)
{
    int error;
    SYSTEM(sync_fd *, fdatasync)
    return fails(fd, "sync", &error) ? -1 : system_fdatasync(fd);
}

int ftruncate64(int fd, off_t bytes)
{
    int error;
    SYSTEM(truncate_fd *, ftruncate64)
    return fails(fd, "write", &error) ? -1 : system_ftruncate64(fd, bytes);
}

int ftruncate(int fd, off_t bytes)
{
    return ftruncate64(fd, bytes);
}

/* SPDX-License-Identifier: MIT */
#include "access/internal/small_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { BYTES_MAX = 1 << 20 };

static bool read_all(int fd, struct pen_small_file *file, struct pen_status *st)
{
    ssize_t got;
    if (!S_ISREG(file->info.st_mode))
        return pen_fail(st, PEN_FORBIDDEN, "not a regular file");
    file->text = malloc(BYTES_MAX + 2); /* a byte too many, and the zero byte */
    if (!file->text)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    while ((got = read(fd, file->text + file->bytes, BYTES_MAX + 1 - file->bytes)) != 0) {
        if (got < 0 && errno != EINTR)
            return pen_fail(st, PEN_IO, "cannot read: %s", strerror(errno));
        file->bytes += got > 0 ? (size_t)got : 0;
    }
    file->text[file->bytes] = '\0';
    return file->bytes <= BYTES_MAX ||
           pen_fail(st, PEN_TOO_LARGE, "larger than %d bytes", BYTES_MAX);
}

bool pen_small_file_read(struct pen_small_file *file, const char *path, struct pen_status *st)
{
    *file = (struct pen_small_file){0};
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    const bool ok = fd >= 0 && fstat(fd, &file->info) == 0
                        ? read_all(fd, file, st)
                        : pen_fail(st, errno == ENOENT ? PEN_NOT_FOUND : PEN_IO, "cannot open: %s",
                                   strerror(errno));
    if (fd >= 0)
        close(fd);
    return ok;
}

void pen_small_file_release(struct pen_small_file *file)
{
    if (file->text)
        explicit_bzero(file->text, file->bytes);
    free(file->text);
}

bool pen_small_file_has_changed(const char *path, struct stat *last)
{
    const struct stat old = *last;
    if (stat(path, last) != 0)
        *last = (struct stat){0};
    return last->st_dev != old.st_dev || last->st_ino != old.st_ino ||
           last->st_size != old.st_size || last->st_ctim.tv_sec != old.st_ctim.tv_sec ||
           last->st_ctim.tv_nsec != old.st_ctim.tv_nsec;
}

bool pen_small_file_name(const char *path, struct pen_status *st)
{
    return st->line > 0
               ? pen_fail(st, st->code, "%s:%d:%d: %s", path, st->line, st->column, st->msg)
               : pen_fail(st, st->code, "%s: %s", path, st->msg);
}

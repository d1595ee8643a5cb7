/* SPDX-License-Identifier: MIT */
/* The files of this module are small. So each is read whole, and read again when it changes. */
#ifndef PEN_ACCESS_INTERNAL_SMALL_FILE_H
#define PEN_ACCESS_INTERNAL_SMALL_FILE_H

#include <sys/stat.h>

#include "base/status.h"

struct pen_small_file {
    char *text; /* a zero byte follows it */
    size_t bytes;
    struct stat info;
};

/* Reads a regular file.
 * Owns: release *file in any case.
 * Fails: PEN_NOT_FOUND, PEN_IO, PEN_FORBIDDEN (another kind of file), PEN_TOO_LARGE (more than 1
 * MiB), PEN_NO_MEMORY. */
bool pen_small_file_read(struct pen_small_file *file, const char *path, struct pen_status *st);

/* Frees the text and wipes it, because it may be a private key. */
void pen_small_file_release(struct pen_small_file *file);

/* Returns true if a file differs from *last in contents, permissions or owner; *last becomes its
 * present state. All zeros stand for a missing file. */
bool pen_small_file_has_changed(const char *path, struct stat *last);

/* Adds the file's name and the place to the message. Returns false. */
bool pen_small_file_name(const char *path, struct pen_status *st);

#endif

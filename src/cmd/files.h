/* SPDX-License-Identifier: MIT */
/* Bytes in and out of the command line: a document comes from a file, standard input or the
 * built-in scenes; a result is written beside its place and renamed, so that a reader finds the
 * old file or the whole new one and nothing else. */
#ifndef PEN_CMD_FILES_H
#define PEN_CMD_FILES_H

#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"
#include "io/document.h"

/* A document and what to call it in messages. */
struct pen_source {
    struct pen_buf text;
    const char *label; /* the file's path, "standard input", "builtin:NAME" */
    bool builtin;
    bool xml; /* by its ending, .xml or .json, or else because the text begins with < */
};

/* Reads `name`: a path, `-`, or `builtin:NAME`; at most max_bytes. Owns: release it.
 * Fails: PEN_NOT_FOUND (with the nearest built-in name), PEN_TOO_LARGE, PEN_IO, PEN_NO_MEMORY. */
bool pen_source_read(struct pen_source *source, const char *name, size_t max_bytes,
                     struct pen_status *st);
/* The scene of a bare document, in JSON or XML. Errors as pen_scene_load. */
bool pen_source_scene(const struct pen_source *source, const struct pen_limits *limits,
                      struct pen_arena *arena, struct pen_scene_desc *desc,
                      struct pen_errors *errors);

/* A place in the document that XML was made into becomes one in the XML. */
void pen_source_locate(const struct pen_source *source, struct pen_status *st);

void pen_source_release(struct pen_source *source);

/* Reads a whole file of at most max_bytes (0: any size). Errors as pen_source_read. */
bool pen_file_read(const char *path, size_t max_bytes, struct pen_buf *out, struct pen_status *st);

/* Writes a file whole: a new file in the same folder, flushed to disk, then renamed over the old
 * one, then the folder flushed. An existing file's mode is kept. `-` is standard output; a path
 * that is no regular file (a pipe, /dev/null) is written to directly. Fails: PEN_IO. */
bool pen_file_write(const char *path, const void *data, size_t bytes, struct pen_status *st);

/* Tells before long work whether pen_file_write could create its file: by creating one in the same
 * folder and removing it again. Fails: PEN_IO, with the message that writing would give. */
bool pen_file_check(const char *path, struct pen_status *st);

#endif

/* SPDX-License-Identifier: MIT */
/* Reads documents and writes results. A document comes from a file, standard input or the built-in
 * scenes. A result is written to a new file in the same folder, which is then renamed. So a reader
 * finds either the old file or the whole new file. */
#ifndef PEN_CMD_FILES_H
#define PEN_CMD_FILES_H

#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"
#include "cmd/model_files.h"
#include "io/document.h"

/* A document and its name in messages. */
struct pen_source {
    struct pen_buf text;
    const char *label; /* the file's path, "standard input", "builtin:NAME" */
    /* The name ends in .xml. If it ends neither in .xml nor in .json, the text begins like XML. */
    bool xml;
    struct pen_models models; /* the model files that the scene may name */
};

/* Reads `name`: a path, `-`, or `builtin:NAME`; at most max_bytes (0: any size).
 * Owns: release *source in any case.
 * Fails: PEN_NOT_FOUND (with the nearest built-in name), PEN_TOO_LARGE, PEN_IO, PEN_NO_MEMORY. */
bool pen_source_read(struct pen_source *source, const char *name, size_t max_bytes,
                     struct pen_status *st);

/* As pen_source_read, for a scene, which may name model files. A path that ends in .ply, .obj or
 * .stl is a scene that shows that model; the text is its JSON. `options` may be NULL.
 * Fails: also as pen_models_scene. */
bool pen_source_read_scene(struct pen_source *source, const char *name,
                           const struct pen_model_options *options, struct pen_status *st);

/* Makes the description of a bare scene (not a job) in JSON or XML.
 * Fails: as pen_scene_load. */
bool pen_source_scene(struct pen_source *source, const struct pen_limits *limits,
                      struct pen_arena *arena, struct pen_scene_desc *desc,
                      struct pen_errors *errors);

/* Returns a bare scene as JSON, after checking all of it.
 * Owns: the caller calls json_decref().
 * Fails: NULL with errors->count > 0. */
json_t *pen_source_json(struct pen_source *source, const struct pen_limits *limits,
                        struct pen_errors *errors);

/* If the document is XML, replaces the JSON Pointer of *st by its line and column. */
void pen_source_locate(const struct pen_source *source, struct pen_status *st);

void pen_source_release(struct pen_source *source);

/* Returns true if a name ends in `ending`, such as ".xml", in upper or lower case, after at least
 * one other character. */
bool pen_name_ends_in(const char *name, const char *ending);

/* Reads a whole file of at most max_bytes (0: any size).
 * Fails: PEN_NOT_FOUND, PEN_TOO_LARGE, PEN_IO, PEN_NO_MEMORY. */
bool pen_file_read(const char *path, size_t max_bytes, struct pen_buf *out, struct pen_status *st);

/* Replaces a file as a whole:
 *   1. writes a new file in the same folder;
 *   2. renames it over the old file. It has the old file's mode and, where the system allows it,
 * owner. So a reader never sees a part of the file. The system writes both steps to the disk later.
 * The durable form waits until they are on the disk, which takes 2 to 60 ms.
 * `-` is standard output. A path that is not a regular file (a pipe, /dev/null) is written to
 * directly.
 * Fails: PEN_IO, PEN_NO_MEMORY. */
bool pen_file_write(const char *path, const void *data, size_t bytes, struct pen_status *st);
bool pen_file_write_durable(const char *path, const void *data, size_t bytes,
                            struct pen_status *st);

/* Checks before long work that pen_file_write can create its file: creates a file in the same
 * folder and removes it again.
 * Fails: PEN_IO, with the message of pen_file_write. */
bool pen_file_check(const char *path, struct pen_status *st);

#endif

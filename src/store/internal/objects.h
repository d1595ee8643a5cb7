/* SPDX-License-Identifier: MIT */
/* Values of any length: pixels of a batch, pictures, layers, reports, what a batch keeps, scene
 * documents. An object is `loading` while its parts are written, `used` when a transaction has made
 * it a value of its owner, and `gone` when it has been replaced or dropped. Parts of gone objects,
 * and of loading ones that nobody touches any more, are removed in slices (purge.c). */
#ifndef PEN_STORE_INTERNAL_OBJECTS_H
#define PEN_STORE_INTERNAL_OBJECTS_H

#include "store/internal/handle.h"

/* A value and whose it is. Of one job, view, layer and format (and batch, of pixels) at most one
 * object is used. */
struct pen_object {
    int64_t job; /* 0: a scene document */
    int view;
    int64_t batch, attempt;     /* of pixels and what is kept; 0: none */
    const char *layer, *format; /* layer: "" for pixels, "kept:NAME" for what is kept */
    const void *data;           /* NULL: there is no value, and nothing is written */
    size_t bytes;
    int64_t number; /* out; 0: not stored yet */
};

enum { PEN_PART_BYTES = 1 << 20 };

/* Writes a value of more than one part, before the transaction that uses it: each part in a
 * transaction of its own that does not wait for the disk. A shorter value is written by
 * pen_object_use, which also sets the job. `claim` (NULL: none) must hold before each part. Fails:
 * PEN_STALE, PEN_STORAGE_FULL. */
bool pen_object_load(struct pen_store *store, struct pen_object *object,
                     const struct pen_claim *claim, struct pen_status *st);

/* Within a transaction: makes the value its owner's, in place of the one before. */
bool pen_object_use(struct pen_store *store, struct pen_object *object, struct pen_status *st);

/* Within a transaction: drops what the batches of a view have kept; view -2: of all views. */
bool pen_kept_drop(struct pen_store *store, int64_t job, int64_t view, struct pen_status *st);

/* Appends the job's object of that view, layer and format; its number is 0 if there is none. Fails:
 * PEN_NOT_FOUND (no such job), PEN_GONE, PEN_STORAGE (damaged). */
bool pen_object_read(struct pen_store *store, const char *job, struct pen_object *object,
                     struct pen_buf *out, struct pen_status *st);

/* Within a transaction: appends the value of an object, whose checksum is checked. Fails:
 * PEN_STORAGE (damaged). */
bool pen_object_read_row(struct pen_store *store, int64_t number, struct pen_buf *out,
                         struct pen_status *st);

/* Within a write transaction: the scene with this SHA-256 if it is stored, and its `used_ms` is
 * renewed; 0: it is not. */
bool pen_scene_find(struct pen_store *store, const unsigned char sha256[32], int64_t *number,
                    struct pen_status *st);

/* Within a write transaction: stores a document, compressed and perhaps loaded before. */
bool pen_scene_add(struct pen_store *store, const unsigned char sha256[32],
                   struct pen_object *document, int64_t *number, struct pen_status *st);

#endif

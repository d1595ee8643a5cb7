/* SPDX-License-Identifier: MIT */
/* Objects: values of any length. Pixels of a batch, pictures, layers, reports, kept state and scene
 * documents are objects. An object is `loading` while its parts are written. It is `used` when a
 * transaction has made it a value of its owner, and `gone` when it was replaced or dropped. purge.c
 * removes the parts of gone objects, and of loading objects that are no longer written. */
#ifndef PEN_STORE_INTERNAL_OBJECTS_H
#define PEN_STORE_INTERNAL_OBJECTS_H

#include "store/internal/handle.h"

/* A value and its owner. At most one object of the same job, view, layer and format is used; pixels
 * have one of each batch. */
struct pen_object {
    int64_t job; /* 0: a scene document */
    int view;
    int64_t batch, attempt;     /* of pixels and of kept state; 0: none */
    const char *layer, *format; /* layer: "" for pixels, "kept:NAME" for kept state */
    const void *data;           /* NULL: there is no value, and nothing is written */
    size_t bytes;
    int64_t number; /* out; 0: not stored yet */
};

enum { PEN_PART_BYTES = 1 << 20 };

/* Writes a value of more than one part, before the transaction that uses it. Each part has its own
 * transaction, which does not wait for the disk. A shorter value is left to pen_object_use, which
 * also sets the job. `claim` (may be NULL) must hold before each part.
 * Fails: PEN_STALE, PEN_STORAGE_FULL. */
bool pen_object_load(struct pen_store *store, struct pen_object *object,
                     const struct pen_claim *claim, struct pen_status *st);

/* Makes the value its owner's, in place of the former value; within a transaction. */
bool pen_object_use(struct pen_store *store, struct pen_object *object, struct pen_status *st);

/* Drops what the batches of a view have kept, within a transaction. View -2 stands for all
 * views. */
bool pen_kept_drop(struct pen_store *store, int64_t job, int64_t view, struct pen_status *st);

/* Appends the job's object of this view, layer and format. Its number is 0 if there is none.
 * Fails: PEN_NOT_FOUND (no such job), PEN_GONE, PEN_STORAGE (damaged). */
bool pen_object_read(struct pen_store *store, const char *job, struct pen_object *object,
                     struct pen_buf *out, struct pen_status *st);

/* Appends the value of an object and checks its checksum; within a transaction.
 * Fails: PEN_STORAGE (damaged). */
bool pen_object_read_row(struct pen_store *store, int64_t number, struct pen_buf *out,
                         struct pen_status *st);

/* Finds the scene with this SHA-256 and renews its `used_ms`, within a write transaction. *number
 * is 0 if it is not stored. */
bool pen_scene_find(struct pen_store *store, const unsigned char sha256[32], int64_t *number,
                    struct pen_status *st);

/* Stores a document within a write transaction. The document is compressed, and may have been
 * loaded before. */
bool pen_scene_add(struct pen_store *store, const unsigned char sha256[32],
                   struct pen_object *document, int64_t *number, struct pen_status *st);

#endif

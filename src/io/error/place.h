/* SPDX-License-Identifier: MIT */
/* The place of a value in a document: a linked list of steps from the value up to the root. The
 * steps are local variables of the reading functions, so a valid document needs no text of a JSON
 * Pointer. */
#ifndef PEN_IO_ERROR_PLACE_H
#define PEN_IO_ERROR_PLACE_H

#include <stddef.h>

/* The member `key` of the object at `up`, or, if `key` is NULL, the element `index` of an array. */
struct pen_place {
    const struct pen_place *up; /* NULL: this is the document itself */
    const char *key;
    size_t index;
};

static inline struct pen_place pen_place_key(const struct pen_place *up, const char *key)
{
    return (struct pen_place){up, key, 0};
}

static inline struct pen_place pen_place_index(const struct pen_place *up, size_t index)
{
    return (struct pen_place){up, NULL, index};
}

/* Writes `prefix` and the JSON Pointer (RFC 6901) of a place. Text that does not fit is cut. */
void pen_place_pointer(const struct pen_place *at, const char *prefix, char *out, size_t bytes);

#endif

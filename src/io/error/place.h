/* SPDX-License-Identifier: MIT */
/* Where a value stands in a document: the steps from the root to it. A place is a chain of stack
 * frames, so reading a valid document never costs the text of a pointer. */
#ifndef PEN_IO_ERROR_PLACE_H
#define PEN_IO_ERROR_PLACE_H

#include <stddef.h>

/* The member `key`, or if that is NULL the element `index`, of the value at `up`. */
struct pen_place {
    const struct pen_place *up; /* NULL: this is the root */
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

/* Writes the JSON Pointer (RFC 6901) of a place, after `prefix`, as much as fits. */
void pen_place_pointer(const struct pen_place *at, const char *prefix, char *out, size_t bytes);

#endif

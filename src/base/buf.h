/* SPDX-License-Identifier: MIT */
/* A growing byte buffer. A failed append sets `failed` and changes nothing else, and every later
 * append does nothing, so a writer checks once at its end. */
#ifndef PEN_BASE_BUF_H
#define PEN_BASE_BUF_H

#include <stdbool.h>
#include <stddef.h>

struct pen_buf {
    unsigned char *data; /* NULL while empty; always followed by a zero byte once not */
    size_t bytes, capacity;
    bool failed; /* out of memory */
};

/* An empty buffer; {0} is one too. */
void pen_buf_init(struct pen_buf *buf);

/* Frees the contents; the buffer is empty afterwards. */
void pen_buf_release(struct pen_buf *buf);

/* Appends bytes. Returns false when out of memory. */
bool pen_buf_add(struct pen_buf *buf, const void *data, size_t bytes);

/* Appends a string without its end. */
bool pen_buf_puts(struct pen_buf *buf, const char *text);

/* Appends formatted text. */
bool pen_buf_printf(struct pen_buf *buf, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif

/* SPDX-License-Identifier: MIT */
/* A growing byte buffer. An append that fails sets `failed` and changes nothing else; later appends
 * do nothing. So a writer needs to check `failed` only once, at its end. */
#ifndef PEN_BASE_BUF_H
#define PEN_BASE_BUF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

struct pen_buf {
    unsigned char
        *data; /* NULL before the first append; from then on a zero byte follows the data */
    size_t bytes, capacity;
    bool failed; /* out of memory */
};

/* Makes an empty buffer; {0} is one too. */
void pen_buf_init(struct pen_buf *buf);

/* Frees the contents and leaves an empty buffer. */
void pen_buf_release(struct pen_buf *buf);

/* Reserves space for contents of this number of bytes in all, and no more; a buffer that grows
 * takes up to twice as much. Returns false when out of memory; the buffer is then unchanged and has
 * not failed. */
bool pen_buf_reserve(struct pen_buf *buf, size_t bytes);

/* Appends bytes. Returns false when out of memory. */
bool pen_buf_add(struct pen_buf *buf, const void *data, size_t bytes);

/* Appends a string without its terminating zero. It is inline, so that the compiler computes the
 * length of a literal. */
static inline bool pen_buf_puts(struct pen_buf *buf, const char *text)
{
    return pen_buf_add(buf, text, strlen(text));
}

/* Appends a number in decimal. Faster than pen_buf_printf. */
bool pen_buf_number(struct pen_buf *buf, uint64_t number);

/* Appends formatted text. */
bool pen_buf_printf(struct pen_buf *buf, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif

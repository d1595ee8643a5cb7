/* SPDX-License-Identifier: MIT */
/* The capacity doubles, so appending n bytes takes time proportional to n. Invariant: once there is
 * data, a zero byte follows it, so the contents can be read as a string. */
#include "base/buf.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 256 };

void pen_buf_init(struct pen_buf *buf)
{
    *buf = (struct pen_buf){0};
}

void pen_buf_release(struct pen_buf *buf)
{
    free(buf->data);
    pen_buf_init(buf);
}

/* Makes space for `more` bytes and a zero byte, which do not fit yet. */
static bool grow(struct pen_buf *buf, size_t more)
{
    if (buf->failed)
        return false;
    if (more >= SIZE_MAX / 2 - buf->bytes)
        return !(buf->failed = true);
    const size_t needed = buf->bytes + more + 1;
    size_t capacity = buf->capacity ? buf->capacity : FIRST_CAPACITY;
    while (capacity < needed)
        capacity *= 2;
    unsigned char *data = realloc(buf->data, capacity);
    if (!data)
        return !(buf->failed = true);
    buf->data = data;
    buf->capacity = capacity;
    return true;
}

/* Makes sure that `more` bytes and a zero byte fit. */
static inline bool reserve(struct pen_buf *buf, size_t more)
{
    return (!buf->failed && more < buf->capacity - buf->bytes) || grow(buf, more);
}

bool pen_buf_reserve(struct pen_buf *buf, size_t bytes)
{
    if (bytes < buf->capacity)
        return true;
    unsigned char *data = bytes < SIZE_MAX ? realloc(buf->data, bytes + 1) : NULL;
    if (!data)
        return false;
    data[buf->bytes] = '\0';
    buf->data = data;
    buf->capacity = bytes + 1;
    return true;
}

bool pen_buf_add(struct pen_buf *buf, const void *data, size_t bytes)
{
    if (!reserve(buf, bytes))
        return false;
    if (bytes)
        memcpy(buf->data + buf->bytes, data, bytes);
    buf->bytes += bytes;
    buf->data[buf->bytes] = '\0';
    return true;
}

bool pen_buf_number(struct pen_buf *buf, uint64_t number)
{
    char digits[20], *first = digits + sizeof digits;
    do
        *--first = (char)('0' + number % 10);
    while ((number /= 10) > 0);
    return pen_buf_add(buf, first, (size_t)(digits + sizeof digits - first));
}

/* Most texts fit into the free capacity; only a text that does not is formatted twice. */
bool pen_buf_printf(struct pen_buf *buf, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    bool ok = reserve(buf, 0);
    const size_t room = buf->capacity - buf->bytes;
    const int length = ok ? vsnprintf((char *)buf->data + buf->bytes, room, format, args) : -1;
    va_end(args);
    ok = length >= 0 && reserve(buf, (size_t)length);
    if (ok && (size_t)length >= room)
        vsnprintf((char *)buf->data + buf->bytes, (size_t)length + 1, format, again);
    va_end(again);
    if (ok)
        buf->bytes += (size_t)length;
    if (buf->data)
        buf->data[buf->bytes] = '\0'; /* also after a text that was cut or could not be formatted */
    buf->failed = !ok;
    return ok;
}

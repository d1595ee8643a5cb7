/* SPDX-License-Identifier: MIT */
/* Reading a body in chunks. The lines between chunks are read byte by byte. */
#include "http/wire.h"

enum { LINE_BYTES = 256 };

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* The end of a line with a chunk's size. */
static bool end_size_line(struct pen_chunks *chunks)
{
    bool ok = chunks->digits;
    chunks->state = chunks->left > 0 ? PEN_CHUNKS_DATA : PEN_CHUNKS_TRAILER;
    chunks->line = 0;
    chunks->digits = chunks->space = chunks->extension = false;
    return ok;
}

/* Reads a byte of a size, or of an extension after it, which is skipped. */
static bool read_size_byte(struct pen_chunks *chunks, char c)
{
    int digit = chunks->space || chunks->extension ? -1 : hex_digit(c);
    if (digit >= 0) {
        if (chunks->left >> 56)
            return false;
        chunks->left = chunks->left << 4 | (uint64_t)digit;
        chunks->digits = true;
        return true;
    }
    const bool space = c == ' ' || c == '\t';
    if (!chunks->digits || (!chunks->extension && c != ';' && !space))
        return false;
    chunks->space = true;
    chunks->extension = chunks->extension || c == ';';
    return (unsigned char)c >= ' ' || space;
}

/* Reads one byte outside of chunks. Every line ends in CR and LF. */
static bool read_line_byte(struct pen_chunks *chunks, char c)
{
    if (chunks->cr != (c == '\n'))
        return false;
    if (c == '\r') {
        chunks->cr = true;
        return true;
    }
    if (c != '\n') {
        return chunks->state == PEN_CHUNKS_SIZE && ++chunks->line <= LINE_BYTES &&
               read_size_byte(chunks, c);
    }
    chunks->cr = false;
    if (chunks->state == PEN_CHUNKS_SIZE)
        return end_size_line(chunks);
    chunks->state = PEN_CHUNKS_SIZE;
    return true;
}

ptrdiff_t pen_chunks_read(struct pen_chunks *chunks, const char *text, size_t bytes,
                          const char **data, size_t *data_bytes)
{
    size_t at = 0;
    *data_bytes = 0;
    while (at < bytes && chunks->state != PEN_CHUNKS_TRAILER) {
        if (chunks->state != PEN_CHUNKS_DATA) {
            if (!read_line_byte(chunks, text[at++]))
                return -1;
            continue;
        }
        *data = text + at;
        *data_bytes = chunks->left < bytes - at ? (size_t)chunks->left : bytes - at;
        chunks->left -= *data_bytes;
        at += *data_bytes;
        if (chunks->left == 0)
            chunks->state = PEN_CHUNKS_END;
        break;
    }
    return (ptrdiff_t)at;
}

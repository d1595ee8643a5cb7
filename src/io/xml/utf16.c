/* SPDX-License-Identifier: MIT */
#include "io/xml/utf16.h"

#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/document.h"
#include "io/error/text.h"

bool pen_text_is_utf16(const char *text, size_t bytes)
{
    return bytes >= 2 && (memcmp(text, "\xFF\xFE", 2) == 0 || memcmp(text, "\xFE\xFF", 2) == 0);
}

/* The unit at an offset. The first byte of the text's mark gives the byte order. */
static unsigned unit(const char *text, size_t at)
{
    const unsigned a = (unsigned char)text[at], b = (unsigned char)text[at + 1];
    return (unsigned char)text[0] == 0xFF ? a | b << 8 : a << 8 | b;
}

/* Reads the character at *at, and moves *at behind it. Returns false for half a surrogate pair. */
static bool next_character(const char *text, size_t bytes, size_t *at, unsigned *code)
{
    if (bytes - *at < 2)
        return false;
    *code = unit(text, *at);
    *at += 2;
    if (*code < 0xD800 || *code > 0xDFFF)
        return true;
    const unsigned low = *code < 0xDC00 && bytes - *at >= 2 ? unit(text, *at) : 0;
    *code = 0x10000 + ((*code - 0xD800) << 10) + (low - 0xDC00);
    *at += 2;
    return low >= 0xDC00 && low <= 0xDFFF;
}

/* Frees the text so far; the error is at its end. */
static char *refuse(char *out, size_t used, struct pen_status *st)
{
    int line, column;
    pen_text_position(out, used, &line, &column);
    pen_fail_line(st, PEN_SYNTAX, line, column,
                  "half a character: the text is cut or is not in UTF-16, as its byte-order mark "
                  "says");
    free(out);
    return NULL;
}

char *pen_utf16_to_utf8(const char *text, size_t bytes, size_t *out_bytes, struct pen_status *st)
{
    char *out = malloc(bytes / 2 * 3 + 1), character[4];
    size_t used = 0;
    unsigned code;
    if (!out) {
        pen_fail(st, PEN_NO_MEMORY, "the document does not fit into memory");
        return NULL;
    }
    for (size_t at = 2; at < bytes;) {
        if (!next_character(text, bytes, &at, &code))
            return refuse(out, used, st);
        const size_t length = pen_utf8_encode(code, character);
        memcpy(out + used, character, length);
        used += length;
    }
    *out_bytes = used;
    return out;
}

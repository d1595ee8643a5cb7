/* SPDX-License-Identifier: MIT */
/* Valid characters are those of Table 3-7 of the Unicode standard, "Well-Formed UTF-8 Byte
 * Sequences". The first byte limits the range of the second; all further bytes are 0x80 to 0xBF. */
#include "base/utf8.h"

#include <stdbool.h>
#include <string.h>

static bool between(unsigned char c, unsigned lo, unsigned hi)
{
    return c >= lo && c <= hi;
}

size_t pen_utf8_char(const char *text, size_t bytes)
{
    const unsigned char *s = (const unsigned char *)text;
    if (bytes == 0)
        return 0;
    if (s[0] < 0x80)
        return 1;
    size_t length = between(s[0], 0xC2, 0xDF)   ? 2
                    : between(s[0], 0xE0, 0xEF) ? 3
                    : between(s[0], 0xF0, 0xF4) ? 4
                                                : 0;
    if (length == 0 || bytes < length)
        return 0;
    unsigned lo = s[0] == 0xE0 ? 0xA0 : s[0] == 0xF0 ? 0x90 : 0x80;
    unsigned hi = s[0] == 0xED ? 0x9F : s[0] == 0xF4 ? 0x8F : 0xBF;
    if (!between(s[1], lo, hi))
        return 0;
    for (size_t i = 2; i < length; i++) {
        if (!between(s[i], 0x80, 0xBF))
            return 0;
    }
    return length;
}

bool pen_utf8_copy(char *out, size_t out_bytes, const char *text)
{
    size_t left = strlen(text), free_bytes = out_bytes - 1;
    while (left > 0) {
        size_t length = pen_utf8_char(text, left);
        size_t taken = length ? length : 1;
        if (taken > free_bytes)
            break;
        if (length)
            memcpy(out, text, length);
        else
            *out = '?';
        out += taken, text += taken;
        left -= taken, free_bytes -= taken;
    }
    *out = '\0';
    return left == 0;
}

/* SPDX-License-Identifier: MIT */
/* Valid characters are those of Table 3-7 of the Unicode standard, "Well-Formed UTF-8 Byte
 * Sequences". The first byte limits the range of the second; all further bytes are 0x80 to 0xBF. */
#include "base/utf8.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
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

size_t pen_utf8_count(const char *text)
{
    size_t count = 0;
    for (size_t left = strlen(text); left > 0; count++) {
        size_t length = pen_utf8_char(text, left);
        length = length ? length : 1;
        text += length, left -= length;
    }
    return count;
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

/* The number of a valid character of `length` bytes. */
static uint32_t code_of(const char *text, size_t length)
{
    const unsigned char *s = (const unsigned char *)text;
    if (length == 1)
        return s[0];
    uint32_t code = s[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++)
        code = code << 6 | (s[i] & 0x3Fu);
    return code;
}

/* Characters of the Unicode categories Cc, Zl and Zp; and those of Cf that have no shape of their
 * own, without the joiners U+200C and U+200D, which some scripts need. The bidirectional ones
 * (Unicode Standard Annex #9) could make a name look like another text. */
static bool is_hidden(uint32_t code)
{
    static const struct {
        uint32_t first, last;
    } ranges[] = {{0x00, 0x1F},       {0x7F, 0x9F},       {0xAD, 0xAD},      {0x61C, 0x61C},
                  {0x180E, 0x180E},   {0x200B, 0x200B},   {0x200E, 0x200F},  {0x2028, 0x202E},
                  {0x2060, 0x206F},   {0xFEFF, 0xFEFF},   {0xFFF9, 0xFFFB},  {0x13430, 0x1345F},
                  {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE007F}};
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0] && code >= ranges[i].first; i++) {
        if (code <= ranges[i].last)
            return true;
    }
    return false;
}

size_t pen_utf8_show_char(const char *text, size_t bytes, char out[PEN_UTF8_SHOWN_BYTES])
{
    size_t length = pen_utf8_char(text, bytes);
    uint32_t code = length ? code_of(text, length) : '?';
    if (length == 0)
        snprintf(out, PEN_UTF8_SHOWN_BYTES, "?");
    else if (code == '\n')
        snprintf(out, PEN_UTF8_SHOWN_BYTES, "\\n");
    else if (!is_hidden(code))
        snprintf(out, PEN_UTF8_SHOWN_BYTES, "%.*s", (int)length, text);
    else if (code < 0x10000)
        snprintf(out, PEN_UTF8_SHOWN_BYTES, "\\u%04x", (unsigned)code);
    else /* a surrogate pair */
        snprintf(out, PEN_UTF8_SHOWN_BYTES, "\\u%04x\\u%04x",
                 (unsigned)(0xD800 + ((code - 0x10000) >> 10)),
                 (unsigned)(0xDC00 + (code & 0x3FF)));
    return length ? length : 1;
}

bool pen_utf8_show(char *out, size_t out_bytes, const char *text)
{
    size_t used = 0;
    for (size_t left = strlen(text); left > 0;) {
        char shown[PEN_UTF8_SHOWN_BYTES];
        size_t taken = pen_utf8_show_char(text, left, shown), length = strlen(shown);
        if (used + length >= out_bytes)
            break;
        memcpy(out + used, shown, length);
        used += length;
        text += taken, left -= taken;
    }
    out[used] = '\0';
    return *text == '\0';
}

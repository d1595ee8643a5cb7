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

bool pen_utf8_is_valid(const char *text, size_t bytes)
{
    for (size_t length; bytes > 0; text += length, bytes -= length) {
        length = pen_utf8_char(text, bytes);
        if (length == 0)
            return false;
    }
    return true;
}

size_t pen_utf8_encode(unsigned code, char out[4])
{
    static const unsigned char lead[] = {0, 0, 0xC0, 0xE0, 0xF0};
    size_t length = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (size_t i = length; i-- > 1; code >>= 6)
        out[i] = (char)(0x80 | (code & 0x3F));
    out[0] = (char)(lead[length] | code);
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
        if (free_bytes > 0 && (unsigned char)*text < 0x80) { /* most text */
            *out++ = *text++;
            left--, free_bytes--;
            continue;
        }
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

struct range {
    uint32_t first, last;
};

/* Whether one of the ranges, which are in ascending order, contains the code. */
static bool in_ranges(uint32_t code, const struct range *ranges, size_t count)
{
    for (size_t i = 0; i < count && code >= ranges[i].first; i++) {
        if (code <= ranges[i].last)
            return true;
    }
    return false;
}

/* Whether a character is hidden: those of the Unicode categories Cc, Zl and Zp, and those of Cf
 * without their own shape. The joiners U+200C and U+200D, which some scripts need, are not hidden.
 * The bidirectional ones (Unicode Standard Annex #9) could make a name look like another text. */
static bool is_hidden(uint32_t code)
{
    static const struct range hidden[] = {
        {0x00, 0x1F},       {0x7F, 0x9F},       {0xAD, 0xAD},      {0x61C, 0x61C},
        {0x180E, 0x180E},   {0x200B, 0x200B},   {0x200E, 0x200F},  {0x2028, 0x202E},
        {0x2060, 0x206F},   {0xFEFF, 0xFEFF},   {0xFFF9, 0xFFFB},  {0x13430, 0x1345F},
        {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE007F}};
    return in_ranges(code, hidden, sizeof hidden / sizeof *hidden);
}

static bool is_mark(uint32_t code)
{
    static const struct range marks[] = {{0x300, 0x36F},   {0x483, 0x489},   {0x1AB0, 0x1AFF},
                                         {0x1DC0, 0x1DFF}, {0x200C, 0x200D}, {0x20D0, 0x20FF},
                                         {0xFE00, 0xFE0F}, {0xFE20, 0xFE2F}};
    return in_ranges(code, marks, sizeof marks / sizeof *marks);
}

static bool is_wide(uint32_t code)
{
    static const struct range wide[] = {{0x1100, 0x115F},   {0x231A, 0x231B},   {0x2329, 0x232A},
                                        {0x2E80, 0x303E},   {0x3041, 0x4DBF},   {0x4E00, 0xA4CF},
                                        {0xA960, 0xA97F},   {0xAC00, 0xD7A3},   {0xF900, 0xFAFF},
                                        {0xFE10, 0xFE19},   {0xFE30, 0xFE6F},   {0xFF00, 0xFF60},
                                        {0xFFE0, 0xFFE6},   {0x1F300, 0x1F64F}, {0x1F680, 0x1F6FF},
                                        {0x1F900, 0x1F9FF}, {0x1FA70, 0x1FAFF}, {0x20000, 0x3FFFD}};
    return in_ranges(code, wide, sizeof wide / sizeof *wide);
}

int pen_utf8_char_columns(const char *text, size_t bytes, size_t *length)
{
    *length = pen_utf8_char(text, bytes);
    if (*length == 0) {
        *length = 1;
        return 1;
    }
    const uint32_t code = code_of(text, *length);
    return is_mark(code) ? 0 : is_wide(code) ? 2 : 1;
}

size_t pen_utf8_columns(const char *text, size_t bytes)
{
    size_t columns = 0;
    for (size_t length; bytes > 0; text += length, bytes -= length)
        columns += (size_t)pen_utf8_char_columns(text, bytes, &length);
    return columns;
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

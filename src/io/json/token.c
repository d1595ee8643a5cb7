/* SPDX-License-Identifier: MIT */
#include "io/json/token.h"

bool pen_json_is_delimiter(char c)
{
    switch (c) {
    case '[':
    case ']':
    case '{':
    case '}':
    case ',':
    case ':':
    case '"':
    case ' ':
    case '\t':
    case '\n':
    case '\r':
        return true;
    default:
        return false;
    }
}

size_t pen_json_word_end(const struct pen_json_text *json, size_t offset)
{
    while (offset < json->bytes && !pen_json_is_delimiter(json->text[offset]))
        offset++;
    return offset;
}

size_t pen_json_string_end(const struct pen_json_text *json, size_t offset)
{
    size_t i = offset + 1;
    while (i < json->bytes && json->text[i] != '"')
        i += json->text[i] == '\\' ? 2 : 1;
    return i < json->bytes ? i + 1 : json->bytes;
}

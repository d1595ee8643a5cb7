/* SPDX-License-Identifier: MIT */
/* Finds the text of a member. The text is known to be well-formed JSON, so the scan only
 * distinguishes strings from structure. */
#include <string.h>

#include "jobs/internal/members.h"

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* Returns the text from `begin` to `end`, without white space at its ends. */
static const char *trim(const char *text, size_t begin, size_t end, size_t *length)
{
    while (begin < end && is_space(text[begin]))
        begin++;
    while (begin < end && is_space(text[end - 1]))
        end--;
    *length = end - begin;
    return text + begin;
}

/* Returns the end of the string that begins at `at`: its second quote. */
static size_t string_end(const char *text, size_t bytes, size_t at)
{
    for (at++; at < bytes && text[at] != '"'; at++)
        at += text[at] == '\\';
    return at;
}

const char *pen_json_member(const char *text, size_t bytes, const char *key, size_t *length)
{
    const size_t key_bytes = strlen(key);
    size_t value = 0; /* where the member's value begins; 0: not found yet */
    int depth = 0;
    bool is_key = false, matches = false; /* outermost: a key is next; it was `key` */
    for (size_t at = 0; at < bytes; at++) {
        const char c = text[at];
        if (c == '"') {
            const size_t end = string_end(text, bytes, at);
            matches = is_key && end < bytes && end - at == key_bytes + 1 &&
                      memcmp(text + at + 1, key, key_bytes) == 0;
            at = end;
        } else if (c == '{' || c == '[') {
            depth++;
        } else if (c == ':' && matches && value == 0) {
            value = at + 1;
        } else if (c == ',' || c == '}' || c == ']') {
            if (value > 0 && depth == 1)
                return trim(text, value, at, length);
            depth -= c != ',';
        }
        if (strchr("{[,:\"", c))
            is_key = depth == 1 && (c == '{' || c == ',');
    }
    return NULL;
}

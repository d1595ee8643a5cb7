/* SPDX-License-Identifier: MIT */
/* The text is known to be well-formed JSON, so the scan only has to tell strings from structure. */
#include "jobs/internal/json_member.h"

#include <stdbool.h>
#include <string.h>

struct scan {
    const char *text;
    size_t bytes, at;
};

static bool at_end(const struct scan *s)
{
    return s->at >= s->bytes;
}

static void skip_space(struct scan *s)
{
    while (!at_end(s) && s->text[s->at] && strchr(" \t\r\n", s->text[s->at]))
        s->at++;
}

/* Skips a character of the structure, and the white space around it. Returns false if another
 * character comes. */
static bool take(struct scan *s, char c)
{
    skip_space(s);
    if (at_end(s) || s->text[s->at] != c)
        return false;
    s->at++;
    skip_space(s);
    return true;
}

static void skip_string(struct scan *s)
{
    for (s->at++; !at_end(s) && s->text[s->at] != '"'; s->at++)
        s->at += s->text[s->at] == '\\';
    s->at++;
}

/* Skips a value, and the white space that follows a number or a word. */
static void skip_value(struct scan *s)
{
    int depth = 0;
    while (!at_end(s)) {
        char c = s->text[s->at];
        if (c == '"') {
            skip_string(s);
        } else if (c == '}' || c == ']' || c == ',') {
            if (depth == 0)
                return;
            depth -= c != ',';
            s->at++;
        } else {
            depth += c == '{' || c == '[';
            s->at++;
        }
    }
}

/* The length of a value without the white space behind it. */
static size_t trimmed_length(const char *value, size_t length)
{
    while (length > 0 && strchr(" \t\r\n", value[length - 1]))
        length--;
    return length;
}

const char *pen_json_member(const char *text, size_t bytes, const char *key, size_t *length)
{
    struct scan s = {.text = text, .bytes = bytes};
    size_t key_bytes = strlen(key);
    if (!take(&s, '{'))
        return NULL;
    do {
        size_t name = s.at + 1;
        if (at_end(&s) || text[s.at] != '"')
            return NULL;
        skip_string(&s);
        bool found = s.at == name + key_bytes + 1 && s.at <= bytes &&
                     memcmp(text + name, key, key_bytes) == 0;
        if (!take(&s, ':'))
            return NULL;
        size_t begin = s.at;
        skip_value(&s);
        if (found && s.at > bytes)
            return NULL; /* a string that does not end */
        if (found) {
            *length = trimmed_length(text + begin, s.at - begin);
            return text + begin;
        }
    } while (take(&s, ','));
    return NULL;
}

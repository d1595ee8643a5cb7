/* SPDX-License-Identifier: MIT */
#include "io/mesh/scan.h"

#include <math.h>
#include <stdlib.h>

#include "io/json/number.h"

enum { NUMBER_BYTES = 256 };

bool pen_scan_fail(const struct pen_scan *s, enum pen_code code, const char *at, const char *format,
                   ...)
{
    char message[PEN_MSG_BYTES];
    va_list args;
    va_start(args, format);
    if (s->binary) {
        if (vsnprintf(message, sizeof message, format, args) >= 0)
            pen_fail(s->st, code, "Byte %zu: %s", (size_t)(at - s->begin), message);
    } else {
        pen_text_fail(s->st, code, s->begin, (size_t)(at - s->begin), format, args);
    }
    va_end(args);
    return false;
}

struct pen_text pen_scan_found(const struct pen_scan *s, const char *at)
{
    char word[NUMBER_BYTES];
    size_t n = 0;
    if (at >= s->end)
        return (struct pen_text){"the end of the file"};
    if (*at == '\n' || *at == '\r')
        return (struct pen_text){"the end of the line"};
    for (; at < s->end && *at && !pen_is_space(*at) && n + 1 < sizeof word; at++)
        word[n++] = *at;
    word[n] = '\0';
    return pen_text_quote(word);
}

/* The length of a line end after a backslash at `at`; 0 if there is none. */
static size_t continuation(const struct pen_scan *s, const char *at)
{
    if (s->end - at < 2 || *at != '\\')
        return 0;
    return at[1] == '\n' ? 2 : s->end - at > 2 && at[1] == '\r' && at[2] == '\n' ? 3 : 0;
}

bool pen_scan_more(struct pen_scan *s)
{
    const char *at = s->at, *end = s->end; /* in registers */
    bool more = false;
    for (size_t over = 1; at < end && over; at += over) {
        const char c = *at;
        over = c == '\\' ? continuation(s, at) : c != '\n' && pen_is_space(c);
        more = !over && c != '\n' && c != '#';
    }
    s->at = at;
    return more;
}

void pen_scan_next_line(struct pen_scan *s)
{
    const char *first = s->at, *line;
    const bool comment = first < s->end && *first == '#';
    do {
        line = memchr(s->at, '\n', (size_t)(s->end - s->at));
        s->at = line ? line + 1 : s->end;
    } while (line && !comment &&
             ((line - first >= 1 && line[-1] == '\\') ||
              (line - first >= 2 && line[-1] == '\r' && line[-2] == '\\')));
}

/* A comment ends with its line, also after a backslash. */
bool pen_scan_statement(struct pen_scan *s, const char **word, size_t *length)
{
    while (!pen_scan_more(s)) {
        const char *line = memchr(s->at, '\n', (size_t)(s->end - s->at));
        if (!line)
            return false;
        s->at = line + 1;
    }
    *length = pen_scan_word(s, word);
    return true;
}

size_t pen_scan_rest(struct pen_scan *s, const char **text)
{
    const char *line = memchr(s->at, '\n', (size_t)(s->end - s->at)), *last = line ? line : s->end;
    while (s->at < last && pen_is_space(*s->at))
        s->at++;
    *text = s->at;
    s->at = last;
    while (last > *text && pen_is_space(last[-1]))
        last--;
    return (size_t)(last - *text);
}

size_t pen_scan_word(struct pen_scan *s, const char **word)
{
    const char *at = s->at, *end = s->end;
    *word = at;
    while (at < end && !pen_is_space(*at) && !(*at == '\\' && continuation(s, at)))
        at++;
    s->at = at;
    return (size_t)(at - *word);
}

/* Whether the float nearest to d is also the float nearest to a decimal that rounds to d, which is
 * 0 or above 1e-28. */
static bool decides_float(double d)
{
    uint64_t bits;
    memcpy(&bits, &d, sizeof bits);
    return (bits & 0x1fffffff) != 0x10000000;
}

/* The nearest double of most decimals takes one division; it rounds to the nearest float, unless it
 * is in the middle between two. The others are left to the C library. */
bool pen_scan_number(struct pen_scan *s, struct pen_number *out)
{
    char text[NUMBER_BYTES];
    struct pen_json_decimal decimal;
    size_t bytes, end = pen_java_scan_number(s->at, 0, (size_t)(s->end - s->at), &decimal, &bytes);
    const char *after = s->at + end;
    if (end == 0 || end != bytes ||
        (after < s->end && !pen_is_space(*after) && !continuation(s, after)))
        return pen_scan_fail(s, PEN_SYNTAX, s->at,
                             "found %s; write a finite decimal number like -1.5e3",
                             pen_scan_found(s, s->at).text);
    if (pen_json_nearest(&decimal, &out->d) && decides_float(out->d)) {
        out->f = (float)out->d;
    } else if (bytes < sizeof text) {
        memcpy(text, s->at, bytes);
        text[bytes] = '\0';
        *out = (struct pen_number){strtod(text, NULL), strtof(text, NULL)};
    } else {
        return pen_scan_fail(s, PEN_SYNTAX, s->at, "a number of %zu characters; write fewer digits",
                             bytes);
    }
    if (!isfinite(out->f))
        return pen_scan_fail(s, PEN_INVALID, s->at, "%s is too large; numbers are below 3.4e38",
                             pen_scan_found(s, s->at).text);
    s->at = after;
    return true;
}

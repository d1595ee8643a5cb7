/* SPDX-License-Identifier: MIT */
/* Decimals become the nearest double and the nearest float. A decimal of up to 2^53 and 22 places
 * takes one division, which rounds it correctly to a double. This double rounds to the right float,
 * unless it is in the middle between two floats. All other decimals are left to the C library.
 * Source: Clinger, "How to read floating point numbers accurately", PLDI 1990. */
#include "io/mesh/scan.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { NUMBER_BYTES = 256, PLACES = 22, EXPONENT_MAX = 100000 };

static const double powers[PLACES + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                          1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                          1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

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
    size_t over;
    for (; s->at < s->end; s->at += over) {
        char c = *s->at;
        over = c == '\\' ? continuation(s, s->at) : c != '\n' && pen_is_space(c);
        if (!over)
            return c != '\n' && c != '#';
    }
    return false;
}

void pen_scan_next_line(struct pen_scan *s)
{
    const char *first = s->at, *line;
    do {
        line = memchr(s->at, '\n', (size_t)(s->end - s->at));
        s->at = line ? line + 1 : s->end;
    } while (line && ((line - first >= 1 && line[-1] == '\\') ||
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
    *word = s->at;
    while (s->at < s->end && !pen_is_space(*s->at) && !(*s->at == '\\' && continuation(s, s->at)))
        s->at++;
    return (size_t)(s->at - *word);
}

static const char *scan_digits(const char *at, const char *end, uint64_t *digits)
{
    uint64_t sum = *digits;
    for (; at < end && *at >= '0' && *at <= '9'; at++)
        sum = sum * 10 + (uint64_t)(*at - '0');
    *digits = sum;
    return at;
}

/* Whether the float nearest to d is also the float nearest to a decimal that rounds to d. */
static bool decides_float(double d)
{
    uint64_t bits;
    memcpy(&bits, &d, sizeof bits);
    return (bits & 0x1fffffff) != 0x10000000 && (fabs(d) >= (double)FLT_MIN || d == 0);
}

static bool read_slowly(struct pen_scan *s, const char *end, struct pen_number *out)
{
    char text[NUMBER_BYTES];
    size_t length = (size_t)(end - s->at);
    if (length >= sizeof text)
        return pen_scan_fail(s, PEN_SYNTAX, s->at,
                             "a number of %zu characters; write at most %d digits", length, 17);
    memcpy(text, s->at, length);
    text[length] = '\0';
    *out = (struct pen_number){strtod(text, NULL), strtof(text, NULL)};
    if (!isfinite(out->f))
        return pen_scan_fail(s, PEN_INVALID, s->at,
                             "%s is too large: a coordinate is at most 3.4e38", text);
    s->at = end;
    return true;
}

/* The end of the number, or NULL. */
static const char *scan_number(const struct pen_scan *s, uint64_t *digits, long *count,
                               long *exponent)
{
    const char *at = s->at, *end = s->end, *first, *point;
    at += at < end && (*at == '-' || *at == '+');
    first = at;
    at = scan_digits(at, end, digits);
    *count = at - first;
    *exponent = 0;
    if (at < end && *at == '.') {
        at = scan_digits(point = at + 1, end, digits);
        *count += at - point;
        *exponent = point - at;
    }
    if (*count > 0 && at < end && (*at == 'e' || *at == 'E')) {
        uint64_t power = 0;
        bool down = ++at < end && *at == '-';
        at += at < end && (*at == '-' || *at == '+');
        at = scan_digits(first = at, end, &power);
        if (at == first)
            return NULL;
        if (power > EXPONENT_MAX || at - first > 18)
            *exponent = EXPONENT_MAX;
        else
            *exponent += down ? -(long)power : (long)power;
    }
    bool ends = at == end || pen_is_space(*at) || continuation(s, at);
    return *count > 0 && ends ? at : NULL;
}

bool pen_scan_number(struct pen_scan *s, struct pen_number *out)
{
    uint64_t digits = 0;
    long count, exponent;
    const char *end = scan_number(s, &digits, &count, &exponent);
    if (!end)
        return pen_scan_fail(
            s, PEN_SYNTAX, s->at,
            "found %s where a number is expected; write a finite decimal number like -1.5e3",
            pen_scan_found(s, s->at).text);
    if (count > 19 || digits > UINT64_C(1) << 53 || exponent < -PLACES || exponent > PLACES)
        return read_slowly(s, end, out);
    double d = (double)digits;
    d = exponent < 0 ? d / powers[-exponent] : d * powers[exponent];
    if (!decides_float(d))
        return read_slowly(s, end, out);
    d = *s->at == '-' ? -d : d;
    *out = (struct pen_number){d, (float)d};
    s->at = end;
    return true;
}

/* SPDX-License-Identifier: MIT */
/* The meaning of single header fields and parameters. A malformed field is read in the harmless
 * way: as no match, no range, another type, or a host that is not loopback. */
#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "http/message.h"

bool pen_text_is_plain(const char *text, const char *excluded)
{
    for (const char *at = text; *at; at++) {
        if (((unsigned char)*at < ' ' && *at != '\t') || *at == 127)
            return false;
    }
    return !*excluded || !strpbrk(text, excluded);
}

bool pen_number_parse(const char *text, long low, long high, long *number)
{
    enum { DIGITS = 9 };
    size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > DIGITS || text[digits] != '\0')
        return false;
    long value = 0;
    for (size_t i = 0; i < digits; i++)
        value = 10 * value + (text[i] - '0');
    if (value < low || value > high)
        return false;
    *number = value;
    return true;
}

bool pen_uuid_parse(const char *text, char uuid[PEN_UUID_BYTES])
{
    static const char form[PEN_UUID_BYTES] = "xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx";
    for (size_t i = 0; i < sizeof form; i++) {
        const unsigned char c = (unsigned char)text[i];
        if (form[i] == 'x' ? !isxdigit(c) : c != (unsigned char)form[i])
            return false;
        uuid[i] = (char)tolower(c);
    }
    return true;
}

/* An empty port is allowed by RFC 3986. */
static bool is_port(const char *text)
{
    long port;
    return *text == '\0' ||
           (*text == ':' && (text[1] == '\0' || pen_number_parse(text + 1, 0, 65535, &port)));
}

bool pen_host_is_loopback(const char *host)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    for (size_t i = 0; host && i < sizeof names / sizeof names[0]; i++) {
        size_t length = strlen(names[i]);
        if (strncasecmp(host, names[i], length) == 0 && is_port(host + length))
            return true;
    }
    return false;
}

bool pen_origin_is_host(const char *origin, const char *scheme, const char *host)
{
    const char *authority = strstr(origin, "://");
    const size_t length = authority ? (size_t)(authority - origin) : 0;
    return authority && host && strcasecmp(authority + 3, host) == 0 &&
           (!scheme || (strlen(scheme) == length && strncasecmp(origin, scheme, length) == 0));
}

bool pen_origin_listed(const char *list, const char *origin)
{
    const size_t length = strlen(origin);
    for (size_t n; *list; list += n + (list[n] == ' ')) {
        n = strcspn(list, " ");
        if (n == length && strncasecmp(list, origin, n) == 0)
            return true;
    }
    return false;
}

/* The media type; PEN_MEDIA_OTHER if its parameters name a charset that is not supported. The bytes
 * of an XML document show whether it is in UTF-16. */
static enum pen_media with_charset(enum pen_media media, const char *parameters)
{
    const char *charset = strcasestr(parameters, "charset=");
    if (!charset)
        return media;
    charset += strlen("charset=");
    charset += *charset == '"';
    size_t length = strcspn(charset, "\"; \t");
    if ((length == 5 && strncasecmp(charset, "utf-8", length) == 0) ||
        (length == 8 && strncasecmp(charset, "us-ascii", length) == 0))
        return media;
    bool utf16 = (length == 6 && strncasecmp(charset, "utf-16", length) == 0) ||
                 (length == 8 && strncasecmp(charset, "utf-16le", length) == 0) ||
                 (length == 8 && strncasecmp(charset, "utf-16be", length) == 0);
    return utf16 && media == PEN_MEDIA_XML ? media : PEN_MEDIA_OTHER;
}

enum pen_media pen_media_parse(const char *content_type)
{
    static const struct {
        const char *name;
        enum pen_media media;
    } types[] = {
        {.name = "application/json", .media = PEN_MEDIA_JSON},
        {.name = "application/x-www-form-urlencoded", .media = PEN_MEDIA_NONE}, /* curl's default */
        {.name = "application/xml", .media = PEN_MEDIA_XML},
        {.name = "text/xml", .media = PEN_MEDIA_XML},
    };
    if (!content_type)
        return PEN_MEDIA_NONE;
    size_t length = strcspn(content_type, "; \t");
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (strlen(types[i].name) == length &&
            strncasecmp(content_type, types[i].name, length) == 0)
            return with_charset(types[i].media, content_type + length);
    }
    return PEN_MEDIA_OTHER;
}

bool pen_etag_listed(const char *if_none_match, const char *etag)
{
    const char *at = if_none_match + strspn(if_none_match, " \t");
    if (*at == '*')
        return true;
    if (strncmp(etag, "W/", 2) == 0)
        etag += 2; /* If-None-Match compares weakly (RFC 9110, 13.1.2) */
    size_t length = strlen(etag);
    while (*at) {
        at += strspn(at, " \t,");
        if (strncmp(at, "W/", 2) == 0)
            at += 2;
        const char *close = *at == '"' ? strchr(at + 1, '"') : NULL;
        if (!close)
            return false;
        size_t bytes = (size_t)(close - at) + 1;
        if (bytes == length && memcmp(at, etag, length) == 0)
            return true;
        at = close + 1;
    }
    return false;
}

bool pen_etag_known(const char *if_none_match, const char *etag)
{
    enum { TAG_BYTES = 100 };
    char compressed[TAG_BYTES];
    int length = (int)strlen(etag);
    snprintf(compressed, sizeof compressed, "%.*s" PEN_GZIP_TAG "\"", length > 0 ? length - 1 : 0,
             etag);
    return pen_etag_listed(if_none_match, etag) || pen_etag_listed(if_none_match, compressed);
}

/* How closely a media range of `length` bytes matches a type: 3 exactly, 2 as "main/" and a star, 1
 * as any type, 0 not at all. */
static int range_fits(const char *range, size_t length, const char *type)
{
    size_t slash = strcspn(type, "/");
    if (strlen(type) == length && strncasecmp(range, type, length) == 0)
        return 3;
    if (length == slash + 2 && strncasecmp(range, type, slash + 1) == 0 && range[slash + 1] == '*')
        return 2;
    return length == 3 && memcmp(range, "*/*", 3) == 0;
}

/* The value of the parameter q of a media range: 1 if it is missing, 0 if it is malformed. */
static double quality_of(const char *at, const char *end)
{
    while (at < end) {
        at += strspn(at, "; \t");
        if (at < end && strncasecmp(at, "q=", 2) == 0) {
            double q = isdigit((unsigned char)at[2]) ? strtod(at + 2, NULL) : 0;
            return q <= 1 ? q : 0;
        }
        at += strcspn(at, ";,");
        if (*at == ',')
            break;
    }
    return 1;
}

bool pen_encoding_is_gzip(const char *accept_encoding)
{
    double gzip = -1, any = 0;
    for (const char *at = accept_encoding ? accept_encoding : ""; *at;) {
        at += strspn(at, ", \t");
        const char *end = at + strcspn(at, ",");
        size_t length = strcspn(at, ";, \t");
        if (length == 4 && strncasecmp(at, "gzip", length) == 0)
            gzip = quality_of(at + length, end);
        else if (length == 1 && *at == '*')
            any = quality_of(at + length, end);
        at = end;
    }
    return (gzip < 0 ? any : gzip) > 0;
}

/* The preference for a type: the q of the media range that matches it most closely. */
static double preference_for(const char *accept, const char *type)
{
    double preference = 0;
    int closest = 0;
    for (const char *at = accept; *at;) {
        at += strspn(at, ", \t");
        const char *end = at + strcspn(at, ",");
        size_t length = strcspn(at, ";, \t");
        int fits = range_fits(at, length, type);
        if (fits > closest) {
            closest = fits;
            preference = quality_of(at + length, end);
        }
        at = end;
    }
    return preference;
}

int pen_accept_choose(const char *accept, const char *const *types, int count)
{
    int best = -1;
    double most = 0;
    for (int i = 0; i < count; i++) {
        double preference = accept && *accept ? preference_for(accept, types[i]) : 1;
        if (preference > most) {
            most = preference;
            best = i;
        }
    }
    return best;
}

/* Reads digits. A larger number becomes UINT64_MAX, which also lies beyond any size. */
static bool read_offset(const char **text, uint64_t *value)
{
    const char *at = *text;
    *value = 0;
    for (; isdigit((unsigned char)*at); at++) {
        unsigned digit = (unsigned)(*at - '0');
        *value = *value > (UINT64_MAX - digit) / 10 ? UINT64_MAX : 10 * *value + digit;
    }
    bool any = at != *text;
    *text = at;
    return any;
}

enum pen_range_kind pen_range_parse(const char *range, uint64_t size, uint64_t *first,
                                    uint64_t *count)
{
    if (strncasecmp(range, "bytes=", 6) != 0)
        return PEN_RANGE_WHOLE;
    range += 6;
    uint64_t from, to;
    bool has_from = read_offset(&range, &from);
    if (*range++ != '-')
        return PEN_RANGE_WHOLE;
    bool has_to = read_offset(&range, &to);
    if (*range != '\0' || (!has_from && !has_to) || (has_from && has_to && to < from))
        return PEN_RANGE_WHOLE;
    if (!has_from) { /* the last `to` bytes */
        if (to == 0 || size == 0)
            return PEN_RANGE_OUTSIDE;
        *count = to < size ? to : size;
        *first = size - *count;
        return PEN_RANGE_PART;
    }
    if (from >= size)
        return PEN_RANGE_OUTSIDE;
    *first = from;
    *count = (has_to && to < size ? to + 1 : size) - from;
    return PEN_RANGE_PART;
}

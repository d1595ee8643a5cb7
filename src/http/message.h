/* SPDX-License-Identifier: MIT */
/* The parts of HTTP that need no connection: request targets and the meaning of header fields.
 * These are pure functions over bytes that a client sent, and trust none of them.
 *
 * Invariants: a parsed target holds decoded text without zero bytes; a range that is granted lies
 * inside the representation and is not empty. */
#ifndef PEN_HTTP_MESSAGE_H
#define PEN_HTTP_MESSAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

enum { PEN_SEGMENTS_MAX = 8, PEN_PARAMS_MAX = 16 };

struct pen_param {
    const char *name, *value; /* value is "" if the query has none */
};

/* A parsed and decoded request target. "/" has no segments, "/a/" has "a" and "". */
struct pen_target {
    char *text;            /* owns the bytes to which the other members point */
    const char *authority; /* of a target "http://authority/path"; else NULL */
    int segment_count;     /* may exceed PEN_SEGMENTS_MAX; the array holds the first ones */
    const char *segment[PEN_SEGMENTS_MAX];
    int param_count;
    struct pen_param param[PEN_PARAMS_MAX];
};

/* Parses a request target: the text between method and version in a request line.
 * Owns: the caller releases *target, after success and failure alike.
 * Fails: PEN_SYNTAX (no path, bad percent-encoding), PEN_USAGE (too many parameters),
 * PEN_NO_MEMORY. */
bool pen_target_parse(const char *raw, struct pen_target *target, struct pen_status *st);
void pen_target_release(struct pen_target *target);

/* Whether the path matches a template such as "/v1/jobs/{id}/image". *arg becomes the segment at
 * the place of the braces, or NULL if the template has none. */
bool pen_target_matches(const struct pen_target *target, const char *template, const char **arg);

/* The value of a parameter, or NULL if the query does not have it. */
const char *pen_target_param(const struct pen_target *target, const char *name);

/* Whether text has no control character except tab, and no character of `excluded`. */
bool pen_text_is_plain(const char *text, const char *excluded);

/* Whether text is an integer of one to nine digits, from low to high; stores it in *number. */
bool pen_number_parse(const char *text, long low, long high, long *number);

/* Whether text is a UUID. Writes it in lower case, which names the same UUID. */
enum { PEN_UUID_BYTES = 37 };
bool pen_uuid_parse(const char *text, char uuid[PEN_UUID_BYTES]);

/* Whether a Host names this machine: localhost, 127.0.0.1 or [::1], with or without a port. False
 * for NULL. */
bool pen_host_is_loopback(const char *host);

/* Whether an Origin names the same site as a scheme (NULL: any) and a Host. Then the request comes
 * from a page of the daemon itself. */
bool pen_origin_is_host(const char *origin, const char *scheme, const char *host);

/* Whether an Origin is in a list of origins separated by spaces. */
bool pen_origin_listed(const char *list, const char *origin);

/* The type of a body, from its Content-Type. */
enum pen_media {
    PEN_MEDIA_NONE, /* no type, or curl's default type: the body's first byte decides */
    PEN_MEDIA_JSON,
    PEN_MEDIA_XML,
    PEN_MEDIA_OTHER
};
enum pen_media pen_media_parse(const char *content_type);

/* Whether If-None-Match holds an entity tag equal to etag by weak comparison, or "*".
 * Source: RFC 9110, section 13.1.2. */
bool pen_etag_listed(const char *if_none_match, const char *etag);

/* The text that the entity tag of a compressed representation has before its closing quote. */
#define PEN_GZIP_TAG "-gzip"

/* As pen_etag_listed; the tag of the compressed representation counts as well. */
bool pen_etag_known(const char *if_none_match, const char *etag);

/* Whether an Accept-Encoding field (NULL: not sent) accepts gzip.
 * Source: RFC 9110, section 12.5.3. */
bool pen_encoding_is_gzip(const char *accept_encoding);

/* The index of the media type, among `count` types, that an Accept field prefers. Of equally
 * preferred types, the first; -1 if it accepts none of them. An absent or empty field accepts any
 * type. Parameters other than q are ignored.
 * Source: RFC 9110, section 12.5.1. */
int pen_accept_choose(const char *accept, const char *const *types, int count);

enum pen_range_kind {
    PEN_RANGE_WHOLE, /* no range, several ranges, or another unit: send everything */
    PEN_RANGE_PART,
    PEN_RANGE_OUTSIDE /* 416 */
};

/* The part of `size` bytes that a Range field selects.
 * Source: RFC 9110, section 14.1.2. */
enum pen_range_kind pen_range_parse(const char *range, uint64_t size, uint64_t *first,
                                    uint64_t *count);

#endif

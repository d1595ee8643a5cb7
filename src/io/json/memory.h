/* SPDX-License-Identifier: MIT */
/* Estimates of the memory of JSON values. The parsers of JSON and XML add them up, and stop before
 * a document's values exceed pen_limits.parsed_bytes. They were measured with jansson 2.14 and
 * glibc's malloc: the values of a text of `{},{},…` take 80 times its size. The estimates for an
 * element and a member include the growth of jansson's tables by doubling. */
#ifndef PEN_IO_JSON_MEMORY_H
#define PEN_IO_JSON_MEMORY_H

enum {
    PEN_JSON_OBJECT_BYTES = 224,
    PEN_JSON_MEMBER_BYTES = 112, /* and the length of its key */
    PEN_JSON_ARRAY_BYTES = 128,
    PEN_JSON_ELEMENT_BYTES = 16,
    PEN_JSON_NUMBER_BYTES = 32,
    PEN_JSON_STRING_BYTES = 80 /* and the length of its text */
};

#endif

/* SPDX-License-Identifier: MIT */
/* libcurl, loaded only by commands that talk to a daemon. If it were linked to the program, some
 * thirty libraries would be loaded before anything else runs. That takes longer than reading a
 * scene and preparing it for rendering.
 *
 * PEN_CURL_FUNCTIONS lists the functions used. struct pen_curl has a member for each, without the
 * prefix: curl_easy_init is easy_init. */
#ifndef PEN_CMD_CLIENT_CURL_LIBRARY_H
#define PEN_CMD_CLIENT_CURL_LIBRARY_H

#include <curl/curl.h>
#include <stdbool.h>

#include "base/status.h"

#define PEN_CURL_FUNCTIONS(X)                                                                      \
    X(easy_cleanup)                                                                                \
    X(easy_escape)                                                                                 \
    X(easy_getinfo)                                                                                \
    X(easy_init)                                                                                   \
    X(easy_perform)                                                                                \
    X(easy_setopt)                                                                                 \
    X(easy_strerror)                                                                               \
    X(free)                                                                                        \
    X(global_cleanup)                                                                              \
    X(slist_append)                                                                                \
    X(slist_free_all)                                                                              \
    X(url)                                                                                         \
    X(url_cleanup)                                                                                 \
    X(url_get)                                                                                     \
    X(url_set)

#define PEN_CURL_MEMBER(name) __typeof__(curl_##name) *name;
struct pen_curl {
    PEN_CURL_FUNCTIONS(PEN_CURL_MEMBER)
};
#undef PEN_CURL_MEMBER

/* Loads the library and finds its functions. It stays loaded until the program ends.
 * Fails: PEN_NETWORK (no libcurl, or one of its functions is missing). */
bool pen_curl_load(struct pen_curl *curl, struct pen_status *st);

#endif

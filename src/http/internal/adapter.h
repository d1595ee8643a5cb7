/* SPDX-License-Identifier: MIT */
/* The callbacks that libmicrohttpd makes for each request; cls is the struct pen_http. listener.c
 * registers them.
 *
 * Threads: those of libmicrohttpd. */
#ifndef PEN_HTTP_INTERNAL_ADAPTER_H
#define PEN_HTTP_INTERNAL_ADAPTER_H

#include <microhttpd.h>
#include <stddef.h>

/* The request line was read: makes the request, which becomes *state below. */
void *pen_http_adapter_on_line(void *cls, const char *uri, struct MHD_Connection *connection);

/* Called once when the head is complete, then for each part of the body, then once more without
 * data; and again after the connection was resumed. */
enum MHD_Result pen_http_adapter_on_access(void *cls, struct MHD_Connection *connection,
                                           const char *url, const char *method, const char *version,
                                           const char *data, size_t *bytes, void **state);

/* The request has ended, whether its answer was sent or not: frees it. */
void pen_http_adapter_on_completed(void *cls, struct MHD_Connection *connection, void **state,
                                   enum MHD_RequestTerminationCode why);

#endif

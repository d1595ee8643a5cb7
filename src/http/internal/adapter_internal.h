/* SPDX-License-Identifier: MIT */
/* What the files that may include microhttpd.h share: listener.c (threads and sockets) and
 * adapter.c (requests). */
#ifndef PEN_HTTP_INTERNAL_ADAPTER_INTERNAL_H
#define PEN_HTTP_INTERNAL_ADAPTER_INTERNAL_H

#include <microhttpd.h>
#include <pthread.h>
#include <stdatomic.h>

#include "http/internal/adapter.h"

struct adapter {
    struct pen_http *http;
    struct MHD_Daemon *daemon;
    int listen_fd;
    int stop_fd; /* an eventfd: readable once accepting has to end */
    pthread_t acceptor;
    bool accepting; /* whether the acceptor has to be joined */
    int connection_max;
    atomic_int connections;  /* accepted and not yet closed. atomic: relaxed, a bound */
    pthread_mutex_t parking; /* guards held and woken of all requests */
};

/* The callbacks of requests; cls is the struct pen_http. */
void *pen_http_adapter_on_line(void *cls, const char *uri, struct MHD_Connection *connection);
enum MHD_Result pen_http_adapter_on_access(void *cls, struct MHD_Connection *connection,
                                           const char *url, const char *method, const char *version,
                                           const char *data, size_t *bytes, void **state);
void pen_http_adapter_on_completed(void *cls, struct MHD_Connection *connection, void **state,
                                   enum MHD_RequestTerminationCode why);

#endif

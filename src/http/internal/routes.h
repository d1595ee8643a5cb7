/* SPDX-License-Identifier: MIT */
/* The route table: every method and path that the server answers, with the query parameters and the
 * threads that run the handler. HEAD is answered wherever GET is. */
#ifndef PEN_HTTP_INTERNAL_ROUTES_H
#define PEN_HTTP_INTERNAL_ROUTES_H

#include <stdbool.h>
#include <stddef.h>

#include "access/tokens.h"
#include "base/status.h"
#include "http/message.h"
#include "jobs/jobs.h"

struct request;

/* The result of a handler. */
enum outcome {
    OUTCOME_ANSWERED, /* the reply is complete */
    OUTCOME_WATCHED   /* the watcher has the request, and resumes it later */
};

/* Fills request->reply. `jobs` is NULL if the route has no queue. */
typedef enum outcome route_handler(struct request *request, struct pen_jobs *jobs);

/* Answers from memory if possible, in the thread of the connection. Returns whether it did. */
typedef bool route_quick(struct request *request);

/* The handlers, by file: handle_jobs.c, handle_results.c, streams.c, handle_service.c,
 * handle_metrics.c. */
route_handler pen_http_handle_submit, pen_http_handle_list, pen_http_handle_job,
    pen_http_handle_cancel, pen_http_handle_delete, pen_http_handle_explain;
route_handler pen_http_handle_image, pen_http_handle_preview, pen_http_handle_stats,
    pen_http_handle_scene, pen_http_handle_report, pen_http_handle_compare;
route_handler pen_http_handle_events;
route_handler pen_http_handle_validate, pen_http_handle_file, pen_http_handle_workers,
    pen_http_handle_healthz, pen_http_handle_readyz;
route_handler pen_http_handle_metrics;
route_quick pen_http_quick_job;

/* Where a handler runs. */
enum queue_id {
    QUEUE_NONE,    /* in the thread of the connection: it must not block */
    QUEUE_STORE,   /* on a store thread: reads of the store */
    QUEUE_CHANGES, /* on a thread for changes: writes, which wait for other writers */
    QUEUE_COMPUTE  /* on a compute thread: encoding pictures, writing reports, reading scenes and
                    * checking them, and all requests with a large body */
};

/* The allowed values of a query parameter. The first of these rules that applies:
 *    allowed   one of these words
 *    high      a number from low to high
 *    is_job    the id of a job; this parameter must be given
 *    longest   a text of 1 to `longest` characters */
struct param_rule {
    const char *name;
    const char *const *allowed; /* ends with NULL */
    long low, high;
    bool is_job;
    size_t longest;
};

/* An entry of the route table. */
struct route {
    const char *method, *path;
    enum pen_scope scope; /* the scope that clients need; PEN_SCOPE_NONE: no token */
    route_handler *handle;
    route_quick *quick; /* tried before queueing; NULL: none */
    enum queue_id queue;
    bool takes_body;   /* a scene or a job; otherwise a body is discarded */
    bool submits;      /* refused while draining */
    bool handle_again; /* the handler runs again after its wait; otherwise the answer is the job */
    const struct param_rule *params; /* ends with a NULL name; NULL: none */
};

enum { ALLOW_BYTES = 64 };

/* Finds the route of a request; *arg becomes the path's {id} or {name}.
 * Fails: PEN_NOT_FOUND; PEN_METHOD, and `allow` becomes the list of methods for an Allow field. */
const struct route *pen_http_route_find(const char *method, const struct pen_target *target,
                                        const char **arg, char allow[ALLOW_BYTES],
                                        struct pen_status *st);

/* Checks the query parameters.
 * Fails: PEN_USAGE, with the parameter's name and what is allowed. */
bool pen_http_route_check_params(const struct route *route, const struct pen_target *target,
                                 struct pen_status *st);

/* The queue for a request whose body was received. A stored picture, a view as PNG, needs no
 * compute thread. */
enum queue_id pen_http_route_queue(const struct route *route, const struct request *request);

#endif

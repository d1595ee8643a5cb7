/* SPDX-License-Identifier: MIT */
/* The route table: every method and path the service answers, with the query parameters it takes
 * and the thread it runs on. HEAD is answered wherever GET is. */
#ifndef PEN_HTTP_INTERNAL_ROUTES_H
#define PEN_HTTP_INTERNAL_ROUTES_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "http/message.h"
#include "jobs/jobs.h"

struct request;

enum outcome {
    OUTCOME_ANSWERED, /* the reply is complete */
    OUTCOME_WATCHED   /* the watcher has the request now */
};

/* Fills request->reply. jobs is NULL on the inline lane. */
typedef enum outcome route_handler(struct request *request, struct pen_jobs *jobs);

/* Answers from memory, in the callback, if it can. */
typedef bool route_quick(struct request *request);

enum lane {
    LANE_INLINE, /* in the callback: nothing that blocks */
    LANE_STORE,  /* a store thread */
    LANE_SIDE    /* a side thread: pictures that have to be encoded first */
};

/* A query parameter: one of `allowed`, or else a number if high > 0, or else a text. */
struct param_rule {
    const char *name;
    const char *const *allowed; /* ends with NULL */
    long low, high;
    size_t longest;
};

struct route {
    const char *method, *path;
    route_handler *handle;
    route_quick *quick; /* tried first; NULL: none */
    enum lane lane;
    bool takes_body;                 /* a scene or a job; else a body is read and dropped */
    bool submits;                    /* refused while draining */
    const struct param_rule *params; /* ends with a NULL name; NULL: none */
};

/* Finds the route of a request. Fails: PEN_NOT_FOUND; PEN_METHOD, with the methods in allow. */
enum { ALLOW_BYTES = 64 };
const struct route *pen_http_route_find(const char *method, const struct pen_target *target,
                                        const char **arg, char allow[ALLOW_BYTES],
                                        struct pen_status *st);

/* Fails: PEN_USAGE, naming the parameter and what is allowed. */
bool pen_http_route_check_params(const struct route *route, const struct pen_target *target,
                                 struct pen_status *st);

/* The lane for this request: an image that is stored as asked for needs no side thread. */
enum lane pen_http_route_lane(const struct route *route, const struct pen_target *target);

#endif

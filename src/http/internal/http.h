/* SPDX-License-Identifier: MIT */
/* The server: its parts, and the counters that several of them use. Every request points to the
 * server, and so reaches the executor, the watcher and the streams; their calls are declared in
 * their own headers only. */
#ifndef PEN_HTTP_INTERNAL_HTTP_H
#define PEN_HTTP_INTERNAL_HTTP_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "http/internal/answers.h"
#include "http/server.h"

struct request;

enum { RESERVED_SLOTS = 64 }; /* kept for health and short reads when all connections are at work */

struct pen_http {
    struct pen_limits limits;
    struct listener *listener;
    struct access_log *access_log;
    struct executor *executor;
    struct watch *watch;
    struct snapshot_cache *snapshot_cache;
    struct streams *streams;
    struct static_files *static_files;
    struct pictures *pictures;
    struct trim *trim;

    int connection_max;  /* beyond it new connections replace idle ones */
    atomic_int arriving; /* accepted and not yet with their loops. atomic: relaxed, a bound */
    /* New connections come fast, since and until then (listener.c). atomic: relaxed, they only
     * spare work */
    _Atomic int64_t rush_since_ns, rush_until_ns;
    atomic_int connections;   /* with the loops and not yet closed. atomic: relaxed, a bound */
    atomic_int reserved;      /* connections in reserved slots. atomic: relaxed, a bound */
    atomic_size_t head_bytes; /* heads of requests that are not answered, and what was read
                               * and has to wait. atomic: relaxed, a sum */

    atomic_bool draining, stopping; /* atomic: relaxed, one request more may still be served */
    atomic_int active;              /* requests whose head was seen and that have not ended.
                                     * atomic: relaxed, read only in a loop that waits for 0 */
    atomic_size_t intake_bytes;     /* bodies in memory. atomic: relaxed, a sum */
    atomic_uint request_count;      /* atomic: relaxed, values only have to differ */
    uint32_t id_prefix;             /* distinguishes this process's request ids from others' */

    pthread_mutex_t intake_lock;                /* see intake.h */
    struct request *intake_first, *intake_last; /* guarded by intake_lock: bodies that are being
                                                 * received, the slowest first */
    size_t intake_leaving_bytes;  /* guarded by intake_lock: of bodies that were told to give way */
    size_t intake_complete_bytes; /* guarded by intake_lock: of large bodies that are complete */

    struct answer_memory answers; /* of large answers but pictures, which have their own */

    pthread_mutex_t ready_lock;
    int64_t ready_ns;        /* guarded by ready_lock: when the store was last probed, or took a
                              * job; 0: never */
    bool probing;            /* guarded by ready_lock: a thread is probing it */
    struct pen_status ready; /* guarded by ready_lock: the result */
    char not_ready_reason[PEN_MSG_BYTES]; /* guarded by ready_lock: see pen_http_set_not_ready */
};

#endif

/* SPDX-License-Identifier: MIT */
/* What the parts of the server share. */
#ifndef PEN_HTTP_INTERNAL_HTTP_H
#define PEN_HTTP_INTERNAL_HTTP_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "http/server.h"

struct pen_http {
    struct pen_limits limits;
    struct adapter *adapter;
    struct pool *pool;
    struct watch *watch;
    struct snapshots *snapshots;
    struct streams *streams;
    struct statics *statics;

    atomic_bool draining, stopping; /* atomic: relaxed, a request more or less does not matter */
    atomic_int active;              /* requests whose head was seen and that have not ended.
                                     * atomic: relaxed, only read to wait for quiet */
    atomic_size_t intake_bytes;     /* bodies in memory. atomic: relaxed, a sum */
    atomic_size_t picture_bytes;    /* pictures in memory. atomic: relaxed, a sum */
    atomic_uint request_count;      /* atomic: relaxed, only has to differ */
    uint32_t id_prefix;             /* tells this process's request ids from others' */

    pthread_mutex_t ready_lock;
    int64_t ready_ns;            /* guarded by ready_lock: when the store was probed */
    struct pen_status ready;     /* guarded by ready_lock: what came of it */
    char trouble[PEN_MSG_BYTES]; /* guarded by ready_lock: as pen_http_note said */
};

#endif

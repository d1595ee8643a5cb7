/* SPDX-License-Identifier: MIT */
/* The server: its parts, and the counters that several of them use. Every request points to the
 * server. Each part declares its calls in its own header. */
#ifndef PEN_HTTP_INTERNAL_HTTP_H
#define PEN_HTTP_INTERNAL_HTTP_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "http/server.h"

struct pen_jobs;

struct pen_http {
    struct pen_limits limits;
    struct guard *guard;
    struct listener *listener;
    struct pen_tokens *tokens; /* NULL: everybody may do everything */
    struct pen_tls *tls;       /* NULL: plain HTTP */
    struct executor *executor;
    struct watch *watch;
    struct snapshot_cache *snapshot_cache;
    struct static_files *static_files;
    struct pictures *pictures;
    void (*broken)(void *user, const struct pen_status *why); /* see struct pen_http_options */
    void *broken_user;
    int64_t heartbeat_ns; /* time after which a silent event stream gets a heartbeat */
    char *cors;           /* origins with spaces between them; NULL: none */
    bool has_proxy;
    unsigned char proxy[16]; /* the trusted proxy's address as IPv6 */

    /* The store is open, and executor and watcher exist. atomic: release, after they exist. */
    atomic_bool opened;
    atomic_bool draining, stopping; /* atomic: relaxed, one request more may still be served */
    atomic_int active;              /* requests whose head was seen and that have not ended.
                                     * atomic: relaxed, read only in a loop that waits for 0 */
    atomic_int polls, streams;      /* long polls that wait, open event streams. atomic: relaxed */
    atomic_size_t body_bytes;       /* bodies in memory. atomic: relaxed, a sum */
    atomic_uint request_count;      /* atomic: relaxed, values only have to differ */
    uint32_t id_prefix;             /* distinguishes this process's request ids from others' */

    /* Requests that were refused because of load, and requests that failed. atomic: relaxed, sums
     */
    atomic_uint_least64_t refused_429, refused_503, failed;

    pthread_mutex_t ready_lock;
    /* guarded by ready_lock: time of the last probe of the store, or of the last job that it took;
     * 0: never */
    int64_t ready_ns;
    bool probing;                         /* guarded by ready_lock: a thread is probing it */
    struct pen_status ready;              /* guarded by ready_lock: the result of the probe */
    char not_ready_reason[PEN_MSG_BYTES]; /* guarded by ready_lock: see pen_http_set_not_ready */
    struct pen_status store_fault;        /* guarded by ready_lock: why the store is not open */
};

/* Reports an I/O error of the store that belongs to the handle. */
void pen_http_check_store(struct pen_http *http, struct pen_jobs *jobs);

#endif

/* SPDX-License-Identifier: MIT */
#include "http/internal/intake.h"

#include "http/internal/conn.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/request.h"

/* All bodies in memory together. EXTRA_BYTES is the most beyond it while others give way, which
 * takes their loops a moment. Small bodies may be kept in a reserve beyond both. */
enum {
    INTAKE_BYTES = 256 << 20,
    EXTRA_BYTES = 64 << 20,
    RESERVE_BYTES = 32 << 20,
    COMPLETE_BYTES = INTAKE_BYTES / 2 /* of large bodies that are complete */
};

/* A body whose window has not ended for so long gives way. */
static const int64_t slow_ns = INT64_C(1000000000);

/* Puts a body to the end of the list. Called with the lock held. */
static void enlist(struct request *request)
{
    struct pen_http *http = request->http;
    struct intake_place *place = &request->intake;
    place->listed = true;
    place->since_ns = request->conn->loop->now_ns;
    place->faster = NULL;
    place->slower = http->intake_last;
    *(place->slower ? &place->slower->intake.faster : &http->intake_first) = request;
    http->intake_last = request;
}

/* Called with the lock held. */
static void unlist(struct request *request)
{
    struct pen_http *http = request->http;
    struct intake_place *place = &request->intake;
    *(place->slower ? &place->slower->intake.faster : &http->intake_first) = place->faster;
    *(place->faster ? &place->faster->intake.slower : &http->intake_last) = place->slower;
    place->listed = false;
}

/* Whether a body is small, as far as it has come with `bytes` more, and as far as it tells. */
static bool is_small(const struct request *request, size_t bytes)
{
    return request->intake.bytes + bytes <= INTAKE_SMALL && request->declared_bytes <= INTAKE_SMALL;
}

/* Whether `bytes` more of a body fit. Called with the lock held. */
static bool fits(const struct request *request, size_t bytes)
{
    const struct pen_http *http = request->http;
    const size_t reserve = is_small(request, bytes) ? RESERVE_BYTES : 0,
                 all = atomic_load_explicit(&http->intake_bytes, memory_order_relaxed) + bytes;
    return all <= INTAKE_BYTES + reserve + http->intake_leaving_bytes &&
           all <= INTAKE_BYTES + reserve + EXTRA_BYTES;
}

/* Makes room for `bytes` more of a body. Called with the lock held. */
static bool make_room(const struct request *request, size_t bytes)
{
    struct pen_http *http = request->http;
    const int64_t now_ns = request->conn->loop->now_ns;
    while (!fits(request, bytes)) {
        struct request *slowest = http->intake_first;
        if (slowest == request)
            slowest = slowest->intake.faster;
        if (!slowest || now_ns - slowest->intake.since_ns < slow_ns)
            return false;
        unlist(slowest);
        slowest->intake.gives_way = true;
        http->intake_leaving_bytes += slowest->intake.bytes;
        pen_http_resume(slowest);
    }
    return true;
}

bool pen_http_intake_keep(struct request *request, const void *data, size_t bytes)
{
    struct pen_http *http = request->http;
    struct intake_place *place = &request->intake;
    pthread_mutex_lock(&http->intake_lock);
    bool kept = !place->gives_way && make_room(request, bytes);
    if (kept && !place->entered)
        enlist(request);
    if (kept) {
        place->entered = true;
        place->bytes += bytes;
        atomic_fetch_add_explicit(&http->intake_bytes, bytes, memory_order_relaxed);
    }
    pthread_mutex_unlock(&http->intake_lock);
    if (!kept || pen_buf_add(&request->body, data, bytes))
        return kept;
    atomic_fetch_sub_explicit(&http->intake_bytes, bytes, memory_order_relaxed);
    return false;
}

void pen_http_intake_begin_window(struct request *request)
{
    if (!request->intake.entered)
        return;
    pthread_mutex_lock(&request->http->intake_lock);
    if (request->intake.listed) {
        unlist(request);
        enlist(request);
    }
    pthread_mutex_unlock(&request->http->intake_lock);
}

/* Called with the lock held. */
static void leave(struct request *request)
{
    struct pen_http *http = request->http;
    struct intake_place *place = &request->intake;
    if (place->listed)
        unlist(request);
    if (place->gives_way)
        http->intake_leaving_bytes -= place->bytes;
    if (place->complete)
        http->intake_complete_bytes -= place->bytes;
    place->gives_way = place->complete = false;
}

bool pen_http_intake_complete(struct request *request)
{
    struct pen_http *http = request->http;
    struct intake_place *place = &request->intake;
    if (!place->entered)
        return true;
    pthread_mutex_lock(&http->intake_lock);
    const bool gives_way = place->gives_way;
    const bool has_room = place->bytes <= INTAKE_SMALL ||
                          http->intake_complete_bytes + place->bytes <= COMPLETE_BYTES;
    leave(request);
    place->complete = !gives_way && has_room && place->bytes > INTAKE_SMALL;
    if (place->complete)
        http->intake_complete_bytes += place->bytes;
    pthread_mutex_unlock(&http->intake_lock);
    return !gives_way && has_room;
}

void pen_http_intake_leave(struct request *request)
{
    if (!request->intake.entered)
        return;
    pthread_mutex_lock(&request->http->intake_lock);
    leave(request);
    request->intake.entered = false;
    pthread_mutex_unlock(&request->http->intake_lock);
}

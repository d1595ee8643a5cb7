/* SPDX-License-Identifier: MIT */
/* The way of a request through its phases (see request.h). */
#include "http/internal/exchange.h"

#include <string.h>

#include "base/clock.h"
#include "http/internal/access_log.h"
#include "http/internal/admit.h"
#include "http/internal/conn.h"
#include "http/internal/encoding.h"
#include "http/internal/executor.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "http/internal/streams.h"
#include "http/internal/watch.h"

/* A slot that is kept when all others are taken is for a request that is answered at once. */
static void check_slot(struct request *request)
{
    struct pen_status st;
    request->at_once = request->conn->reserved;
    if (request->phase != PHASE_BODY || !request->at_once || request->route->is_short)
        return;
    pen_fail(&st, PEN_UNAVAILABLE, "there are too many connections; try again later");
    pen_http_request_fail(request, &st);
    request->phase = PHASE_ANSWERED;
    request->close = true;
}

/* Notes the client's address: the connection's, or the one for which the trusted proxy sends. A
 * client that the proxy names in vain is one of all such clients. */
static void name_client(struct request *request, const struct pen_address_key *peer)
{
    struct pen_address_key named;
    const char *forwarded_for = peer->is_proxy ? request->fields.forwarded_for : NULL;
    const bool is_named = forwarded_for && pen_http_address_forwarded(forwarded_for, &named);
    request->client = is_named ? named : *peer;
    request->client_is_shared = peer->exempt && !forwarded_for;
}

struct request *pen_http_exchange_begin(struct conn *conn, const char *head, size_t bytes)
{
    struct pen_http *http = conn->loop->http;
    struct request *request = pen_http_request_new(http, head, bytes);
    if (!request)
        return NULL;
    request->conn = conn;
    name_client(request, &conn->address);
    atomic_fetch_add_explicit(&http->active, 1, memory_order_relaxed);
    pen_http_request_admit(request);
    check_slot(request);
    return request;
}

void pen_http_exchange_dispatch(struct request *request)
{
    const struct route *route = request->route;
    enum queue_id id = pen_http_route_queue(route, request);
    request->phase = PHASE_ANSWERED;
    bool answered = route->quick && route->quick(request);
    if (!answered && id == QUEUE_NONE)
        answered = route->handle(request, NULL) == OUTCOME_ANSWERED;
    const enum queue_id encodes =
        answered ? pen_http_executor_encodes(request, QUEUE_NONE) : QUEUE_NONE;
    if (answered && encodes == QUEUE_NONE) {
        pen_http_request_encode(request);
        return;
    }
    request->phase = PHASE_WORK;
    request->is_handled = answered;
    struct executor *executor = request->http->executor;
    if (pen_http_executor_submit(executor, answered ? encodes : id, !answered, request))
        return;
    if (!answered)
        pen_http_executor_refuse(executor, request);
    request->phase = PHASE_ANSWERED;
}

bool pen_http_exchange_abandon(struct request *request)
{
    return pen_http_watch_abandon(request->http->watch, request);
}

bool pen_http_exchange_probes(struct request *request)
{
    const bool probes =
        pen_http_request_only_answers(request) && request->minor > 0 && !request->is_probed;
    request->is_probed = request->is_probed || probes;
    return probes;
}

void pen_http_exchange_end(struct request *request, bool complete)
{
    struct pen_http *http = request->http;
    uint64_t streamed = 0;
    if (request->stream) {
        streamed = pen_http_stream_close(request->stream);
        pen_http_watch_remove_stream(http->watch, &request->conn->address);
    }
    pen_http_access_log_add(http->access_log, request, streamed, complete);
    pen_http_request_free(request);
    atomic_fetch_sub_explicit(&http->active, 1, memory_order_relaxed);
}

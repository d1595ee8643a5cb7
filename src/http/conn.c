/* SPDX-License-Identifier: MIT */
/* The states of a connection, and reading requests from it. */
#include "http/internal/conn.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "http/internal/admit.h"
#include "http/internal/answers.h"
#include "http/internal/exchange.h"
#include "http/internal/http.h"
#include "http/internal/intake.h"
#include "http/internal/loop.h"
#include "http/internal/request.h"

enum {
    STEPS_AT_ONCE = 32,   /* before other connections get their turn */
    SMALL_BYTES = 4 << 10 /* of a head: always kept; more of it up to heads_max only */
};
static const size_t heads_max = (size_t)48 << 20; /* heads, and bytes that are kept unread */
static const int64_t linger_max_ns = 10 * INT64_C(1000000000);

/* Keeps the bytes that were not read, while other connections use the loop's buffer. Returns false
 * when there is no memory for them. */
static bool keep_unread(struct conn *conn)
{
    struct pen_buf *kept = &conn->kept;
    atomic_size_t *total = &conn->loop->http->head_bytes;
    bool in_kept = kept->data && conn->data == (const char *)kept->data;
    if (conn->bytes > 0 && in_kept && conn->bytes == kept->bytes)
        return true;
    struct pen_buf rest = {0};
    if (conn->bytes > 0 && !pen_buf_add(&rest, conn->data, conn->bytes))
        return false;
    if (kept->data || rest.data) {
        atomic_fetch_add_explicit(total, rest.capacity - kept->capacity, memory_order_relaxed);
        pen_buf_release(kept);
        *kept = rest;
    }
    conn->data = (const char *)kept->data;
    return true;
}

/* Whether there is no memory for so much of what a client has sent. */
static bool is_much(const struct conn *conn, size_t bytes)
{
    return bytes > SMALL_BYTES &&
           atomic_load_explicit(&conn->loop->http->head_bytes, memory_order_relaxed) > heads_max;
}

bool pen_http_conn_holds_much(const struct conn *conn)
{
    return is_much(conn, conn->bytes);
}

/* Notes what the kernel said about a read. Returns whether bytes came. */
static bool note_read(struct conn *conn, ssize_t got, size_t wanted)
{
    if (got < 0 && errno != EAGAIN && errno != EINTR)
        conn->reset = true;
    if (got == 0)
        conn->half_closed = true;
    /* With fewer bytes than wanted there are no more: an edge-triggered epoll reports the next. */
    conn->readable = got > 0 && ((size_t)got == wanted || conn->half_closed);
    return got > 0;
}

/* Receives more bytes, behind those that were not read. Returns whether there are new ones. */
static bool receive(struct conn *conn)
{
    char *buffer = conn->loop->buffer;
    if (!conn->readable)
        return false;
    if (conn->bytes > 0 && !keep_unread(conn)) {
        conn->reset = true;
        return false;
    }
    ssize_t got = recv(conn->fd, buffer, LOOP_BYTES, 0);
    if (!note_read(conn, got, LOOP_BYTES))
        return false;
    if (conn->bytes == 0) {
        conn->data = buffer;
        conn->bytes = (size_t)got;
        return true;
    }
    size_t before = conn->kept.capacity;
    bool added = pen_buf_add(&conn->kept, buffer, (size_t)got);
    atomic_fetch_add_explicit(&conn->loop->http->head_bytes, conn->kept.capacity - before,
                              memory_order_relaxed);
    conn->data = (const char *)conn->kept.data;
    conn->bytes = conn->kept.bytes;
    conn->reset = conn->reset || !added;
    return added;
}

static void consume(struct conn *conn, size_t bytes)
{
    conn->data += bytes;
    conn->bytes -= bytes;
}

void pen_http_conn_end_request(struct conn *conn, bool complete)
{
    struct request *request = conn->request;
    conn->request = NULL;
    if (!request)
        return;
    pen_http_answers_leave(request);
    pen_http_exchange_end(request, complete);
}

void pen_http_conn_close(struct conn *conn)
{
    if (conn->fd >= 0)
        close(conn->fd);
    conn->fd = -1;
    conn->bytes = 0;
    keep_unread(conn);
    pen_buf_release(&conn->out);
    if (conn->state == CONN_WORK)
        atomic_store_explicit(&conn->request->unwanted, true, memory_order_relaxed);
    if (conn->state == CONN_WORK && !pen_http_exchange_abandon(conn->request)) {
        conn->state = CONN_ORPHAN;
        pen_http_loop_wait(conn, WAIT_WORK);
        return;
    }
    pen_http_conn_end_request(conn, false);
    conn->state = CONN_DEAD;
    pen_http_loop_remove(conn);
}

/* Answers with an error of HTTP itself, for which no whole head was read, and closes. */
static enum conn_step refuse(struct conn *conn, int http_status, const char *why)
{
    struct pen_status st;
    conn->all_came = false;
    conn->request = pen_http_exchange_begin(conn, NULL, 0);
    if (!conn->request)
        return STEP_END;
    pen_fail(&st, http_status == 503 ? PEN_UNAVAILABLE : PEN_SYNTAX, "%s", why);
    pen_http_request_refuse(conn->request, http_status, &st);
    pen_http_conn_answer(conn);
    return STEP_ON;
}

/* Answers in the middle of a body with an error, and closes. */
static void refuse_rest(struct conn *conn, int http_status, const struct pen_status *st)
{
    pen_http_request_drop_body(conn->request);
    pen_http_request_refuse(conn->request, http_status, st);
    pen_http_conn_answer(conn);
}

/* The memory of this body was promised to another (intake.h). */
static void give_way(struct conn *conn)
{
    struct pen_status st;
    pen_fail(&st, PEN_UNAVAILABLE,
             "there is no memory for this body beside others now; try again later");
    conn->request->route = NULL; /* a refusal: the client has provoked it, see log_access */
    refuse_rest(conn, 503, &st);
}

/* What a client has sent behind a request is kept until that is answered, as far as there is memory
 * for it; otherwise nothing that follows is answered. */
static void limit_rest(struct conn *conn)
{
    if (!pen_http_conn_holds_much(conn))
        return;
    conn->request->close = true;
    conn->bytes = 0;
}

/* The whole body was read, or is not wanted. */
static void end_body(struct conn *conn)
{
    struct request *request = conn->request;
    if (!pen_http_intake_complete(request)) {
        give_way(conn);
        return;
    }
    conn->all_came = conn->bytes == 0;
    limit_rest(conn);
    if (request->phase == PHASE_BODY) {
        conn->state = CONN_WORK;
        pen_http_exchange_dispatch(request);
    } else {
        request->phase = PHASE_ANSWERED;
    }
    if (request->phase == PHASE_ANSWERED)
        pen_http_conn_answer(conn);
    else
        pen_http_loop_wait(conn, WAIT_WORK);
}

static void go_on(struct conn *conn)
{
    static const char text[] = "HTTP/1.1 100 Continue\r\n\r\n";
    if (send(conn->fd, text, sizeof text - 1, MSG_NOSIGNAL) != (ssize_t)sizeof text - 1)
        conn->reset = true;
}

/* Asks a client that waits for it to send the body. */
static void ask_for_body(struct conn *conn)
{
    if (conn->bytes == 0 && pen_http_request_waits(conn->request))
        go_on(conn);
}

/* A head has arrived. */
static enum conn_step begin_request(struct conn *conn, size_t head_bytes)
{
    struct request *request = pen_http_exchange_begin(conn, conn->data, head_bytes);
    const bool announces = pen_head_announces_body(conn->data, head_bytes);
    conn->request = request;
    consume(conn, head_bytes);
    conn->all_came = !announces && conn->bytes == 0;
    if (!request)
        return STEP_END;
    bool has_body = request->declared_bytes > 0 || request->fields.transfer_encoding;
    if (request->phase == PHASE_ANSWERED) {
        request->close = request->close || has_body;
        pen_http_conn_answer(conn);
    } else if (!has_body) {
        end_body(conn);
    } else {
        conn->state = CONN_BODY;
        conn->chunks = (struct pen_chunks){0};
        conn->scan = (struct pen_head_scan){.begun = true};
        conn->window_bytes = 0;
        pen_http_loop_wait(conn, WAIT_BODY);
        ask_for_body(conn);
    }
    return STEP_ON;
}

/* Receives a head or trailer of at most `max` bytes, as far as it has come. */
static enum pen_head_found receive_fields(struct conn *conn, size_t max, size_t *bytes)
{
    enum pen_head_found found = PEN_HEAD_PART;
    do {
        if (conn->bytes > 0)
            found = pen_head_find(conn->data, conn->bytes, &conn->scan, bytes);
    } while (found == PEN_HEAD_PART && conn->bytes <= max && receive(conn));
    return found;
}

static enum conn_step read_head(struct conn *conn)
{
    size_t head_bytes;
    bool was_empty = conn->bytes == 0;
    enum pen_head_found found = receive_fields(conn, PEN_HEAD_BYTES, &head_bytes);
    if (conn->reset || (found == PEN_HEAD_PART && conn->half_closed))
        return STEP_END;
    if (found == PEN_HEAD_BAD)
        return refuse(conn, 400, "malformed HTTP: a line of the head does not end in CR and LF");
    const bool whole = found == PEN_HEAD_WHOLE;
    if ((whole ? head_bytes : conn->bytes) > PEN_HEAD_BYTES)
        return refuse(conn, 431, "the head of the request is longer than 32768 bytes");
    if (whole && !is_much(conn, head_bytes))
        return begin_request(conn, head_bytes);
    if (whole || pen_http_conn_holds_much(conn))
        return refuse(conn, 503, "there is no memory for this head now; try again later");
    if (conn->used && was_empty && conn->bytes > 0)
        pen_http_loop_wait(conn, WAIT_HEAD);
    return STEP_WAIT;
}

/* Gives bytes to the request. Returns whether the body may go on. */
static bool give(struct conn *conn, const char *data, size_t bytes)
{
    return bytes == 0 || pen_http_request_receive(conn->request, data, bytes);
}

/* Reads what has arrived of the chunks of a body. Returns false if the request is over. */
static bool read_chunks(struct conn *conn)
{
    struct request *request = conn->request;
    while (conn->bytes > 0 && conn->chunks.state != PEN_CHUNKS_TRAILER) {
        const char *data;
        size_t bytes;
        ptrdiff_t used = pen_chunks_read(&conn->chunks, conn->data, conn->bytes, &data, &bytes);
        if (used < 0) {
            struct pen_status st;
            pen_fail(&st, PEN_SYNTAX,
                     "malformed HTTP: the body is not in chunks as RFC 9112 has "
                     "them");
            pen_http_request_refuse(request, 400, &st);
            return false;
        }
        bool goes_on = give(conn, data, bytes);
        consume(conn, (size_t)used);
        if (!goes_on)
            return false;
    }
    return true;
}

/* Checks what was found of a trailer. Returns 0, or the status to answer with. */
static int check_trailer(const struct conn *conn, enum pen_head_found found, size_t bytes,
                         struct pen_status *st)
{
    if (found == PEN_HEAD_BAD) {
        pen_fail(st, PEN_SYNTAX, "malformed HTTP: a line of the trailer does not end in CR and LF");
        return 400;
    }
    if ((found == PEN_HEAD_WHOLE ? bytes : conn->bytes) > PEN_TRAILER_BYTES) {
        pen_fail(st, PEN_SYNTAX, "the trailer is longer than %d bytes", PEN_TRAILER_BYTES);
        return 431;
    }
    if (found == PEN_HEAD_WHOLE)
        return pen_trailer_check(conn->data, bytes, st);
    if (!pen_http_conn_holds_much(conn))
        return 0;
    pen_fail(st, PEN_UNAVAILABLE, "there is no memory for this trailer now; try again later");
    return 503;
}

/* Reads what follows the chunks of a body. */
static enum conn_step read_trailer(struct conn *conn)
{
    struct pen_status st;
    size_t bytes = 0;
    enum pen_head_found found = receive_fields(conn, PEN_TRAILER_BYTES, &bytes);
    if (conn->reset || (found == PEN_HEAD_PART && conn->half_closed))
        return STEP_END;
    int refused = check_trailer(conn, found, bytes, &st);
    if (refused) {
        refuse_rest(conn, refused, &st);
    } else if (found == PEN_HEAD_PART) {
        return STEP_WAIT;
    } else {
        consume(conn, bytes);
        end_body(conn);
    }
    return STEP_ON;
}

static bool read_plain(struct conn *conn, bool *complete)
{
    struct request *request = conn->request;
    uint64_t left = request->declared_bytes - request->received_bytes;
    size_t part = left < conn->bytes ? (size_t)left : conn->bytes;
    bool goes_on = give(conn, conn->data, part);
    consume(conn, part);
    *complete = request->received_bytes == request->declared_bytes;
    return goes_on;
}

/* Begins a new window of the body if the bytes of this one have come. */
static void count_window(struct conn *conn)
{
    const struct loop *loop = conn->loop;
    const uint64_t received = conn->request->received_bytes;
    if (received - conn->window_bytes <
        (uint64_t)BODY_RATE * (uint64_t)loop->times.body_ns / 1000000000)
        return;
    conn->window_bytes = received;
    pen_http_loop_wait(conn, WAIT_BODY);
    pen_http_intake_begin_window(conn->request);
}

static enum conn_step read_body(struct conn *conn)
{
    struct request *request = conn->request;
    bool complete = false;
    bool chunked = request->fields.transfer_encoding != NULL;
    if (chunked && conn->chunks.state == PEN_CHUNKS_TRAILER)
        return read_trailer(conn);
    if (conn->bytes == 0 && !receive(conn))
        return conn->reset || conn->half_closed ? STEP_END : STEP_WAIT;
    if (!(chunked ? read_chunks(conn) : read_plain(conn, &complete))) {
        request->close = true;
        pen_http_conn_answer(conn);
    } else if (complete) {
        end_body(conn);
    } else {
        count_window(conn);
    }
    return STEP_ON;
}

/* Drops what the client still sends. */
static enum conn_step drop_input(struct conn *conn)
{
    conn->bytes = 0;
    if (!conn->readable)
        return conn->reset || conn->half_closed ? STEP_END : STEP_WAIT;
    ssize_t got = recv(conn->fd, conn->loop->buffer, LOOP_BYTES, MSG_TRUNC); /* without copying */
    conn->dropped += note_read(conn, got, LOOP_BYTES) ? (size_t)got : 0;
    if (conn->loop->now_ns - conn->begun_ns > linger_max_ns ||
        conn->dropped > 2 * conn->loop->http->limits.body_bytes)
        return STEP_END;
    pen_http_loop_wait(conn, WAIT_LINGER);
    if (got > 0)
        return STEP_ON; /* closing with unread bytes would reset the connection behind the answer */
    return conn->reset || conn->half_closed ? STEP_END : STEP_WAIT;
}

void pen_http_conn_linger(struct conn *conn)
{
    conn->dropped = 0;
    conn->begun_ns = conn->loop->now_ns;
    pen_http_loop_wait(conn, WAIT_LINGER);
}

/* Another thread has the request: only a client that has gone matters. */
static enum conn_step watch_client(struct conn *conn)
{
    if (conn->reset)
        return STEP_END;
    if (!conn->half_closed)
        return STEP_WAIT;
    if (!pen_http_exchange_abandon(conn->request)) {
        if (pen_http_exchange_probes(conn->request))
            go_on(conn);
        return STEP_WAIT;
    }
    conn->state = CONN_HEAD; /* the request is the loop's again */
    return STEP_END;
}

static enum conn_step take_step(struct conn *conn)
{
    switch (conn->state) {
    case CONN_HEAD:
        return read_head(conn);
    case CONN_BODY:
        return read_body(conn);
    case CONN_WORK:
        return watch_client(conn);
    case CONN_SEND:
        return pen_http_conn_send(conn);
    case CONN_STREAM:
        return pen_http_conn_send_stream(conn);
    case CONN_LINGER:
        return drop_input(conn);
    case CONN_ORPHAN:
    case CONN_DEAD:
        break;
    }
    return STEP_WAIT;
}

void pen_http_conn_run(struct conn *conn)
{
    enum conn_step step = STEP_ON;
    for (int i = 0; i < STEPS_AT_ONCE && step == STEP_ON; i++)
        step = take_step(conn);
    if (conn->state == CONN_SEND || conn->state == CONN_STREAM) /* its client keeps it waiting */
        pen_http_request_drop_head(conn->request);
    if (step == STEP_END || !keep_unread(conn) || !pen_http_loop_watch(conn))
        pen_http_conn_close(conn);
    else if (step == STEP_ON)
        pen_http_loop_again(conn);
}

void pen_http_conn_resume(struct conn *conn)
{
    conn->wakened = false;
    const bool unwanted =
        conn->request && atomic_load_explicit(&conn->request->unwanted, memory_order_relaxed);
    if (conn->state == CONN_WORK && !unwanted) {
        conn->request->phase = PHASE_ANSWERED;
        pen_http_conn_answer(conn);
    } else if (conn->state == CONN_WORK || conn->state == CONN_ORPHAN) {
        conn->state = CONN_HEAD;
        pen_http_conn_close(conn);
        return;
    } else if (conn->state == CONN_BODY && conn->request->phase == PHASE_BODY) {
        give_way(conn);
    } else if (conn->state == CONN_SEND && pen_http_answers_gives_way(conn->request)) {
        pen_http_conn_close(conn);
        return;
    }
    pen_http_conn_run(conn);
}

void pen_http_conn_expire(struct conn *conn)
{
    if (conn->wait == WAIT_BODY) {
        struct pen_status st;
        pen_fail(&st, PEN_UNAVAILABLE,
                 "the body comes too slowly: %d bytes per second are the least, in any %d s",
                 BODY_RATE, (int)(conn->loop->times.body_ns / 1000000000));
        refuse_rest(conn, 408, &st);
        pen_http_conn_run(conn);
    } else if (conn->wait == WAIT_HEAD && conn->bytes > 0) {
        if (refuse(conn, 408, "the head of the request comes too slowly") == STEP_ON)
            pen_http_conn_run(conn);
        else
            pen_http_conn_close(conn);
    } else if (conn->wait != WAIT_READER || !pen_http_conn_begin_window(conn)) {
        pen_http_conn_close(conn);
    }
}

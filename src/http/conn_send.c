/* SPDX-License-Identifier: MIT */
/* Sending answers and event streams. */
#include <errno.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "http/internal/answers.h"
#include "http/internal/conn.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/request.h"
#include "http/internal/streams.h"
#include "http/internal/watch.h"

enum {
    BODY_BYTES = 128 << 10,  /* of a body, sent at once */
    STREAM_BYTES = 16 << 10, /* of a stream, sent at once */
    SMALL_BYTES = 16 << 10,  /* of a body: the kernel sends it without being waited for */
    HEAD_BYTES = 500,        /* of an answer, mostly */
    PIECE_BYTES = 2 << 10,   /* of an answer, sent as one piece */
    UNANSWERED_MS = 15000    /* after which the client of a stream has vanished */
};

/* The reason phrases of the statuses that the server sends. */
static const char *reason_of(int status)
{
    static const struct {
        int status;
        const char *text;
    } reasons[] = {{200, "OK"},
                   {202, "Accepted"},
                   {204, "No Content"},
                   {206, "Partial Content"},
                   {304, "Not Modified"},
                   {400, "Bad Request"},
                   {403, "Forbidden"},
                   {404, "Not Found"},
                   {405, "Method Not Allowed"},
                   {406, "Not Acceptable"},
                   {408, "Request Timeout"},
                   {409, "Conflict"},
                   {410, "Gone"},
                   {411, "Length Required"},
                   {413, "Content Too Large"},
                   {415, "Unsupported Media Type"},
                   {416, "Range Not Satisfiable"},
                   {422, "Unprocessable Content"},
                   {429, "Too Many Requests"},
                   {431, "Request Header Fields Too Large"},
                   {500, "Internal Server Error"},
                   {503, "Service Unavailable"},
                   {504, "Gateway Timeout"},
                   {505, "HTTP Version Not Supported"},
                   {507, "Insufficient Storage"}};
    for (size_t i = 0; i < sizeof reasons / sizeof reasons[0]; i++) {
        if (reasons[i].status == status)
            return reasons[i].text;
    }
    return "Status";
}

/* Whether the connection stays open after this answer. */
static bool is_kept(const struct conn *conn)
{
    const struct request *request = conn->request;
    const char *options = request->fields.connection ? request->fields.connection : "";
    const bool refused = !conn->used && request->reply.status >= 400;
    if (request->close || conn->reserved || (refused && pen_http_loop_closes_refused(conn->loop)) ||
        atomic_load_explicit(&request->http->stopping, memory_order_relaxed))
        return false;
    return request->minor > 0 ? !pen_list_has_token(options, "close")
                              : pen_list_has_token(options, "keep-alive");
}

/* Whether the answer has a body that is sent. */
static bool has_body(const struct request *request)
{
    const struct reply *reply = &request->reply;
    return !request->head && reply->status != 204 && reply->status != 304;
}

static void write_field(struct pen_buf *out, const char *name, const char *value)
{
    pen_buf_puts(out, name);
    pen_buf_puts(out, ": ");
    pen_buf_puts(out, value);
    pen_buf_puts(out, "\r\n");
}

static void write_head(struct conn *conn)
{
    const struct request *request = conn->request;
    const struct reply *reply = &request->reply;
    struct pen_buf *out = &conn->out;
    pen_buf_reserve(out, HEAD_BYTES);
    pen_buf_puts(out, "HTTP/1.1 ");
    pen_buf_number(out, (uint64_t)reply->status);
    pen_buf_puts(out, " ");
    pen_buf_puts(out, reason_of(reply->status));
    pen_buf_puts(out, "\r\n");
    write_field(out, "Date", pen_http_loop_date(conn->loop));
    for (int i = 0; !reply->failed && i < reply->field_count; i++)
        write_field(out, reply->field[i].name, reply->field[i].value);
    write_field(out, "X-Request-Id", request->id);
    write_field(out, "X-Content-Type-Options", "nosniff");
    if (request->close)
        write_field(out, "Connection", "close");
    else if (request->minor == 0)
        write_field(out, "Connection", "keep-alive");
    if (reply->streaming && !reply->failed) {
        pen_buf_puts(out, request->minor > 0 ? "Transfer-Encoding: chunked\r\n" : "");
    } else if (reply->status != 204) {
        pen_buf_puts(out, "Content-Length: ");
        pen_buf_number(out, reply->failed ? 0 : reply->bytes);
        pen_buf_puts(out, "\r\n");
    }
    pen_buf_puts(out, "\r\n");
}

/* Lets the kernel find out that the client of a stream has vanished: the next event, or a
 * heartbeat, is not acknowledged for so long (0: as long as the kernel does by itself). Other
 * answers go without, also those that follow a stream: the kernel would also end a connection whose
 * client reads slowly, and so closes its window again and again. */
static void limit_acknowledgements(const struct conn *conn, int ms)
{
    setsockopt(conn->fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &ms, sizeof ms);
}

void pen_http_conn_answer(struct conn *conn)
{
    struct request *request = conn->request;
    struct reply *reply = &request->reply;
    if (reply->failed || reply->status == 0) {
        reply->failed = true;
        reply->status = 503;
    }
    bool streams = reply->streaming && !reply->failed && has_body(request);
    request->close =
        !is_kept(conn) || (streams && request->minor == 0) || pen_http_conn_holds_much(conn);
    if (request->close)
        conn->bytes = 0; /* nothing that follows is answered */
    pen_buf_release(&conn->out);
    write_head(conn);
    conn->out_sent = conn->body_sent = 0;
    conn->windowed = false;
    conn->stream_over = false;
    conn->state = streams ? CONN_STREAM : CONN_SEND;
    if (streams)
        limit_acknowledgements(conn, UNANSWERED_MS);
    pen_http_loop_wait(conn, WAIT_READER);
    conn->reset = conn->reset || conn->out.failed;
}

/* Gives both to the kernel, which takes small ones faster as one piece. As sendmsg. */
static ssize_t send_both(int fd, const struct iovec parts[2], int flags)
{
    char piece[PIECE_BYTES];
    const size_t first = parts[0].iov_len, second = parts[1].iov_len;
    const struct msghdr message = {.msg_iov = (struct iovec *)parts, .msg_iovlen = 2};
    if (first == 0 || second == 0 || first + second > sizeof piece)
        return sendmsg(fd, &message, flags);
    memcpy(piece, parts[0].iov_base, first);
    memcpy(piece + first, parts[1].iov_base, second);
    return send(fd, piece, first + second, flags);
}

/* Sends what is left of `out`, and then of a body; `ends`: the end of the connection follows, in
 * the same packet. Returns whether something was sent. */
static bool send_parts(struct conn *conn, const unsigned char *body, size_t body_bytes, bool ends)
{
    const struct iovec parts[2] = {
        {.iov_base = conn->out.data ? conn->out.data + conn->out_sent : NULL,
         .iov_len = conn->out.bytes - conn->out_sent},
        {.iov_base = (void *)body, .iov_len = body_bytes}};
    if (!conn->writable || conn->reset)
        return false;
    const ssize_t sent = send_both(conn->fd, parts, MSG_NOSIGNAL | (ends ? MSG_MORE : 0));
    if (sent < 0) {
        conn->writable = false;
        conn->reset = errno != EAGAIN && errno != EINTR;
        return false;
    }
    const size_t of_out = (size_t)sent < parts[0].iov_len ? (size_t)sent : parts[0].iov_len;
    conn->out_sent += of_out;
    conn->body_sent += (size_t)sent - of_out;
    conn->sent_bytes += (uint64_t)sent;
    return true;
}

/* What the client has taken of all that was sent: the kernel holds the rest. */
static uint64_t taken_bytes(const struct conn *conn)
{
    int held = 0;
    if (ioctl(conn->fd, SIOCOUTQ, &held) != 0 || held < 0 || (uint64_t)held > conn->sent_bytes)
        return 0;
    return conn->sent_bytes - (uint64_t)held;
}

bool pen_http_conn_begin_window(struct conn *conn)
{
    const uint64_t taken = taken_bytes(conn);
    if (conn->windowed && taken < conn->window_taken + READER_BYTES)
        return false;
    conn->windowed = true;
    conn->window_taken = taken;
    pen_http_loop_wait(conn, WAIT_READER);
    return true;
}

/* Whether to close a connection without lingering: when new ones come fast, where the client has
 * sent all that it announced. If it still sent something, a reset would follow the answer, which is
 * why others linger. */
static bool ends_at_once(const struct conn *conn)
{
    return conn->all_came && !conn->readable && conn->body_sent <= SMALL_BYTES &&
           pen_http_loop_rush(conn->loop);
}

/* The answer was sent. */
static enum conn_step finish(struct conn *conn)
{
    const bool kept = !conn->request->close;
    const bool ends = !kept && ends_at_once(conn);
    /* First of all: what was sent last waits for this, and if bytes have come that were not read,
     * to close the socket without it would drop that. */
    if (!kept)
        shutdown(conn->fd, SHUT_WR);
    if (conn->state == CONN_STREAM)
        limit_acknowledgements(conn, 0);
    pen_http_conn_end_request(conn, true);
    pen_buf_release(&conn->out);
    conn->scan = (struct pen_head_scan){0};
    conn->used = true;
    conn->state = kept ? CONN_HEAD : CONN_LINGER;
    if (kept)
        pen_http_loop_wait(conn, conn->bytes > 0 ? WAIT_HEAD : WAIT_IDLE);
    else if (!ends)
        pen_http_conn_linger(conn);
    return ends ? STEP_END : STEP_ON;
}

enum conn_step pen_http_conn_send(struct conn *conn)
{
    struct request *request = conn->request;
    const struct reply *reply = &request->reply;
    bool body = has_body(request) && reply->body && !reply->failed;
    size_t all = body ? reply->bytes : 0;
    size_t left = all - conn->body_sent;
    const unsigned char *from =
        body ? reply->body->content.data + reply->first + conn->body_sent : NULL;
    const bool ends = request->close && left <= BODY_BYTES;
    const bool sent = send_parts(conn, from, left < BODY_BYTES ? left : BODY_BYTES, ends);
    if (sent && conn->out_sent == conn->out.bytes && conn->body_sent == all)
        return finish(conn);
    if (sent)
        pen_http_answers_took(request, conn->body_sent);
    else if (conn->reset || !pen_http_answers_wait(request, conn->body_sent))
        return STEP_END;
    pen_http_conn_begin_window(conn);
    return sent ? STEP_ON : STEP_WAIT;
}

/* Reads the next piece of the stream into `out`. Returns false if there is none now. */
static bool next_piece(struct conn *conn)
{
    struct request *request = conn->request;
    char *piece = conn->loop->buffer;
    bool behind, chunked = request->minor > 0;
    pen_buf_release(&conn->out);
    conn->out_sent = 0;
    ssize_t bytes = pen_http_stream_read(request->stream, piece, STREAM_BYTES, &behind);
    if (behind)
        pen_http_watch_check_soon(request->http->watch);
    if (bytes == 0)
        return false;
    conn->stream_over = bytes < 0;
    if (chunked)
        pen_buf_printf(&conn->out, "%zx\r\n", bytes > 0 ? (size_t)bytes : (size_t)0);
    if (bytes > 0)
        pen_buf_add(&conn->out, piece, (size_t)bytes);
    if (chunked)
        pen_buf_puts(&conn->out, "\r\n");
    conn->reset = conn->reset || conn->out.failed;
    return true;
}

enum conn_step pen_http_conn_send_stream(struct conn *conn)
{
    if (conn->half_closed || conn->reset)
        return STEP_END;
    if (conn->out_sent == conn->out.bytes) {
        if (conn->stream_over)
            return finish(conn);
        const bool more = next_piece(conn);
        if (more && conn->stream_over && conn->out.bytes == 0)
            return finish(conn); /* HTTP/1.0 has no last chunk */
        if (!more) {
            conn->windowed = false;
            pen_http_loop_wait(conn, WAIT_WORK);
            return STEP_WAIT;
        }
    }
    const bool sent = send_parts(conn, NULL, 0, false);
    if (conn->reset)
        return STEP_END;
    pen_http_conn_begin_window(conn);
    return sent ? STEP_ON : STEP_WAIT;
}

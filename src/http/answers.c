/* SPDX-License-Identifier: MIT */
#include "http/internal/answers.h"

#include <stdint.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/reply.h"
#include "http/internal/request.h"

/* EXTRA_BYTES is the most beyond a limit while readers give way, which takes their loops a moment.
 */
enum {
    LARGE_BYTES = 64 << 10,   /* from here on an answer counts for ANSWER_BYTES */
    ANSWER_BYTES = 96 << 20,  /* the most of such answers in memory, but pictures */
    WINDOW_BYTES = 256 << 10, /* the kernel takes some 64 to 128 KiB of an answer at a time */
    EXTRA_BYTES = 64 << 20
};

/* A blob of which no reader has taken a window for so long is read slowly. */
static const int64_t slow_ns = 2 * INT64_C(1000000000);

void pen_http_answers_init(struct answer_memory *memory)
{
    *memory = (struct answer_memory){0};
    pthread_mutex_init(&memory->lock, NULL);
}

void pen_http_answers_release(struct answer_memory *memory)
{
    pthread_mutex_destroy(&memory->lock);
}

/* Puts a blob to the end of the list. Called with the lock held. */
static void enlist(struct blob *blob)
{
    struct answer_memory *memory = blob->memory;
    struct blob_readers *readers = &blob->readers;
    readers->since_ns = pen_clock_ns();
    readers->faster = NULL;
    readers->slower = memory->fastest;
    *(readers->slower ? &readers->slower->readers.faster : &memory->slowest) = blob;
    memory->fastest = blob;
}

/* Called with the lock held. */
static void unlist(struct blob *blob)
{
    struct answer_memory *memory = blob->memory;
    struct blob_readers *readers = &blob->readers;
    *(readers->slower ? &readers->slower->readers.faster : &memory->slowest) = readers->faster;
    *(readers->faster ? &readers->faster->readers.slower : &memory->fastest) = readers->slower;
}

/* Whether `bytes` more fit, if so many bytes of those that were given up are not counted. */
static bool fits(const struct answer_memory *memory, size_t bytes, size_t limit, size_t leaving_max)
{
    const size_t leaving = atomic_load_explicit(&memory->leaving, memory_order_relaxed);
    return atomic_load_explicit(&memory->bytes, memory_order_relaxed) + bytes <=
           limit + (leaving < leaving_max ? leaving : leaving_max);
}

bool pen_http_answers_fit(const struct answer_memory *memory, size_t bytes, size_t limit)
{
    return fits(memory, bytes, limit, EXTRA_BYTES);
}

/* Whether they fit once all have left that were told to. */
static bool will_fit(const struct answer_memory *memory, size_t bytes, size_t limit)
{
    return fits(memory, bytes, limit, SIZE_MAX);
}

/* Whether nobody keeps the blob in memory but its readers in the list. Called with the lock held.
 */
static bool is_theirs(const struct blob *blob)
{
    return atomic_load_explicit(&blob->refs, memory_order_relaxed) ==
           blob->readers.count + (blob->is_kept ? 1 : 0);
}

/* Tells all readers of a blob to give way. Called with the lock held. */
static void give_up(struct blob *blob)
{
    unlist(blob);
    blob->readers.given_up = true;
    atomic_fetch_add_explicit(&blob->memory->leaving, blob->content.bytes, memory_order_relaxed);
    for (struct request *reader = blob->readers.first; reader; reader = reader->reading.next)
        pen_http_resume(reader);
}

/* The blobs that may be given up, the slowest first: the next one after `blob`, or the first one
 * (NULL). Returns NULL if there are no more. Called with the lock held. */
static struct blob *next_slow(const struct answer_memory *memory, const struct blob *blob,
                              int64_t now_ns)
{
    struct blob *next = blob ? blob->readers.faster : memory->slowest;
    while (next && now_ns - next->readers.since_ns >= slow_ns) {
        if (is_theirs(next))
            return next;
        next = next->readers.faster;
    }
    return NULL;
}

/* Gives up the slowest blobs if that is enough. Called with the lock held. */
static void give_up_slowest(struct answer_memory *memory, size_t bytes, size_t limit)
{
    const int64_t now_ns = pen_clock_ns();
    size_t slow_bytes = 0;
    struct blob *slow = NULL;
    while (!will_fit(memory, bytes, limit + slow_bytes)) {
        slow = next_slow(memory, slow, now_ns);
        if (!slow)
            return;
        slow_bytes += slow->content.bytes;
    }
    while (!will_fit(memory, bytes, limit) && (slow = next_slow(memory, NULL, now_ns)) != NULL)
        give_up(slow);
}

bool pen_http_answers_make_room(struct answer_memory *memory, size_t bytes, size_t limit)
{
    if (pen_http_answers_fit(memory, bytes, limit))
        return true;
    if (bytes > limit)
        return false;
    pthread_mutex_lock(&memory->lock);
    give_up_slowest(memory, bytes, limit);
    pthread_mutex_unlock(&memory->lock);
    return pen_http_answers_fit(memory, bytes, limit);
}

void pen_http_answers_count(struct request *request)
{
    struct answer_memory *memory = &request->http->answers;
    struct blob *body = request->reply.body;
    struct pen_status st;
    if (!body || body->memory || body->content.bytes < LARGE_BYTES || atomic_load(&body->refs) > 1)
        return;
    pen_http_blob_count(body, memory);
    if (pen_http_answers_make_room(memory, 0, ANSWER_BYTES))
        return;
    pen_http_reply_release(&request->reply);
    pen_fail(&st, PEN_UNAVAILABLE,
             "too many large answers wait for their readers; try again later");
    pen_http_request_fail(request, &st);
}

/* The request becomes a reader of a blob. Called with the lock held. */
static void enter(struct request *request, struct blob *blob)
{
    struct reader_place *place = &request->reading;
    place->listed = true;
    place->previous = NULL;
    place->next = blob->readers.first;
    if (place->next)
        place->next->reading.previous = request;
    blob->readers.first = request;
    if (blob->readers.count++ == 0)
        enlist(blob);
}

bool pen_http_answers_wait(struct request *request, size_t sent)
{
    struct blob *blob = request->reply.body;
    if (!blob || !blob->memory || request->reading.listed)
        return true;
    pthread_mutex_lock(&blob->memory->lock);
    const bool goes_on = !blob->readers.given_up;
    if (goes_on)
        enter(request, blob);
    pthread_mutex_unlock(&blob->memory->lock);
    request->reading.window_bytes = sent;
    return goes_on;
}

void pen_http_answers_took(struct request *request, size_t sent)
{
    struct reader_place *place = &request->reading;
    struct blob *blob = request->reply.body;
    if (!place->listed || sent - place->window_bytes < WINDOW_BYTES)
        return;
    place->window_bytes = sent;
    pthread_mutex_lock(&blob->memory->lock);
    if (!blob->readers.given_up) {
        unlist(blob);
        enlist(blob);
    }
    pthread_mutex_unlock(&blob->memory->lock);
}

bool pen_http_answers_gives_way(struct request *request)
{
    struct blob *blob = request->reply.body;
    if (!request->reading.listed)
        return false;
    pthread_mutex_lock(&blob->memory->lock);
    const bool given_up = blob->readers.given_up;
    pthread_mutex_unlock(&blob->memory->lock);
    return given_up;
}

void pen_http_answers_leave(struct request *request)
{
    struct reader_place *place = &request->reading;
    struct blob *blob = request->reply.body;
    if (!place->listed)
        return;
    pthread_mutex_lock(&blob->memory->lock);
    *(place->previous ? &place->previous->reading.next : &blob->readers.first) = place->next;
    if (place->next)
        place->next->reading.previous = place->previous;
    if (--blob->readers.count == 0 && !blob->readers.given_up)
        unlist(blob);
    pthread_mutex_unlock(&blob->memory->lock);
    place->listed = false;
}

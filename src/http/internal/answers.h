/* SPDX-License-Identifier: MIT */
/* The memory for large answers, and which readers give way when it is used up.
 *
 * The bytes of an answer (a blob, reply.h) are in memory until the last of its readers has them. A
 * client that does not take at once all that it was sent is a reader in the list of its blob until
 * it has the answer. A blob with readers is in the list of its memory: it comes to the end when the
 * first of them comes, and again whenever one of them has taken a window of the answer. So the
 * first blob is the one that is read the slowest.
 *
 * When the memory is used up, blobs that only slow readers keep in it are given up, the slowest
 * first: the loops of the readers close their connections. Until they have, another answer may be
 * in the place, beyond the limit. As long as one of its readers is not slow, none of a blob's
 * readers gives way: that would free nothing. If all that are slow are not enough, none gives way.
 *
 * A reader enters the list only when it keeps an answer waiting whose blob is counted, so answers
 * that are small, or taken at once, need no lock.
 *
 * Locks: that of the memory, and a loop's lock within it. */
#ifndef PEN_HTTP_INTERNAL_ANSWERS_H
#define PEN_HTTP_INTERNAL_ANSWERS_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

struct blob;
struct request;

struct answer_memory {
    atomic_size_t bytes;   /* of blobs, and reserved. atomic: relaxed, a sum */
    atomic_size_t leaving; /* of blobs that were given up. atomic: relaxed, a sum */
    pthread_mutex_t lock;
    struct blob *slowest, *fastest; /* guarded by lock: the blobs with readers */
};

void pen_http_answers_init(struct answer_memory *memory);
void pen_http_answers_release(struct answer_memory *memory);

/* Whether `bytes` more are within the limit, or in the place of blobs that were given up. Threads:
 * any. */
bool pen_http_answers_fit(const struct answer_memory *memory, size_t bytes, size_t limit);

/* As pen_http_answers_fit; if need be, and if that is enough, gives up blobs. Of memory in which
 * blobs are kept (reply.h) the caller holds their lock. Threads: any. */
bool pen_http_answers_make_room(struct answer_memory *memory, size_t bytes, size_t limit);

/* Counts the body of an answer, if it is large, counted nowhere yet and nobody else's. Answers 503
 * instead if there is no memory for it. Threads: that which has the request. */
void pen_http_answers_count(struct request *request);

/* The client keeps the answer waiting, of which `sent` bytes were sent. Returns false if the answer
 * was given up; the connection is to be closed. Threads: the loop's. */
bool pen_http_answers_wait(struct request *request, size_t sent);

/* More of the answer was sent, `sent` bytes in all. Threads: the loop's. */
void pen_http_answers_took(struct request *request, size_t sent);

/* Whether the answer was given up. Threads: the loop's. */
bool pen_http_answers_gives_way(struct request *request);

/* The answer was sent, or is dropped. Threads: the loop's. */
void pen_http_answers_leave(struct request *request);

#endif

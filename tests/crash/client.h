/* SPDX-License-Identifier: MIT */
/* Sends one HTTP request at a time to a daemon that may die at any moment. */
#ifndef TESTS_CRASH_CLIENT_H
#define TESTS_CRASH_CLIENT_H

enum { ANSWER_BYTES = 16384 };

struct answer {
    int status; /* 0: no answer, or an incomplete one */
    char body[ANSWER_BYTES];
};

/* Sends a request and waits at most 5 s for the answer. These may be NULL: `key` (Idempotency-Key),
 * `from` (the client's address in X-Forwarded-For) and `body`. Returns the status; 0 without a
 * complete answer. */
int client_call(int port, const char *method, const char *path, const char *key, const char *from,
                const char *body, struct answer *answer);

#endif

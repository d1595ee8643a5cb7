/* SPDX-License-Identifier: MIT */
/* The tokens that a server accepts, from a token file (token_file.h), which is read again when it
 * changes. If the file is then broken or unreadable, the former tokens stay valid. No log line and
 * no message contains a token or a hash.
 *
 * Threads: any, unless a function says so. */
#ifndef PEN_ACCESS_TOKENS_H
#define PEN_ACCESS_TOKENS_H

#include "access/token_file.h"

struct pen_tokens;

/* The client that has sent a request. */
struct pen_token_holder {
    char name[PEN_TOKEN_NAME_BYTES];
    enum pen_scope scope;
    unsigned char hash[PEN_TOKEN_HASH_BYTES]; /* for pen_tokens_holds; not to be shown */
};

/* Reads a token file.
 * Owns: close it.
 * Fails: as pen_token_list_read; the message names the file, line and column. */
struct pen_tokens *pen_tokens_open(const char *path, struct pen_status *st);

/* NULL is allowed. */
void pen_tokens_close(struct pen_tokens *tokens);

/* Finds the holder of a token. `authorization` is the value of the field Authorization; NULL if
 * there is none.
 * Fails: PEN_UNAUTHORIZED; the message is the same for an unknown and an expired token.
 * Cost: a hash, and comparisons with all tokens, which take equally long. */
bool pen_tokens_check(struct pen_tokens *tokens, const char *authorization,
                      struct pen_token_holder *out, struct pen_status *st);

/* Returns true if a holder's token is still valid, with its former scope. */
bool pen_tokens_holds(struct pen_tokens *tokens, const struct pen_token_holder *holder);

/* Reads the file again if it has changed or was broken, and logs every change.
 * Threads: one.
 * Cost: a stat if it has not changed. */
void pen_tokens_refresh(struct pen_tokens *tokens);

/* Returns true if the file is broken now. *st is then the error, as of pen_tokens_open. */
bool pen_tokens_fault(struct pen_tokens *tokens, struct pen_status *st);

#endif

/* SPDX-License-Identifier: MIT */
/* The tokens that a server accepts: those of a token file (token_file.h), which is read again when
 * it changes. If it is then broken or unreadable, the tokens that were read before stay in force.
 * No token and no hash appears in a log or a message. Threads: any, unless a function says so. */
#ifndef PEN_ACCESS_TOKENS_H
#define PEN_ACCESS_TOKENS_H

#include "access/token_file.h"

struct pen_tokens;

/* Who has sent a request. */
struct pen_token_holder {
    char name[PEN_TOKEN_NAME_BYTES];
    enum pen_scope scope;
    unsigned char hash[PEN_TOKEN_HASH_BYTES]; /* for pen_tokens_holds; not to be shown */
};

/* Reads a token file. Owns: close it. Fails: as pen_token_list_read; the message names the file,
 * and line and column. */
struct pen_tokens *pen_tokens_open(const char *path, struct pen_status *st);

/* NULL is allowed. */
void pen_tokens_close(struct pen_tokens *tokens);

/* Finds who has sent a token. `authorization` is the value of the field Authorization, NULL if
 * there is none. Fails: PEN_UNAUTHORIZED; the message does not tell an unknown token from an
 * expired one. Cost: a hash, and a comparison with every token, all of equal length. */
bool pen_tokens_check(struct pen_tokens *tokens, const char *authorization,
                      struct pen_token_holder *out, struct pen_status *st);

/* Whether a holder's token is still valid, with the scope that it had. */
bool pen_tokens_holds(struct pen_tokens *tokens, const struct pen_token_holder *holder);

/* Reads the file again if it has changed or was broken, and logs every change. Threads: one. Cost:
 * a stat if it has not changed. */
void pen_tokens_refresh(struct pen_tokens *tokens);

/* Whether the file is broken now. *st then says why, as that of pen_tokens_open. */
bool pen_tokens_fault(struct pen_tokens *tokens, struct pen_status *st);

#endif

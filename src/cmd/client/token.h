/* SPDX-License-Identifier: MIT */
/* The token that a daemon is sent. It is that of --token, else of PENUMBRA_TOKEN; without both, the
 * user's file $XDG_CONFIG_HOME/penumbra/token, by default ~/.config/penumbra/token, has it in one
 * line. The file must belong to the user, and nobody else may read it.
 *
 * No message contains a token. */
#ifndef PEN_CMD_CLIENT_TOKEN_H
#define PEN_CMD_CLIENT_TOKEN_H

#include <stdbool.h>

#include "base/buf.h"
#include "base/status.h"

struct pen_client_token {
    struct pen_buf text; /* without bytes: no token */
    struct pen_buf file; /* the path of the user's file; without bytes: there is no home */
    bool from_file;
};

/* Finds the token; `given` is that of option or environment, "" for none, NULL for that of the
 * file. A file that does not exist is no error. Owns: release *token in any case. Fails: PEN_USAGE
 * (a character that no token has; the file's owner, mode or lines), PEN_IO, PEN_NO_MEMORY. */
bool pen_client_token_find(struct pen_client_token *token, const char *given,
                           struct pen_status *st);
void pen_client_token_release(struct pen_client_token *token);

/* Adds to the message of an error where the token came from. */
void pen_client_token_explain(const struct pen_client_token *token, struct pen_status *st);

#endif

/* SPDX-License-Identifier: MIT */
/* The token that is sent to a daemon. It is the value of --token, else of PENUMBRA_TOKEN, else the
 * only line of the user's file. That is $XDG_CONFIG_HOME/penumbra/token, by default
 * ~/.config/penumbra/token. The file must belong to the user, and no other user may read it.
 *
 * No message contains a token. */
#ifndef PEN_CMD_CLIENT_TOKEN_H
#define PEN_CMD_CLIENT_TOKEN_H

#include <stdbool.h>

#include "base/buf.h"
#include "base/status.h"

struct pen_client_token {
    struct pen_buf text; /* without bytes: no token */
    struct pen_buf file; /* the path of the user's file; without bytes: no home folder */
    bool from_file;
};

/* Finds the token. `given` is the value of the option or the environment, "" for no token, NULL for
 * the user's file. A missing file is no error.
 * Owns: release *token in any case.
 * Fails: PEN_USAGE (a character that no token has; the file's owner, mode or lines), PEN_IO,
 * PEN_NO_MEMORY. */
bool pen_client_token_find(struct pen_client_token *token, const char *given,
                           struct pen_status *st);
void pen_client_token_release(struct pen_client_token *token);

/* Adds the source of the token to the message of an error. */
void pen_client_token_explain(const struct pen_client_token *token, struct pen_status *st);

#endif

/* SPDX-License-Identifier: MIT */
/* The token file: who may use the daemon, and for what. It has a line for each token:
 *
 *     NAME SCOPE EXPIRY HASH
 *
 * Blanks separate the fields. NAME is unique. SCOPE is read, submit or admin. EXPIRY is a time in
 * UTC such as 2027-01-31T12:00:00Z, or never. HASH is the BLAKE2b-256 of the token's text, in hex
 * digits. Lines that begin with # are comments; empty lines are allowed.
 *
 * A token is 256 random bits. So its hash needs no salt and may be fast. No message quotes the
 * file, because it may contain a token by mistake. */
#ifndef PEN_ACCESS_TOKEN_FILE_H
#define PEN_ACCESS_TOKEN_FILE_H

#include <stdint.h>
#include <sys/types.h>

#include "base/buf.h"
#include "base/status.h"

/* What a client may do. Each scope includes all scopes before it. */
enum pen_scope { PEN_SCOPE_NONE, PEN_SCOPE_READ, PEN_SCOPE_SUBMIT, PEN_SCOPE_ADMIN };

/* The names of the scopes from PEN_SCOPE_READ on; ends with NULL. */
extern const char *const pen_scope_names[];

/* Returns the scope of that name; PEN_SCOPE_NONE if there is none. */
enum pen_scope pen_scope_find(const char *name);

enum { PEN_TOKEN_BYTES = 48, PEN_TOKEN_NAME_BYTES = 33, PEN_TOKEN_HASH_BYTES = 32 };
enum { PEN_TOKEN_EXPIRY_BYTES = 32 };

struct pen_token {
    char name[PEN_TOKEN_NAME_BYTES];
    enum pen_scope scope;
    int64_t expires_s; /* seconds since 1970; INT64_MAX: never */
    unsigned char hash[PEN_TOKEN_HASH_BYTES];
};

struct pen_token_list {
    size_t count;
    struct pen_token *token;
};

/* Makes a token that never expires. `text` becomes the text that its owner sends: `pen_` and 43
 * characters of base64url.
 * Fails: PEN_USAGE (the name), PEN_INTERNAL. */
bool pen_token_make(struct pen_token *token, const char *name, enum pen_scope scope,
                    char text[PEN_TOKEN_BYTES], struct pen_status *st);

/* Computes the hash of a token's text. */
void pen_token_hash(const char *text, size_t bytes, unsigned char hash[PEN_TOKEN_HASH_BYTES]);

/* Writes the expiry in the form of the file. */
void pen_token_expiry(const struct pen_token *token, char out[PEN_TOKEN_EXPIRY_BYTES]);

/* Reads a token file. Only its owner may read or write it, and its owner must be `owner` or root.
 * Owns: release *list.
 * Fails: PEN_NOT_FOUND, PEN_IO, PEN_FORBIDDEN (permissions), PEN_TOO_LARGE (more than 1 MiB),
 * PEN_SYNTAX (with line and column), PEN_NO_MEMORY; *list is then empty. */
bool pen_token_list_read(struct pen_token_list *list, const char *path, uid_t owner,
                         struct pen_status *st);

/* Appends a token.
 * Fails: PEN_CONFLICT (the list has its name or its hash), PEN_NO_MEMORY. */
bool pen_token_list_add(struct pen_token_list *list, const struct pen_token *token,
                        struct pen_status *st);

/* Removes the token of that name. Returns false if there is none. */
bool pen_token_list_remove(struct pen_token_list *list, const char *name);

/* Appends the text of a file. After that, out->failed is true if there was no memory. */
void pen_token_list_print(const struct pen_token_list *list, struct pen_buf *out);

void pen_token_list_release(struct pen_token_list *list);

#endif

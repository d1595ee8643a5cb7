/* SPDX-License-Identifier: MIT */
#include "cmd/client/token.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cmd/files.h"

enum { FILE_BYTES_MAX = 4096 };

static const char *text_of(const struct pen_buf *buf)
{
    return buf->bytes > 0 ? (const char *)buf->data : "";
}

/* Sets the path of the user's file. A relative XDG_CONFIG_HOME is ignored, as its specification
 * requires. */
static bool find_file(struct pen_client_token *token, struct pen_status *st)
{
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    bool ok = true;
    if (config && *config == '/')
        ok = pen_buf_printf(&token->file, "%s/penumbra/token", config);
    else if (home && *home)
        ok = pen_buf_printf(&token->file, "%s/.config/penumbra/token", home);
    return ok || pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

static bool check_rights(const char *path, const struct stat *file, struct pen_status *st)
{
    const unsigned mode = file->st_mode & 07777;
    if (!S_ISREG(file->st_mode))
        return pen_fail(st, PEN_USAGE, "%s: must be a regular file", path);
    if (file->st_uid != geteuid())
        return pen_fail(st, PEN_USAGE,
                        "%s: belongs to user %u, must belong to user %u: chown %u %s", path,
                        (unsigned)file->st_uid, (unsigned)geteuid(), (unsigned)geteuid(), path);
    return (mode & ~0600u) == 0 ||
           pen_fail(st, PEN_USAGE, "%s: has mode %04o, must have 0600 or less: chmod 600 %s", path,
                    mode, path);
}

/* Reads the user's file, if there is one, into token->text. */
static bool read_file(struct pen_client_token *token, struct pen_status *st)
{
    const char *path = text_of(&token->file);
    struct stat file;
    struct pen_status cause;
    if (stat(path, &file) != 0)
        return true;
    if (!check_rights(path, &file, st))
        return false;
    if (!pen_file_read(path, FILE_BYTES_MAX, &token->text, &cause))
        return pen_fail(st, cause.code, "%s: %s", path, cause.msg);
    char *text = (char *)token->text.data;
    size_t bytes = token->text.bytes;
    if (bytes > 0 && text[bytes - 1] == '\n')
        text[--bytes] = '\0';
    token->text.bytes = bytes;
    token->from_file = true;
    return bytes > 0 || pen_fail(st, PEN_USAGE, "%s: is empty, must have a line, the token", path);
}

/* A token is sent in a header line, so a line feed in it would begin another header line. */
static bool check_text(const struct pen_client_token *token, struct pen_status *st)
{
    for (size_t i = 0; i < token->text.bytes; i++) {
        if (token->text.data[i] <= ' ' || token->text.data[i] > '~')
            return pen_fail(st, PEN_USAGE, "%s: must be one line of ASCII without spaces",
                            token->from_file ? text_of(&token->file) : "--token or PENUMBRA_TOKEN");
    }
    return true;
}

bool pen_client_token_find(struct pen_client_token *token, const char *given, struct pen_status *st)
{
    *token = (struct pen_client_token){0};
    if (!find_file(token, st))
        return false;
    if (given && !pen_buf_puts(&token->text, given))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    return (given || token->file.bytes == 0 || read_file(token, st)) && check_text(token, st);
}

void pen_client_token_release(struct pen_client_token *token)
{
    pen_buf_release(&token->text);
    pen_buf_release(&token->file);
}

void pen_client_token_explain(const struct pen_client_token *token, struct pen_status *st)
{
    const char *file = text_of(&token->file);
    if (token->text.bytes == 0)
        pen_fail(st, st->code,
                 "%s; no token was sent: it comes from --token, PENUMBRA_TOKEN or %s, and goes to "
                 "the daemon of --server or PENUMBRA_URL only",
                 st->msg, *file ? file : "a file");
    else
        pen_fail(st, st->code, "%s; the token came from %s", st->msg,
                 token->from_file ? file : "--token or PENUMBRA_TOKEN");
}

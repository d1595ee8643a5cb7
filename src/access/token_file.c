/* SPDX-License-Identifier: MIT */
#include "access/token_file.h"

#include <errno.h>
#include <fcntl.h>
#include <sodium.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { FILE_BYTES_MAX = 1 << 20, RANDOM_BYTES = 32 };
_Static_assert(PEN_TOKEN_HASH_BYTES == crypto_generichash_BYTES, "BLAKE2b-256");

static const char prefix[] = "pen_";
static const char time_format[] = "%Y-%m-%dT%H:%M:%SZ";
static const char name_allowed[] =
    "a letter from a to z and up to 31 more characters: a to z, digits, _ and -";

const char *const pen_scope_names[] = {"read", "submit", "admin", NULL};

enum pen_scope pen_scope_find(const char *name)
{
    for (int i = 0; pen_scope_names[i]; i++) {
        if (strcmp(pen_scope_names[i], name) == 0)
            return (enum pen_scope)(i + 1);
    }
    return PEN_SCOPE_NONE;
}

static bool read_name(const char *text, struct pen_token *token)
{
    const size_t bytes = strlen(text);
    if (bytes >= sizeof token->name || text[0] < 'a' || text[0] > 'z' ||
        strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_-") != bytes)
        return false;
    memcpy(token->name, text, bytes + 1);
    return true;
}

static bool read_scope(const char *text, struct pen_token *token)
{
    token->scope = pen_scope_find(text);
    return token->scope != PEN_SCOPE_NONE;
}

void pen_token_expiry(const struct pen_token *token, char out[PEN_TOKEN_EXPIRY_BYTES])
{
    const time_t at = (time_t)token->expires_s;
    struct tm utc;
    if (token->expires_s == INT64_MAX || !gmtime_r(&at, &utc) ||
        strftime(out, PEN_TOKEN_EXPIRY_BYTES, time_format, &utc) == 0)
        strcpy(out, "never");
}

/* strptime also takes days that do not exist and other spellings: these read back differently. */
static bool read_expiry(const char *text, struct pen_token *token)
{
    char again[PEN_TOKEN_EXPIRY_BYTES];
    struct tm utc = {0};
    token->expires_s = INT64_MAX;
    if (strcmp(text, "never") == 0)
        return true;
    if (!strptime(text, time_format, &utc))
        return false;
    token->expires_s = timegm(&utc);
    pen_token_expiry(token, again);
    return strcmp(text, again) == 0;
}

static bool read_hash(const char *text, struct pen_token *token)
{
    size_t bytes;
    return sodium_hex2bin(token->hash, sizeof token->hash, text, strlen(text), NULL, &bytes,
                          NULL) == 0 &&
           bytes == sizeof token->hash;
}

bool pen_token_make(struct pen_token *token, const char *name, enum pen_scope scope,
                    char text[PEN_TOKEN_BYTES], struct pen_status *st)
{
    unsigned char bits[RANDOM_BYTES];
    *token = (struct pen_token){.scope = scope, .expires_s = INT64_MAX};
    if (!read_name(name, token))
        return pen_fail(st, PEN_USAGE, "found the name \"%.40s\", allowed is %s", name,
                        name_allowed);
    if (sodium_init() < 0)
        return pen_fail(st, PEN_INTERNAL, "libsodium does not start");
    randombytes_buf(bits, sizeof bits);
    memcpy(text, prefix, sizeof prefix);
    sodium_bin2base64(text + strlen(prefix), PEN_TOKEN_BYTES - strlen(prefix), bits, sizeof bits,
                      sodium_base64_VARIANT_URLSAFE_NO_PADDING);
    pen_token_hash(text, strlen(text), token->hash);
    return true;
}

void pen_token_hash(const char *text, size_t bytes, unsigned char hash[PEN_TOKEN_HASH_BYTES])
{
    crypto_generichash(hash, PEN_TOKEN_HASH_BYTES, (const unsigned char *)text, bytes, NULL, 0);
}

enum { NAME, SCOPE, EXPIRY, HASH, FIELDS };

static bool read_fields(char *const field[FIELDS], const char *line, int number,
                        struct pen_token *token, struct pen_status *st)
{
    static const struct {
        const char *name, *allowed;
        bool (*read)(const char *text, struct pen_token *token);
    } kind[FIELDS] = {
        [NAME] = {"name", name_allowed, read_name},
        [SCOPE] = {"scope", "read, submit or admin", read_scope},
        [EXPIRY] = {"expiry", "a time in UTC such as 2027-01-31T12:00:00Z, or never", read_expiry},
        [HASH] = {"hash", "64 hex digits", read_hash},
    };
    for (int i = 0; i < FIELDS; i++) {
        if (!kind[i].read(field[i], token))
            return pen_fail_line(st, PEN_SYNTAX, number, (int)(field[i] - line) + 1,
                                 "wrong %s, allowed is %s", kind[i].name, kind[i].allowed);
    }
    return true;
}

static bool read_line(struct pen_token_list *list, char *line, int number, struct pen_status *st)
{
    static const char blanks[] = " \t\r";
    char *field[FIELDS], *rest = NULL;
    struct pen_token token;
    int count = 0;
    if (line[strspn(line, blanks)] == '#')
        return true;
    for (char *word = strtok_r(line, blanks, &rest); word; word = strtok_r(NULL, blanks, &rest)) {
        if (count < FIELDS)
            field[count] = word;
        count++;
    }
    if (count == 0)
        return true;
    if (count != FIELDS)
        return pen_fail_line(st, PEN_SYNTAX, number, 1,
                             "found %d field%s, allowed are 4: NAME SCOPE EXPIRY HASH", count,
                             count == 1 ? "" : "s");
    if (!read_fields(field, line, number, &token, st))
        return false;
    if (pen_token_list_add(list, &token, st))
        return true;
    if (st->code == PEN_CONFLICT)
        pen_fail_line(st, PEN_SYNTAX, number, 1, "the name or the hash of a line above again");
    return false;
}

static bool read_text(struct pen_token_list *list, const struct pen_buf *text,
                      struct pen_status *st)
{
    char *line = (char *)text->data;
    if (text->bytes > 0 && strlen(line) != text->bytes)
        return pen_fail(st, PEN_SYNTAX, "found a zero byte, allowed is text");
    for (int number = 1; line && *line; number++) {
        char *end = strchr(line, '\n');
        if (end)
            *end++ = '\0';
        if (!read_line(list, line, number, st))
            return false;
        line = end;
    }
    return true;
}

static bool check_rights(const struct stat *info, uid_t owner, struct pen_status *st)
{
    if (!S_ISREG(info->st_mode))
        return pen_fail(st, PEN_FORBIDDEN, "not a regular file, which a token file must be");
    if (info->st_mode & 077)
        return pen_fail(st, PEN_FORBIDDEN,
                        "found the mode %04o, allowed is 0600, or less: run chmod 600 on it",
                        info->st_mode & 07777);
    if (info->st_uid != owner && info->st_uid != 0)
        return pen_fail(st, PEN_FORBIDDEN,
                        "found the owner %u, allowed are %u, the user of this process, and root",
                        (unsigned)info->st_uid, (unsigned)owner);
    return true;
}

static bool read_all(int fd, struct pen_buf *out, struct pen_status *st)
{
    char chunk[4096];
    ssize_t got;
    while ((got = read(fd, chunk, sizeof chunk)) != 0) {
        if (got < 0 && errno != EINTR)
            return pen_fail(st, PEN_IO, "cannot read: %s", strerror(errno));
        if (got > 0 && !pen_buf_add(out, chunk, (size_t)got))
            return pen_fail(st, PEN_NO_MEMORY, "out of memory");
        if (out->bytes > FILE_BYTES_MAX)
            return pen_fail(st, PEN_TOO_LARGE, "larger than %d bytes", FILE_BYTES_MAX);
    }
    return true;
}

bool pen_token_list_read(struct pen_token_list *list, const char *path, uid_t owner,
                         struct pen_status *st)
{
    struct pen_buf text = {0};
    struct stat info;
    *list = (struct pen_token_list){0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0 || fstat(fd, &info) != 0) {
        pen_fail(st, errno == ENOENT ? PEN_NOT_FOUND : PEN_IO, "cannot open: %s", strerror(errno));
        if (fd >= 0)
            close(fd);
        return false;
    }
    const bool ok =
        check_rights(&info, owner, st) && read_all(fd, &text, st) && read_text(list, &text, st);
    close(fd);
    pen_buf_release(&text);
    return ok;
}

bool pen_token_list_add(struct pen_token_list *list, const struct pen_token *token,
                        struct pen_status *st)
{
    for (size_t i = 0; i < list->count; i++) {
        if (strcmp(list->token[i].name, token->name) == 0 ||
            memcmp(list->token[i].hash, token->hash, sizeof token->hash) == 0)
            return pen_fail(st, PEN_CONFLICT, "the token \"%s\" is there already", token->name);
    }
    if ((list->count & (list->count - 1)) == 0) { /* room for a power of two */
        const size_t room = list->count ? 2 * list->count : 1;
        struct pen_token *more = realloc(list->token, room * sizeof *more);
        if (!more)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory");
        list->token = more;
    }
    list->token[list->count++] = *token;
    return true;
}

bool pen_token_list_remove(struct pen_token_list *list, const char *name)
{
    for (size_t i = 0; i < list->count; i++) {
        struct pen_token *token = &list->token[i];
        if (strcmp(token->name, name) != 0)
            continue;
        memmove(token, token + 1, (--list->count - i) * sizeof *token);
        return true;
    }
    return false;
}

void pen_token_list_print(const struct pen_token_list *list, struct pen_buf *out)
{
    pen_buf_puts(out, "# penumbrad token add, list and remove change this file.\n"
                      "# NAME SCOPE EXPIRY HASH\n");
    for (size_t i = 0; i < list->count; i++) {
        const struct pen_token *token = &list->token[i];
        char expiry[PEN_TOKEN_EXPIRY_BYTES], hash[2 * PEN_TOKEN_HASH_BYTES + 1];
        pen_token_expiry(token, expiry);
        sodium_bin2hex(hash, sizeof hash, token->hash, sizeof token->hash);
        pen_buf_printf(out, "%s %s %s %s\n", token->name, pen_scope_names[token->scope - 1], expiry,
                       hash);
    }
}

void pen_token_list_release(struct pen_token_list *list)
{
    free(list->token);
    *list = (struct pen_token_list){0};
}

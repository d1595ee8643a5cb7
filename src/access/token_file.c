/* SPDX-License-Identifier: MIT */
#include "access/token_file.h"

#include <sodium.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "access/internal/small_file.h"

enum { RANDOM_BYTES = 32 };
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

/* strptime also accepts other spellings, and days that do not exist. Both print differently. */
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

/* The fields of a line, in their order. */
static const struct {
    const char *name, *allowed;
    bool (*read)(const char *text, struct pen_token *token);
} fields[] = {{"name", name_allowed, read_name},
              {"scope", "read, submit or admin", read_scope},
              {"expiry", "a time in UTC such as 2027-01-31T12:00:00Z, or never", read_expiry},
              {"hash", "64 hex digits", read_hash}};
enum { FIELDS = sizeof fields / sizeof fields[0] };

static bool read_line(struct pen_token_list *list, char *line, int number, struct pen_status *st)
{
    static const char blanks[] = " \t\r";
    char *word[FIELDS], *rest = NULL;
    struct pen_token token;
    int count = 0;
    for (char *next = strtok_r(line, blanks, &rest); next; next = strtok_r(NULL, blanks, &rest)) {
        if (count < FIELDS)
            word[count] = next;
        count++;
    }
    if (count == 0 || word[0][0] == '#')
        return true;
    if (count != FIELDS)
        return pen_fail_line(st, PEN_SYNTAX, number, 1,
                             "found %d field%s, allowed are 4: NAME SCOPE EXPIRY HASH", count,
                             count == 1 ? "" : "s");
    for (int i = 0; i < FIELDS; i++) {
        if (!fields[i].read(word[i], &token))
            return pen_fail_line(st, PEN_SYNTAX, number, (int)(word[i] - line) + 1,
                                 "wrong %s, allowed is %s", fields[i].name, fields[i].allowed);
    }
    if (pen_token_list_add(list, &token, st))
        return true;
    if (st->code == PEN_CONFLICT)
        pen_fail_line(st, PEN_SYNTAX, number, 1, "the name or the hash of a line above again");
    return false;
}

static bool read_lines(struct pen_token_list *list, const struct pen_small_file *file,
                       struct pen_status *st)
{
    char *line, *rest = file->text;
    if (strlen(file->text) != file->bytes)
        return pen_fail(st, PEN_SYNTAX, "found a zero byte, allowed is text");
    for (int number = 1; (line = strsep(&rest, "\n")); number++) {
        if (!read_line(list, line, number, st))
            return false;
    }
    return true;
}

static bool check_rights(const struct stat *info, uid_t owner, struct pen_status *st)
{
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

bool pen_token_list_read(struct pen_token_list *list, const char *path, uid_t owner,
                         struct pen_status *st)
{
    struct pen_small_file file;
    *list = (struct pen_token_list){0};
    const bool ok = pen_small_file_read(&file, path, st) && check_rights(&file.info, owner, st) &&
                    read_lines(list, &file, st);
    pen_small_file_release(&file);
    if (!ok)
        pen_token_list_release(list);
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
    struct pen_token *more = realloc(list->token, (list->count + 1) * sizeof *more);
    if (!more)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    list->token = more;
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

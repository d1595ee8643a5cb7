/* SPDX-License-Identifier: MIT */
#include "access/tokens.h"

#include <pthread.h>
#include <sodium.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "io/message.h"

/* Tells one state of the file from another; all zeros: there is none. The time is that of the last
 * change of contents, rights or owner. */
struct mark {
    dev_t device;
    ino_t inode;
    off_t bytes;
    struct timespec changed;
};

struct pen_tokens {
    char *path;
    struct mark mark; /* of the last read; only pen_tokens_refresh uses it */
    pthread_rwlock_t lock;
    struct pen_token_list list; /* guarded by lock: the last good ones */
    bool broken;                /* guarded by lock */
    struct pen_status fault;    /* guarded by lock: while broken */
};

static struct mark read_mark(const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return (struct mark){0};
    return (struct mark){.device = info.st_dev,
                         .inode = info.st_ino,
                         .bytes = info.st_size,
                         .changed = info.st_ctim};
}

static bool same_mark(const struct mark *a, const struct mark *b)
{
    return a->device == b->device && a->inode == b->inode && a->bytes == b->bytes &&
           a->changed.tv_sec == b->changed.tv_sec && a->changed.tv_nsec == b->changed.tv_nsec;
}

/* Puts the file's name and the place into the message. */
static void name_file(const char *path, struct pen_status *st)
{
    char text[PEN_MSG_BYTES];
    pen_status_describe(st, path, text, sizeof text);
    pen_fail(st, st->code, "%s", text);
}

static bool read_file(const char *path, struct pen_token_list *list, struct pen_status *st)
{
    if (pen_token_list_read(list, path, geteuid(), st))
        return true;
    pen_token_list_release(list);
    name_file(path, st);
    return false;
}

struct pen_tokens *pen_tokens_open(const char *path, struct pen_status *st)
{
    struct pen_tokens *tokens = sodium_init() >= 0 ? calloc(1, sizeof *tokens) : NULL;
    if (!tokens || !(tokens->path = strdup(path)) ||
        pthread_rwlock_init(&tokens->lock, NULL) != 0) {
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
        if (tokens)
            free(tokens->path);
        free(tokens);
        return NULL;
    }
    tokens->mark = read_mark(path);
    if (read_file(path, &tokens->list, st))
        return tokens;
    pen_tokens_close(tokens);
    return NULL;
}

void pen_tokens_close(struct pen_tokens *tokens)
{
    if (!tokens)
        return;
    pen_token_list_release(&tokens->list);
    pthread_rwlock_destroy(&tokens->lock);
    free(tokens->path);
    free(tokens);
}

/* The token within `Bearer TOKEN`. Returns NULL if there is none. */
static const char *find_bearer(const char *authorization, size_t *bytes)
{
    static const char scheme[] = "bearer ", blanks[] = " \t";
    if (!authorization || strncasecmp(authorization, scheme, sizeof scheme - 1) != 0)
        return NULL;
    const char *token = authorization + sizeof scheme - 1;
    token += strspn(token, blanks);
    *bytes = strcspn(token, blanks);
    return *bytes > 0 && token[*bytes + strspn(token + *bytes, blanks)] == '\0' ? token : NULL;
}

static uint64_t serial_of(const struct pen_token *token)
{
    uint64_t serial;
    memcpy(&serial, token->hash, sizeof serial);
    return serial;
}

static bool is_expired(const struct pen_token *token)
{
    return time(NULL) >= token->expires_s;
}

/* Compares with all tokens, so that the time does not tell which is alike. */
static bool find_holder(const struct pen_token_list *list,
                        const unsigned char hash[PEN_TOKEN_HASH_BYTES],
                        struct pen_token_holder *out)
{
    const struct pen_token *found = NULL;
    for (size_t i = 0; i < list->count; i++) {
        if (sodium_memcmp(list->token[i].hash, hash, PEN_TOKEN_HASH_BYTES) == 0)
            found = &list->token[i];
    }
    if (!found || is_expired(found))
        return false;
    *out = (struct pen_token_holder){.scope = found->scope, .serial = serial_of(found)};
    memcpy(out->name, found->name, sizeof out->name);
    return true;
}

bool pen_tokens_check(struct pen_tokens *tokens, const char *authorization,
                      struct pen_token_holder *out, struct pen_status *st)
{
    unsigned char hash[PEN_TOKEN_HASH_BYTES];
    size_t bytes = 0;
    const char *text = find_bearer(authorization, &bytes);
    if (!text)
        return pen_fail(st, PEN_UNAUTHORIZED,
                        "no token was sent; send the field Authorization: Bearer TOKEN");
    pen_token_hash(text, bytes, hash);
    pthread_rwlock_rdlock(&tokens->lock);
    const bool ok = find_holder(&tokens->list, hash, out);
    pthread_rwlock_unlock(&tokens->lock);
    return ok || pen_fail(st, PEN_UNAUTHORIZED, "the token is unknown or no longer valid");
}

bool pen_tokens_holds(struct pen_tokens *tokens, const struct pen_token_holder *holder)
{
    bool holds = false;
    pthread_rwlock_rdlock(&tokens->lock);
    for (size_t i = 0; i < tokens->list.count && !holds; i++) {
        const struct pen_token *token = &tokens->list.token[i];
        holds = serial_of(token) == holder->serial && token->scope >= holder->scope &&
                strcmp(token->name, holder->name) == 0 && !is_expired(token);
    }
    pthread_rwlock_unlock(&tokens->lock);
    return holds;
}

/* Replaces the tokens by those of the list, which it takes over; NULL: only notes the fault. */
static void replace(struct pen_tokens *tokens, struct pen_token_list *list,
                    const struct pen_status *fault)
{
    struct pen_token_list old = {0};
    pthread_rwlock_wrlock(&tokens->lock);
    tokens->broken = !list;
    if (list) {
        old = tokens->list;
        tokens->list = *list;
    } else {
        tokens->fault = *fault;
    }
    pthread_rwlock_unlock(&tokens->lock);
    pen_token_list_release(&old);
}

/* A fault may also pass without a change of the file, such as too many open files. So a broken file
 * is read each time, but its fault is logged once. */
void pen_tokens_refresh(struct pen_tokens *tokens)
{
    struct pen_token_list list;
    struct pen_status st;
    const struct mark mark = read_mark(tokens->path);
    const bool changed = !same_mark(&mark, &tokens->mark);
    if (!changed && !pen_tokens_fault(tokens, &st))
        return;
    tokens->mark = mark;
    if (read_file(tokens->path, &list, &st)) {
        const size_t count = list.count;
        replace(tokens, &list, NULL);
        pen_log(PEN_LOG_INFO, "%s: read again, it has %zu token%s", tokens->path, count,
                count == 1 ? "" : "s");
        return;
    }
    replace(tokens, NULL, &st);
    if (changed)
        pen_log(PEN_LOG_ERROR, "%s; the tokens that were read before stay in force", st.msg);
}

bool pen_tokens_fault(struct pen_tokens *tokens, struct pen_status *st)
{
    pthread_rwlock_rdlock(&tokens->lock);
    const bool broken = tokens->broken;
    if (broken)
        *st = tokens->fault;
    pthread_rwlock_unlock(&tokens->lock);
    return broken;
}

/* SPDX-License-Identifier: MIT */
#include "access/tokens.h"

#include <pthread.h>
#include <sodium.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>
#include <unistd.h>

#include "access/internal/small_file.h"
#include "base/log.h"

struct pen_tokens {
    struct stat seen; /* the file at the last read; only pen_tokens_refresh uses it */
    pthread_rwlock_t lock;
    struct pen_token_list list; /* guarded by lock: the last valid ones */
    struct pen_status fault;    /* guarded by lock: PEN_OK, or why the file is broken */
    char path[];
};

struct pen_tokens *pen_tokens_open(const char *path, struct pen_status *st)
{
    struct pen_tokens *tokens =
        sodium_init() >= 0 ? calloc(1, sizeof *tokens + strlen(path) + 1) : NULL;
    if (!tokens || pthread_rwlock_init(&tokens->lock, NULL) != 0) {
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
        free(tokens);
        return NULL;
    }
    strcpy(tokens->path, path);
    pen_small_file_has_changed(path, &tokens->seen);
    if (pen_token_list_read(&tokens->list, path, geteuid(), st))
        return tokens;
    pen_small_file_name(path, st);
    pen_tokens_close(tokens);
    return NULL;
}

void pen_tokens_close(struct pen_tokens *tokens)
{
    if (!tokens)
        return;
    pen_token_list_release(&tokens->list);
    pthread_rwlock_destroy(&tokens->lock);
    free(tokens);
}

/* Finds the token in `Bearer TOKEN`. Returns NULL if there is none. */
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

/* Finds a valid token. It compares with all tokens, so that the time gives no hint of a similar
 * one. */
static const struct pen_token *find_valid(const struct pen_token_list *list,
                                          const unsigned char hash[PEN_TOKEN_HASH_BYTES])
{
    const struct pen_token *found = NULL;
    for (size_t i = 0; i < list->count; i++) {
        if (sodium_memcmp(list->token[i].hash, hash, PEN_TOKEN_HASH_BYTES) == 0)
            found = &list->token[i];
    }
    return found && time(NULL) < found->expires_s ? found : NULL;
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
    const struct pen_token *found = find_valid(&tokens->list, hash);
    if (found) {
        *out = (struct pen_token_holder){.scope = found->scope};
        memcpy(out->name, found->name, sizeof out->name);
        memcpy(out->hash, found->hash, sizeof out->hash);
    }
    pthread_rwlock_unlock(&tokens->lock);
    return found || pen_fail(st, PEN_UNAUTHORIZED, "the token is unknown or no longer valid");
}

bool pen_tokens_holds(struct pen_tokens *tokens, const struct pen_token_holder *holder)
{
    pthread_rwlock_rdlock(&tokens->lock);
    const struct pen_token *token = find_valid(&tokens->list, holder->hash);
    const bool holds =
        token && token->scope >= holder->scope && strcmp(token->name, holder->name) == 0;
    pthread_rwlock_unlock(&tokens->lock);
    return holds;
}

/* Some faults pass without a change of the file, such as too many open files. So a broken file is
 * read each time, but its fault is logged once. Only this thread writes what the lock guards. */
void pen_tokens_refresh(struct pen_tokens *tokens)
{
    struct pen_token_list list;
    struct pen_status st = {.code = PEN_OK};
    const bool changed = pen_small_file_has_changed(tokens->path, &tokens->seen);
    if (!changed && tokens->fault.code == PEN_OK)
        return;
    const bool ok = pen_token_list_read(&list, tokens->path, geteuid(), &st) ||
                    pen_small_file_name(tokens->path, &st);
    const bool is_new = changed || strcmp(st.msg, tokens->fault.msg) != 0;
    struct pen_token_list old = tokens->list;
    pthread_rwlock_wrlock(&tokens->lock);
    tokens->fault = st;
    if (ok)
        tokens->list = list;
    pthread_rwlock_unlock(&tokens->lock);
    if (ok) {
        pen_token_list_release(&old);
        pen_log(PEN_LOG_INFO, "%s: read again, it has %zu token%s", tokens->path, list.count,
                list.count == 1 ? "" : "s");
    } else if (is_new) {
        pen_log(PEN_LOG_ERROR, "%s; the tokens that were read before stay in force", st.msg);
    }
}

bool pen_tokens_fault(struct pen_tokens *tokens, struct pen_status *st)
{
    pthread_rwlock_rdlock(&tokens->lock);
    const bool broken = tokens->fault.code != PEN_OK;
    if (broken)
        *st = tokens->fault;
    pthread_rwlock_unlock(&tokens->lock);
    return broken;
}

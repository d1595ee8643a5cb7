/* SPDX-License-Identifier: MIT */
/* `penumbrad token add|list|remove`: changes the token file, which a running daemon reads again. A
 * lock on FILE.lock allows one change at a time. This file stays: if it were removed while another
 * process waits for its lock, it would exclude nobody. */
#include "cmd/daemon/cmd_token.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "access/token_file.h"
#include "cmd/files.h"
#include "cmd/options.h"
#include "cmd/report.h"

enum { DAY_S = 24 * 60 * 60 };

struct settings {
    const char *tokens, *scope;
    int days; /* 0: no end */
};

static const struct pen_option options[] = {
    {.name = "tokens",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct settings, tokens),
     .value = "FILE",
     .env = "PENUMBRA_TOKENS",
     .help = "the daemon's token file; add makes it, if there is none, with mode 0600"},
    {.name = "scope",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct settings, scope),
     .value = "SCOPE",
     .choices = pen_scope_names,
     .help = "for add: read may look at everything; submit may also submit jobs, and cancel or "
             "delete its own; admin may also cancel and delete jobs of others"},
    {.name = "expires",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct settings, days),
     .value = "DAYS",
     .min = 1,
     .max = 36500,
     .help = "for add: the number of days for which the token is valid; without this option it "
             "never expires"},
    {0}};

static const struct pen_command command = {
    .program = "penumbrad",
    .name = "token",
    .arguments = "add|list|remove [NAME]",
    .summary = "Makes, lists and removes the tokens by which the daemon knows its clients.",
    .details =
        "`penumbrad token add NAME --scope SCOPE` prints a new token on standard output, "
        "once: the file has only its hash. A client sends it as `Authorization: Bearer "
        "TOKEN`. `penumbrad token list` prints names, scopes and expiry times. `penumbrad token "
        "remove NAME` removes a token. A running daemon notices each change within seconds, "
        "without a restart.",
    .options = options,
    .min_args = 1,
    .max_args = 2,
};

/* Returns the user who may own the file besides root. For root this is the file's owner, because
 * root may change the file of a daemon's user. */
static uid_t owner_of(const char *path)
{
    struct stat info;
    return geteuid() == 0 && stat(path, &info) == 0 ? info.st_uid : geteuid();
}

static int lock_file(const char *path, struct pen_status *st)
{
    char *name = NULL;
    if (asprintf(&name, "%s.lock", path) < 0) {
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
        return -1;
    }
    int fd = open(name, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600), code = -1;
    while (fd >= 0 && (code = flock(fd, LOCK_EX)) != 0 && errno == EINTR) {
    }
    if (fd < 0 || code != 0) {
        pen_fail(st, PEN_IO, "cannot lock %s: %s", name, strerror(errno));
        if (fd >= 0)
            close(fd);
        fd = -1;
    }
    free(name);
    return fd;
}

static bool write_file(const struct pen_token_list *list, const char *path, struct pen_status *st)
{
    struct pen_buf text = {0};
    pen_token_list_print(list, &text);
    umask(0077);
    const bool ok = text.failed ? pen_fail(st, PEN_NO_MEMORY, "out of memory")
                                : pen_file_write_durable(path, text.data, text.bytes, st);
    pen_buf_release(&text);
    return ok;
}

static bool remove_from(struct pen_token_list *list, const char *name, struct pen_status *st)
{
    return pen_token_list_remove(list, name) ||
           pen_fail(st, PEN_NOT_FOUND, "found no token \"%.40s\"; penumbrad token list shows them",
                    name);
}

/* Adds a token; if it is NULL, removes the token of this name. */
static bool change_locked(const char *path, const struct pen_token *token, const char *name,
                          struct pen_status *st)
{
    struct pen_token_list list;
    bool ok = pen_token_list_read(&list, path, owner_of(path), st) ||
              (token && st->code == PEN_NOT_FOUND); /* add makes the file */
    ok = ok && (token ? pen_token_list_add(&list, token, st) : remove_from(&list, name, st)) &&
         write_file(&list, path, st);
    pen_token_list_release(&list);
    return ok;
}

static bool change(const char *path, const struct pen_token *token, const char *name,
                   struct pen_status *st)
{
    int lock = lock_file(path, st);
    if (lock < 0)
        return false;
    const bool ok = change_locked(path, token, name, st);
    close(lock);
    return ok;
}

static bool add(const struct settings *settings, const char *name, struct pen_status *st)
{
    char text[PEN_TOKEN_BYTES];
    struct pen_token token;
    if (!pen_token_make(&token, name, pen_scope_find(settings->scope), text, st))
        return false;
    if (settings->days > 0)
        token.expires_s = time(NULL) + (int64_t)settings->days * DAY_S;
    if (!change(settings->tokens, &token, NULL, st))
        return false;
    printf("%s\n", text);
    fflush(stdout);
    pen_report_say(stderr, "%s: this is the only time that the token is shown", command.program);
    return true;
}

static bool remove_token(const struct settings *settings, const char *name, struct pen_status *st)
{
    return change(settings->tokens, NULL, name, st);
}

static bool list_tokens(const struct settings *settings, const char *name, struct pen_status *st)
{
    struct pen_token_list list;
    (void)name;
    const bool ok = pen_token_list_read(&list, settings->tokens, owner_of(settings->tokens), st);
    for (size_t i = 0; ok && i < list.count; i++) {
        const struct pen_token *token = &list.token[i];
        char expiry[PEN_TOKEN_EXPIRY_BYTES];
        pen_token_expiry(token, expiry);
        pen_report_say(stdout, "%-32s  %-6s  %s%s", token->name, pen_scope_names[token->scope - 1],
                       expiry, time(NULL) >= token->expires_s ? "  expired" : "");
    }
    pen_token_list_release(&list);
    return ok;
}

static const struct action {
    const char *word;
    bool named, makes; /* takes a name; makes a token */
    bool (*run)(const struct settings *settings, const char *name, struct pen_status *st);
} actions[] = {{"add", true, true, add},
               {"list", false, false, list_tokens},
               {"remove", true, false, remove_token}};

static const struct action *find_action(const char *word, struct pen_status *st)
{
    for (size_t i = 0; i < sizeof actions / sizeof actions[0]; i++) {
        if (strcmp(actions[i].word, word) == 0)
            return &actions[i];
    }
    pen_fail(st, PEN_USAGE, "found \"%.40s\", allowed is add, list or remove", word);
    return NULL;
}

static bool check(const struct action *action, const struct settings *settings, int arguments,
                  struct pen_status *st)
{
    if (!settings->tokens || !*settings->tokens)
        return pen_fail(st, PEN_USAGE, "found no --tokens FILE, which is needed");
    if (action->named != (arguments == 2))
        return pen_fail(st, PEN_USAGE, "token %s: %s", action->word,
                        action->named ? "found no NAME, which is needed"
                                      : "found an argument, allowed is none");
    if (action->makes && !settings->scope)
        return pen_fail(st, PEN_USAGE,
                        "token add: found no --scope, which is needed: read, submit or admin");
    if (!action->makes && (settings->scope || settings->days))
        return pen_fail(st, PEN_USAGE, "token %s: found --%s, which only add takes", action->word,
                        settings->scope ? "scope" : "expires");
    return true;
}

int pen_token_command(int argc, char **argv)
{
    struct settings settings = {0};
    struct pen_parsed parsed;
    struct pen_status st;
    int code = pen_command_begin(&command, argc, argv, &settings, &parsed);
    if (code >= 0)
        return code;
    const struct action *action = find_action(parsed.args[0], &st);
    if (!action || !check(action, &settings, parsed.count, &st))
        return pen_report(command.program, NULL, &st);
    const char *name = action->named ? parsed.args[1] : NULL;
    return action->run(&settings, name, &st)
               ? 0
               : pen_report(command.program, st.code == PEN_USAGE ? NULL : settings.tokens, &st);
}

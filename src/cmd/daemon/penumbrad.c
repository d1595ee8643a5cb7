/* SPDX-License-Identifier: MIT */
/* The program `penumbrad`: reads the configuration and runs a supervisor or, as its child, an api
 * or a worker process. Or runs `penumbrad backup` or `penumbrad token`. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cmd/daemon/cmd_backup.h"
#include "cmd/daemon/cmd_token.h"
#include "cmd/daemon/config.h"
#include "cmd/daemon/roles.h"
#include "cmd/daemon/signals.h"
#include "cmd/daemon/supervisor.h"
#include "cmd/report.h"
#include "store/store.h"

static const char program[] = "penumbrad";

/* Whether this supervisor both serves and renders. Only such a one makes a store, sets what is
 * kept, and releases the leases of dead workers. */
static bool is_whole(const struct pen_config *config)
{
    return pen_config_serves(config) && pen_config_renders(config);
}

/* Of all whole daemons only one may use a store: two would keep by different rules. */
static bool take_supervision(const struct pen_config *config, struct pen_store *store,
                             struct pen_status *st)
{
    if (!is_whole(config) || pen_store_supervise(store, st))
        return true;
    return st->code == PEN_CONFLICT
               ? pen_fail(st, PEN_UNAVAILABLE,
                          "another penumbrad uses this store; stop it, give this one another "
                          "--store, or start it with --role worker")
               : false;
}

/* Opens and checks the store before any child does. So the terminal shows at once that a store is
 * missing, damaged or cannot be opened, instead of a log in which children fail again and again.
 * *url names it for the children, which open no other one. Owns: free *url. */
static struct pen_store *open_store(const struct pen_config *config, char **url,
                                    struct pen_status *st)
{
    if (asprintf(url, "%s%s", is_whole(config) ? "" : "store::", config->store) < 0) {
        *url = NULL;
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
        return NULL;
    }
    struct pen_store *store = pen_store_open(*url, st);
    free(*url);
    *url = NULL;
    if (store && take_supervision(config, store, st) && pen_store_check_start(store, st)) {
        if (asprintf(url, "store:%s:%s", pen_store_identity(store), pen_store_path(store)) >= 0)
            return store;
        *url = NULL;
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
    }
    pen_store_close(store);
    return NULL;
}

/* Opens the batches of workers of this host that have ended without a supervisor to report it. One
 * whose supervisor is about to report it may be among them, and is then not charged. So this is not
 * done at the start of each supervisor, since those of workers may come and go all the time. */
static void release_dead(struct pen_store *store)
{
    struct pen_status st;
    int opened = 0;
    if (!pen_store_release_dead(store, &opened, &st))
        pen_log(PEN_LOG_WARN, "%s: the batches of dead workers wait for the end of their leases",
                st.msg);
    else if (opened > 0)
        pen_log(PEN_LOG_INFO, "released %d batch%s of dead workers", opened,
                opened == 1 ? "" : "es");
}

/* What only a whole daemon does with the store: it releases leases, sets what is kept, and makes
 * the reserve. */
static bool equip_store(const struct pen_config *config, struct pen_store *store,
                        struct pen_status *st)
{
    const struct pen_retention keep = {.keep_ms = (int64_t)config->keep_days * 86400000,
                                       .keep_bytes = config->keep_bytes_max,
                                       .keep_jobs = config->keep_jobs};
    struct pen_status why;
    release_dead(store);
    if (!pen_store_reserve(store, &why))
        pen_log(PEN_LOG_WARN, "%s", why.msg);
    if (pen_store_set_retention(store, &keep, st))
        return true;
    if (pen_store_failure(store, st) == PEN_FAILURE_REFUSED)
        return false;
    pen_log(PEN_LOG_WARN, "%s: what is kept stays as it was set before", st->msg);
    return true;
}

/* Opens the listening socket, and says so. */
static int start_listening(const struct pen_config *config, struct pen_status *st)
{
    int port, fd = pen_address_listen(&config->address, &port, st);
    if (fd < 0)
        return fd;
    const char *scheme = config->access.tls_cert ? "https" : "http";
    printf("listening on %s://%s:%d\n", scheme, config->address.host, port);
    pen_log(PEN_LOG_INFO, "listening on %s://%s:%d, store %s", scheme, config->address.host, port,
            config->store);
    if (pen_access_is_open(&config->access, &config->address))
        pen_log(PEN_LOG_WARN, "plain-http: tokens and pictures travel unencrypted");
    return fd;
}

/* The supervisor keeps its handle, and so its lock, until all children have ended. */
static int supervise_store(const struct pen_config *config, struct pen_store *store,
                           const char *url, int argc, char **argv)
{
    struct pen_status st;
    int fd = -1;
    pen_signals_hold();
    if (pen_config_serves(config) && (fd = start_listening(config, &st)) < 0)
        return pen_report(program, NULL, &st);
    int code = pen_report_finish(program, 0);
    if (code == 0 && is_whole(config) && !equip_store(config, store, &st))
        code = pen_report(program, config->store, &st);
    if (code == 0)
        code = pen_supervisor_run(config, url, argc, argv, fd);
    if (!pen_store_settle(store, &st))
        pen_log(PEN_LOG_WARN, "%s", st.msg);
    if (fd >= 0)
        close(fd);
    return code;
}

static int supervise(const struct pen_config *config, int argc, char **argv)
{
    struct pen_status st;
    char *url;
    if (pen_config_serves(config) && !pen_access_check_files(&config->access, &st))
        return pen_report(program, NULL, &st);
    struct pen_store *store = open_store(config, &url, &st);
    if (!store)
        return pen_report(program, config->store, &st);
    int code = supervise_store(config, store, url, argc, argv);
    pen_store_close(store);
    free(url);
    return code;
}

static int run(const struct pen_config *config, int argc, char **argv)
{
    struct pen_status st;
    struct pen_log_target target = {
        .level = config->log_level, .format = config->log_format, .file = config->log_file};
    pen_log_set_name("supervisor");
    if (!pen_config_log(&target, &st))
        return pen_report(program, NULL, &st);
    if (config->control_fd < 0)
        return supervise(config, argc, argv);
    return pen_config_serves(config) ? pen_role_api(config) : pen_role_worker(config);
}

int main(int argc, char **argv)
{
    struct pen_config config;
    if (argc > 1 && strcmp(argv[1], "backup") == 0)
        return pen_report_finish(program, pen_backup_command(argc - 1, argv + 1));
    if (argc > 1 && strcmp(argv[1], "token") == 0)
        return pen_report_finish(program, pen_token_command(argc - 1, argv + 1));
    int code = pen_config_load(&config, argc, argv);
    if (code < 0)
        code = run(&config, argc, argv);
    pen_config_release(&config);
    return pen_report_finish(program, code);
}

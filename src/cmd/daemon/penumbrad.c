/* SPDX-License-Identifier: MIT */
/* The program `penumbrad`: reads the configuration and runs the role it names: the supervisor of an
 * api and a worker process, or one of these two alone. Or runs `penumbrad backup` or `penumbrad
 * token`. */
#include <stdio.h>
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

static bool is_supervisor(const struct pen_config *config)
{
    return strcmp(config->role, "all") == 0;
}

/* Of all supervisors only one may use a store: two would start each other's work again. */
static bool take_supervision(const struct pen_config *config, struct pen_store *store,
                             struct pen_status *st)
{
    if (!is_supervisor(config) || pen_store_supervise(store, st))
        return true;
    return st->code == PEN_CONFLICT
               ? pen_fail(st, PEN_UNAVAILABLE,
                          "another penumbrad uses this store; stop it, give this one another "
                          "--store, or start it with --role worker")
               : false;
}

/* Opens and checks the store before any child does, and notes its identity: the processes that
 * follow open no other one. Only a supervisor may make a store. So the terminal shows at once that
 * a store is missing, damaged or cannot be opened, instead of a log in which children fail again
 * and again. */
static struct pen_store *open_store(struct pen_config *config, struct pen_status *st)
{
    if (!is_supervisor(config) && !pen_config_know_store(config, "", st))
        return NULL;
    struct pen_store *store = pen_store_open(config->store_url, st);
    if (!store)
        return NULL;
    config->store_identity = pen_store_identity(store);
    config->store_path = pen_store_path(store);
    if (take_supervision(config, store, st) && pen_store_check_start(store, st) &&
        pen_config_know_store(config, config->store_identity, st))
        return store;
    config->store_identity = config->store_path = NULL;
    pen_store_close(store);
    return NULL;
}

/* What only a supervisor does with the store: it sets what is kept, and makes the reserve. */
static bool equip_store(const struct pen_config *config, struct pen_store *store,
                        struct pen_status *st)
{
    const struct pen_retention keep = {.keep_ms = (int64_t)config->keep_days * 86400000,
                                       .keep_bytes = config->keep_bytes_max,
                                       .keep_jobs = config->keep_jobs};
    struct pen_status why;
    if (!pen_store_reserve(store, &why))
        pen_log(PEN_LOG_WARN, "%s", why.msg);
    if (pen_store_set_retention(store, &keep, st))
        return true;
    if (pen_store_failure(store, st) == PEN_FAILURE_REFUSED)
        return false;
    pen_log(PEN_LOG_WARN, "%s: what is kept stays as it was set before", st->msg);
    return true;
}

/* The supervisor keeps its handle, and so its lock, until all children have ended. */
static int supervise(struct pen_config *config, struct pen_store *store, int argc, char **argv,
                     int fd)
{
    struct pen_status st;
    if (!equip_store(config, store, &st))
        return pen_report(program, config->store, &st);
    int code = pen_supervisor_run(config, argc, argv, fd);
    if (!pen_store_settle(store, &st))
        pen_log(PEN_LOG_WARN, "%s", st.msg);
    return code;
}

static int serve_store(struct pen_config *config, struct pen_store *store, int argc, char **argv)
{
    struct pen_status st;
    int port, fd = pen_address_listen(&config->address, &port, &st);
    if (fd < 0)
        return pen_report(program, NULL, &st);
    const char *scheme = config->access.tls_cert ? "https" : "http";
    pen_signals_hold();
    printf("listening on %s://%s:%d\n", scheme, config->address.host, port);
    pen_log(PEN_LOG_INFO, "listening on %s://%s:%d, store %s", scheme, config->address.host, port,
            config->store);
    if (pen_access_is_open(&config->access, &config->address))
        pen_log(PEN_LOG_WARN, "plain-http: tokens and pictures travel unencrypted");
    int code = pen_report_finish(program, 0);
    if (code == 0)
        code = is_supervisor(config) ? supervise(config, store, argc, argv, fd)
                                     : pen_role_api(config, fd);
    close(fd);
    return code;
}

static int serve(struct pen_config *config, int argc, char **argv)
{
    struct pen_status st;
    if (!pen_access_check_files(&config->access, &st))
        return pen_report(program, NULL, &st);
    struct pen_store *store = open_store(config, &st);
    if (!store)
        return pen_report(program, config->store, &st);
    int code = serve_store(config, store, argc, argv);
    pen_store_close(store);
    return code;
}

/* A worker without a supervisor checks the store itself. */
static int work(struct pen_config *config)
{
    struct pen_status st;
    struct pen_store *store = NULL;
    if (config->control_fd < 0 && !(store = open_store(config, &st)))
        return pen_report(program, config->store, &st);
    int code = pen_role_worker(config);
    pen_store_close(store);
    return code;
}

static int run(struct pen_config *config, int argc, char **argv)
{
    struct pen_status st;
    struct pen_log_target target = {
        .level = config->log_level, .format = config->log_format, .file = config->log_file};
    pen_log_set_name("supervisor");
    if (!pen_config_log(&target, &st))
        return pen_report(program, NULL, &st);
    if (strcmp(config->role, "worker") == 0)
        return work(config);
    if (config->listen_fd >= 0)
        return pen_role_api(config, config->listen_fd);
    return serve(config, argc, argv);
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

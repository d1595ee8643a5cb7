/* SPDX-License-Identifier: MIT */
/* The program `penumbrad`. It reads the configuration and runs a supervisor or, as its child, an
 * api or a worker process. Or it runs `penumbrad backup`, `penumbrad check` or `penumbrad
 * token`. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cmd/daemon/cmd_backup.h"
#include "cmd/daemon/cmd_check.h"
#include "cmd/daemon/cmd_token.h"
#include "cmd/daemon/config.h"
#include "cmd/daemon/roles.h"
#include "cmd/daemon/signals.h"
#include "cmd/daemon/supervisor.h"
#include "cmd/report.h"
#include "store/store.h"

static const char program[] = "penumbrad";

/* Returns true if this supervisor sets the limits of retention. That is a supervisor that serves
 * and renders, and every supervisor with an api in a farm. */
static bool sets_retention(const struct pen_config *config)
{
    return pen_config_serves(config) &&
           (pen_config_renders(config) || pen_store_is_postgres(config->store));
}

/* How long the check for damage may take at the start. */
enum { CHECK_MS = 300 };

/* Looks for damage, as far as the time allows. */
static bool check_store(struct pen_store *store, struct pen_status *st)
{
    bool finished;
    if (!pen_store_check(store, CHECK_MS, &finished, st))
        return false;
    if (!finished)
        pen_log(PEN_LOG_INFO,
                "the check of the store for damage did not finish in %d ms; `penumbrad check` "
                "checks all of it",
                CHECK_MS);
    return true;
}

/* Opens the batches of workers of this host that have ended without a supervisor to report it. */
static void release_gone(struct pen_store *store)
{
    struct pen_status st;
    int opened = 0;
    if (!pen_store_release_gone(store, &opened, &st))
        pen_log(PEN_LOG_WARN, "%s: the batches of dead workers wait for the end of their leases",
                st.msg);
    else if (opened > 0)
        pen_log(PEN_LOG_INFO, "released %d batch%s of dead workers", opened,
                opened == 1 ? "" : "es");
}

static bool set_retention(const struct pen_config *config, struct pen_store *store,
                          struct pen_status *st)
{
    const struct pen_retention keep = {.keep_ms = (int64_t)config->keep_days * 86400000,
                                       .keep_bytes = config->keep_bytes_max,
                                       .keep_jobs = config->keep_jobs};
    if (pen_store_set_retention(store, &keep, st))
        return true;
    if (pen_store_failure(store, st) == PEN_FAILURE_REFUSED)
        return false;
    pen_log(PEN_LOG_WARN, "%s: what is kept stays as it was set before", st->msg);
    return true;
}

/* Opens and checks the store before any child does. If the store is missing, damaged or cannot be
 * opened, the terminal shows it at once. Otherwise it would only be in a log in which children fail
 * repeatedly. */
static bool prepare_store(const struct pen_config *config, struct pen_status *st)
{
    const bool sets = sets_retention(config);
    struct pen_store *store =
        pen_store_open(config->store, sets || pen_store_is_postgres(config->store), st);
    bool ok = store && check_store(store, st);
    if (ok)
        release_gone(store);
    ok = ok && (!sets || set_retention(config, store, st));
    pen_store_close(store);
    return ok;
}

/* Opens the listening socket, and prints its address. */
static int start_listening(const struct pen_config *config, struct pen_status *st)
{
    char store[PEN_STORE_LABEL_BYTES];
    pen_store_label(config->store, store);
    int port, fd = pen_address_listen(&config->address, &port, st);
    if (fd < 0)
        return fd;
    const char *scheme = config->access.tls_cert ? "https" : "http";
    printf("listening on %s://%s:%d\n", scheme, config->address.host, port);
    pen_log(PEN_LOG_INFO, "listening on %s://%s:%d, store %s", scheme, config->address.host, port,
            store);
    if (pen_access_is_open(&config->access, &config->address))
        pen_log(PEN_LOG_WARN, "plain-http: tokens and pictures travel unencrypted");
    return fd;
}

static int supervise(const struct pen_config *config, int argc, char **argv)
{
    struct pen_status st;
    int fd = -1;
    if (pen_config_serves(config) && !pen_access_check_files(&config->access, &st))
        return pen_report(program, NULL, &st);
    pen_signals_hold();
    if (!prepare_store(config, &st))
        return pen_report(program, pen_store_is_postgres(config->store) ? NULL : config->store,
                          &st);
    if (pen_config_serves(config) && (fd = start_listening(config, &st)) < 0)
        return pen_report(program, NULL, &st);
    int code = pen_report_finish(program, 0);
    if (code == 0)
        code = pen_supervisor_run(config, argc, argv, fd);
    if (fd >= 0)
        close(fd);
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
    pen_store_signals_join(config->signal_slot);
    return pen_config_serves(config) ? pen_role_api(config) : pen_role_worker(config);
}

int main(int argc, char **argv)
{
    struct pen_config config;
    if (argc > 1 && strcmp(argv[1], "backup") == 0)
        return pen_report_finish(program, pen_backup_command(argc - 1, argv + 1));
    if (argc > 1 && strcmp(argv[1], "check") == 0)
        return pen_report_finish(program, pen_check_command(argc - 1, argv + 1));
    if (argc > 1 && strcmp(argv[1], "token") == 0)
        return pen_report_finish(program, pen_token_command(argc - 1, argv + 1));
    int code = pen_config_load(&config, argc, argv);
    if (code < 0)
        code = run(&config, argc, argv);
    pen_config_release(&config);
    return pen_report_finish(program, code);
}

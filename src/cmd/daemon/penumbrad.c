/* SPDX-License-Identifier: MIT */
/* The program `penumbrad`: reads the configuration and runs the role it names: the supervisor of an
 * api and a worker process, or one of these two alone. Or copies the store: `penumbrad backup`. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cmd/daemon/cmd_backup.h"
#include "cmd/daemon/config.h"
#include "cmd/daemon/roles.h"
#include "cmd/daemon/signals.h"
#include "cmd/daemon/supervisor.h"
#include "cmd/report.h"
#include "store/store.h"

static const char program[] = "penumbrad";

/* Opens and checks the store once before any child does. So the terminal shows at once that a store
 * is damaged or cannot be opened, instead of a log in which children fail again and again; and the
 * folder and tables exist before two processes use them. */
static bool check_store(const char *url, struct pen_status *st)
{
    struct pen_store *store = pen_store_open(url, st);
    bool ok = store && pen_store_check(store, st);
    pen_store_close(store);
    return ok;
}

static int serve(const struct pen_config *config, int argc, char **argv)
{
    struct pen_status st;
    int port;
    if (!check_store(config->store, &st))
        return pen_report(program, config->store, &st);
    int fd = pen_address_listen(&config->address, &port, &st);
    if (fd < 0)
        return pen_report(program, NULL, &st);
    pen_signals_hold();
    printf("listening on http://%s:%d\n", config->address.host, port);
    pen_log(PEN_LOG_INFO, "listening on http://%s:%d, store %s", config->address.host, port,
            config->store);
    int code = pen_report_finish(program, 0);
    if (code == 0)
        code = strcmp(config->role, "all") == 0 ? pen_supervisor_run(config, argc, argv, fd)
                                                : pen_role_api(config, fd);
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
    if (strcmp(config->role, "worker") == 0) {
        if (config->control_fd < 0 && !check_store(config->store, &st))
            return pen_report(program, config->store, &st);
        return pen_role_worker(config);
    }
    if (config->listen_fd >= 0)
        return pen_role_api(config, config->listen_fd);
    return serve(config, argc, argv);
}

int main(int argc, char **argv)
{
    struct pen_config config;
    if (argc > 1 && strcmp(argv[1], "backup") == 0)
        return pen_report_finish(program, pen_backup_command(argc - 1, argv + 1));
    int code = pen_config_load(&config, argc, argv);
    if (code < 0)
        code = run(&config, argc, argv);
    pen_config_release(&config);
    return pen_report_finish(program, code);
}

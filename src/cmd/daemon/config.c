/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/config.h"

#include <errno.h>
#include <fcntl.h>
#include <pwd.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cmd/daemon/config_file.h"
#include "cmd/report.h"
#include "store/store.h"

static const char *const roles[] = {"all", "api", "worker", NULL};
static const char *const log_formats[] = {"text", "json", NULL};
static const char *const log_levels[] = {[PEN_LOG_DEBUG] = "debug",
                                         [PEN_LOG_INFO] = "info",
                                         [PEN_LOG_WARN] = "warn",
                                         [PEN_LOG_ERROR] = "error",
                                         NULL};

static const struct pen_option options[] = {
    {.name = "listen",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, listen),
     .value = "HOST:PORT",
     .env = "PENUMBRA_LISTEN",
     .help = "where to serve HTTP, 127.0.0.1:8080 by default; port 0 takes a free one. Any address "
             "but 127.0.0.1, localhost and [::1] needs --tokens, and also --tls-cert, "
             "--trusted-proxy or --plain-http. Not with --role worker"},
    {.name = "store",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, store),
     .value = "FILE",
     .env = "PENUMBRA_STORE",
     .help = "the database of jobs and pictures; $XDG_STATE_HOME/penumbra/penumbra.db by default, "
             "/var/lib/penumbra/penumbra.db under systemd. A missing one is made with its folder, "
             "but not by --role api or worker. Or the address of a PostgreSQL database that "
             "several machines share, postgresql://USER@HOST/DATABASE (deploy/FARM.md). Its "
             "password belongs in ~/.pgpass, PGPASSWORD or PENUMBRA_STORE"},
    {.name = "role",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct pen_config, role),
     .value = "all|api|worker",
     .choices = roles,
     .env = "PENUMBRA_ROLE",
     .help = "which processes to run and supervise: an api process, which serves HTTP, a worker "
             "process, which renders, or, by default, one of each"},
    {.name = "until-idle",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, until_idle),
     .value = "SECONDS",
     .max = 1000000000,
     .env = "PENUMBRA_UNTIL_IDLE",
     .help = "with --role worker: end, with exit code 0, after this time without work; 0, the "
             "default: never"},
    {.name = "threads",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, threads),
     .value = "N",
     .max = 1024,
     .env = "PENUMBRA_THREADS",
     .help = "render threads of the worker; 0, the default, is one per core"},
    {.name = "memory-limit",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, memory_limit),
     .value = "MIB",
     .max = 1 << 30,
     .env = "PENUMBRA_MEMORY_LIMIT",
     .help = "memory the worker may take, in MiB; 0, the default, is three quarters of the "
             "machine's. A job that needs more fails; a scene may take half of it"},
    {.name = "max-timeout",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.timeout),
     .value = "SECONDS",
     .max = 1000000000,
     .env = "PENUMBRA_MAX_TIMEOUT",
     .help = "the largest timeout_seconds that a job may have; a job without one gets a day, or "
             "this if it is less. 0, the default, allows any up to 1000000000"},
    {.name = "max-seconds",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.seconds),
     .value = "SECONDS",
     .max = 1000000000,
     .env = "PENUMBRA_MAX_SECONDS",
     .help = "the longest expected time of a job, a day (86400) by default. A job whose pixels, "
             "samples and lights exceed it is refused at once; a job whose first batches show that "
             "it will take longer fails. 0 allows any"},
    {.name = "max-pixels",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.pixels),
     .value = "N",
     .max = 64000000,
     .env = "PENUMBRA_MAX_PIXELS",
     .help = "the most pixels of a view, and of all pictures of a study together; 0, the default, "
             "allows 64000000"},
    {.name = "max-samples",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.samples),
     .value = "N",
     .max = 1000000000,
     .env = "PENUMBRA_MAX_SAMPLES",
     .help = "the most samples of a pixel, samples_per_pixel or, with a target_error, max_samples; "
             "0, the default, allows as many as the scene format"},
    {.name = "max-priority",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.priority),
     .value = "N",
     .min = -100,
     .max = 100,
     .env = "PENUMBRA_MAX_PRIORITY",
     .help = "the largest priority that a job may have, 100 by default"},
    {.name = "max-queue",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.queue),
     .value = "N",
     .max = 1000000000,
     .env = "PENUMBRA_MAX_QUEUE",
     .help = "the most jobs that wait or run, 100000 by default; further submits are answered 429. "
             "0 allows any number"},
    {.name = "max-client-queue",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, max.client_queue),
     .value = "N",
     .max = 1000000000,
     .env = "PENUMBRA_MAX_CLIENT_QUEUE",
     .help = "the same for the jobs of one client's address. 0, the default, is half of "
             "--max-queue, but all of it on the loopback interface and for requests of "
             "--trusted-proxy without X-Forwarded-For"},
    {.name = "keep-days",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, keep_days),
     .value = "N",
     .max = 36500,
     .env = "PENUMBRA_KEEP_DAYS",
     .help = "remove jobs that ended more than N days ago; 0, the default, keeps them. The "
             "statistics of a removed job stay for five years, within an eighth of --keep-bytes"},
    {.name = "keep-bytes",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, keep_bytes),
     .value = "SIZE",
     .env = "PENUMBRA_KEEP_BYTES",
     .help = "the most that jobs and their pictures may take in the database file, in bytes, or "
             "with K, M, G or T (powers of 1024). Jobs that ended first are removed first. A "
             "submit is refused if its expected results, with those of the jobs that wait or run, "
             "are too large: at most half of SIZE, or one job alone. A pixel counts 10 bytes, and "
             "12 for each further layer. Two files beside it come on top: its log, 8 MiB and for a "
             "time more, and a reserve of 16 MiB"},
    {.name = "keep-jobs",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, keep_jobs),
     .value = "N",
     .max = 1000000000,
     .env = "PENUMBRA_KEEP_JOBS",
     .help = "keep the N jobs that ended last; 0, the default, keeps all. These three limits are "
             "stored: every start sets them, except with --role worker, or --role api with a file"},
    {.name = "tokens",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, access.tokens),
     .value = "FILE",
     .env = "PENUMBRA_TOKENS",
     .help = "who may do what: the file that penumbrad token writes. It is read again when it "
             "changes. Without it, any client that reaches the port may do everything"},
    {.name = "tls-cert",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, access.tls_cert),
     .value = "FILE",
     .env = "PENUMBRA_TLS_CERT",
     .help = "serve HTTPS with this certificate, or chain of certificates, as PEM"},
    {.name = "tls-key",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, access.tls_key),
     .value = "FILE",
     .env = "PENUMBRA_TLS_KEY",
     .help = "the certificate's private key, as PEM"},
    {.name = "plain-http",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct pen_config, access.plain_http),
     .env = "PENUMBRA_PLAIN_HTTP",
     .help = "serve other machines without TLS: tokens and pictures travel unencrypted"},
    {.name = "cors",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct pen_config, access.origins),
     .value = "ORIGIN",
     .env = "PENUMBRA_CORS",
     .help = "a web page's origin, such as https://example.org, whose scripts may use the daemon; "
             "may be repeated, and may be several with spaces between them"},
    {.name = "trusted-proxy",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, access.trusted_proxy),
     .value = "ADDRESS",
     .env = "PENUMBRA_TRUSTED_PROXY",
     .help =
         "the numeric address of a proxy. For requests through it, the last address in "
         "X-Forwarded-For is the client's, for shares and --max-client-queue; the proxy must set "
         "or extend this field. X-Forwarded-Host is then the Host that an Origin must equal"},
    {.name = "log-file",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, log_file),
     .value = "FILE",
     .env = "PENUMBRA_LOG_FILE",
     .help = "write the log to FILE instead of standard error; opened again on SIGHUP"},
    {.name = "log-format",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct pen_config, log_format),
     .value = "text|json",
     .choices = log_formats,
     .env = "PENUMBRA_LOG_FORMAT",
     .help = "the log's format, text by default"},
    {.name = "log-level",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct pen_config, log_level),
     .value = "LEVEL",
     .choices = log_levels,
     .env = "PENUMBRA_LOG_LEVEL",
     .help = "the least level that is logged: debug, info (the default), warn or error"},
    {.name = "config",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, file),
     .value = "FILE",
     .env = "PENUMBRA_CONFIG",
     .help = "a JSON object with these options as keys (log_file for --log-file)"},
    {.name = "internal-listen-fd",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, listen_fd),
     .value = "FD",
     .max = 1 << 20,
     .hidden = true},
    {.name = "internal-control-fd",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, control_fd),
     .value = "FD",
     .max = 1 << 20,
     .hidden = true},
    {.name = "internal-signal-slot",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, signal_slot),
     .value = "N",
     .max = 63,
     .hidden = true},
    {.name = "internal-worker-name",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, worker_name),
     .value = "NAME",
     .hidden = true},
    {.name = "internal-trace-fd",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, trace_fd),
     .value = "FD",
     .max = 1 << 20,
     .hidden = true},
    {.name = "internal-dead-worker",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, dead_worker),
     .value = "NAME",
     .hidden = true},
    {.name = "internal-dead-how",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, dead_how),
     .value = "TEXT",
     .hidden = true},
    {.name = "internal-dead-end",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct pen_config, dead_end),
     .value = "crashed|died",
     .hidden = true},
    {.name = "internal-dead-trace-fd",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct pen_config, dead_trace_fd),
     .value = "FD",
     .max = 1 << 20,
     .hidden = true},
    {0}};

const struct pen_command pen_command_daemon = {
    .program = "penumbrad",
    .arguments = "",
    .summary = "The render daemon: takes scenes over HTTP, queues them durably, renders them.",
    .details =
        "The first line on standard output is `listening on http://HOST:PORT`, or https; with "
        "--role worker there is none. "
        "SIGTERM drains the daemon and ends it within 10 s; SIGHUP reads the configuration again "
        "and opens the log file again. Every option is also an environment variable and a "
        "key of the configuration file. The command line overrides the environment, which "
        "overrides the file. `penumbrad backup FILE` copies the store, which a daemon may use "
        "meanwhile; `penumbrad check` looks for damage in it; `penumbrad token` makes, lists and "
        "removes tokens. Each has its own --help.",
    .options = options,
    .max_args = 0,
};

/* Makes the store's default path. It is in the first of systemd's state folders, which
 * $STATE_DIRECTORY lists with colons between them; or in $XDG_STATE_HOME; or in ~/.local/state. */
static bool make_default_store(struct pen_config *config, struct pen_status *st)
{
    const char *systemd = getenv("STATE_DIRECTORY"), *state = getenv("XDG_STATE_HOME");
    const char *home = getenv("HOME");
    int made;
    if (!home || home[0] != '/') {
        const struct passwd *user = getpwuid(getuid());
        home = user ? user->pw_dir : "/";
    }
    if (systemd && systemd[0] == '/')
        made = asprintf(&config->default_store, "%.*s/penumbra.db", (int)strcspn(systemd, ":"),
                        systemd);
    else if (state && state[0] == '/')
        made = asprintf(&config->default_store, "%s/penumbra/penumbra.db", state);
    else
        made = asprintf(&config->default_store, "%s/.local/state/penumbra/penumbra.db", home);
    if (made >= 0)
        config->store = config->default_store;
    else
        config->default_store = NULL;
    return made >= 0 || pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

/* Reads a size like 500M. It must be at least a MiB, because an empty store already has some
 * pages. */
static bool read_size(const char *text, int64_t *bytes, struct pen_status *st)
{
    static const char units[] = "KMGT";
    char *end = NULL;
    errno = 0;
    long long number = text[0] >= '0' && text[0] <= '9' ? strtoll(text, &end, 10) : 0;
    const char *unit = end && *end ? strchr(units, *end) : NULL;
    int shift = unit ? 10 * (int)(unit - units + 1) : 0;
    bool ok = end && errno == 0 && !end[unit != NULL] && number <= INT64_MAX >> shift;
    *bytes = ok ? (int64_t)number << shift : 0;
    return (ok && (*bytes == 0 || *bytes >= 1 << 20)) ||
           pen_fail(st, PEN_USAGE,
                    "--keep-bytes: found \"%.60s\", allowed is a number of bytes from 1M on, with "
                    "K, M, G or T, or 0 for no limit",
                    text);
}

bool pen_config_serves(const struct pen_config *config)
{
    return strcmp(config->role, "worker") != 0;
}

bool pen_config_renders(const struct pen_config *config)
{
    return strcmp(config->role, "api") != 0;
}

/* Checks options that depend on the role, and sets the address. An option that the role cannot use
 * is refused: a worker with an address to listen on, or a service with --until-idle. */
static bool check_role(struct pen_config *config, struct pen_status *st)
{
    if (!pen_config_serves(config))
        return !config->listen ||
               pen_fail(st, PEN_USAGE,
                        "listen: found \"%s\" with --role worker, which serves nothing: write "
                        "--role worker alone, or --role api with --listen, or --listen alone to "
                        "serve and render",
                        config->listen);
    if (config->until_idle)
        return pen_fail(st, PEN_USAGE,
                        "until-idle: found %d with --role %s; only --role worker ends without "
                        "work, because a client may come at any time to a daemon that serves",
                        config->until_idle, config->role);
    if (!config->listen)
        config->listen = "127.0.0.1:8080";
    return pen_address_parse(config->listen, &config->address, st);
}

static bool check(struct pen_config *config, struct pen_status *st)
{
    config->keep_bytes_max = 0;
    if (config->keep_bytes && !read_size(config->keep_bytes, &config->keep_bytes_max, st))
        return false;
    return check_role(config, st) &&
           pen_access_check(&config->access, config->listen ? &config->address : NULL, st) &&
           ((config->store && *config->store) || make_default_store(config, st));
}

/* Refuses secrets on the command line, which other users can see. */
static bool check_command_line(const struct pen_config *config, struct pen_status *st)
{
    return !config->store || !pen_store_has_password(config->store) ||
           pen_fail(st, PEN_USAGE,
                    "store: the address has a password, which other users can read on the command "
                    "line: write the address into PENUMBRA_STORE or the configuration file, or the "
                    "password into ~/.pgpass");
}

int pen_config_load(struct pen_config *config, int argc, char **argv)
{
    static const char program[] = "penumbrad";
    struct pen_parsed parsed;
    struct pen_status st;
    struct pen_errors errors = {0};
    *config =
        (struct pen_config){.role = "all",
                            .log_format = "text",
                            .log_level = "info",
                            .max = {.seconds = 24 * 60 * 60, .priority = 100, .queue = 100000},
                            .listen_fd = -1,
                            .control_fd = -1,
                            .trace_fd = -1,
                            .dead_trace_fd = -1};
    if (!pen_options_parse(&pen_command_daemon, argc, argv, config, &parsed, &st))
        return pen_report(program, NULL, &st);
    if (parsed.help) {
        pen_options_help(&pen_command_daemon, stdout);
        return 0;
    }
    if (parsed.version) {
        pen_report_version(program);
        printf("stores: SQLite%s\n", pen_store_has_postgres() ? ", PostgreSQL" : "");
        return 0;
    }
    if (!check_command_line(config, &st) ||
        !pen_options_from_env(&pen_command_daemon, config, &parsed, &st))
        return pen_report(program, NULL, &st);
    if (config->file && !pen_config_read_file(config, &parsed, &errors))
        return pen_report_errors(program, config->file, &errors);
    return check(config, &st) ? -1 : pen_report(program, NULL, &st);
}

int pen_config_find_store(const char *store, const char *file, struct pen_config *config)
{
    static char program[] = "penumbrad", store_option[] = "--store", file_option[] = "--config";
    char *argv[6] = {program};
    int argc = 1;
    if (store) {
        argv[argc++] = store_option;
        argv[argc++] = (char *)(uintptr_t)store;
    }
    if (file) {
        argv[argc++] = file_option;
        argv[argc++] = (char *)(uintptr_t)file;
    }
    return pen_config_load(config, argc, argv);
}

void pen_config_release(struct pen_config *config)
{
    json_decref(config->document);
    free(config->default_store);
    pen_access_release(&config->access);
    *config = (struct pen_config){.listen_fd = -1, .control_fd = -1};
}

static bool open_log(const char *path, struct pen_status *st)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640);
    bool ok = fd >= 0 && dup2(fd, STDERR_FILENO) >= 0;
    if (!ok)
        pen_fail(st, PEN_IO, "cannot open the log file %s: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    return ok;
}

bool pen_config_log(const struct pen_log_target *target, struct pen_status *st)
{
    for (int level = 0; log_levels[level]; level++) {
        if (strcmp(log_levels[level], target->level) == 0)
            pen_log_set_level((enum pen_log_level)level);
    }
    pen_log_set_json(strcmp(target->format, "json") == 0);
    return !target->file || !*target->file || open_log(target->file, st);
}

/* SPDX-License-Identifier: MIT */
/* `penumbra top`: the workers and running jobs of a daemon, redrawn every second on a terminal. */
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/utf8.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/keys.h"
#include "cmd/client/progress.h"
#include "cmd/client/remote_job.h"
#include "cmd/report.h"

enum {
    COLUMNS = 126,     /* if the width of the terminal is not known */
    NAME_COLUMNS = 26, /* of a job, behind its bar */
    BAR_COLUMNS = 100  /* from this width on, a bar has space */
};

struct values {
    struct pen_remote remote;
    double interval;
    bool once, json;
};

static const struct pen_option options[] = {
    {.name = "interval",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, interval),
     .value = "SECONDS",
     .min = 0.1,
     .max = 3600,
     .help = "time between two updates, 1 by default"},
    {.name = "once",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, once),
     .help = "print once and end; always so if standard output is not a terminal"},
    PEN_JSON_OPTION(struct values,
                    "print once, as {\"workers\": […], \"running\": […], \"queued\": […]}"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

/* The lists of the daemon, each one page. */
struct state {
    json_t *workers, *running, *queued;
    bool more_running, more_queued; /* there is a further page */
};

static void state_release(struct state *state)
{
    json_decref(state->workers);
    json_decref(state->running);
    json_decref(state->queued);
}

/* GETs a page and returns its array `key`; NULL after an error. *more: there is a further page. */
static json_t *get_list(struct pen_client *client, const char *path, const char *key, bool *more,
                        struct pen_errors *errors)
{
    json_t *page, *list = NULL;
    if (pen_remote_get(client, path, &page, errors)) {
        list = json_object_get(page, key);
        list = list ? json_incref(list) : json_array();
        *more = json_is_string(json_object_get(page, "next"));
    }
    json_decref(page);
    return list;
}

static bool get_state(struct pen_client *client, struct state *state, struct pen_errors *errors)
{
    bool ignored;
    *state = (struct state){0};
    state->workers = get_list(client, "/v1/workers", "workers", &ignored, errors);
    if (state->workers)
        state->running = get_list(client, "/v1/jobs?state=running&limit=20", "jobs",
                                  &state->more_running, errors);
    if (state->running)
        state->queued =
            get_list(client, "/v1/jobs?state=queued&limit=20", "jobs", &state->more_queued, errors);
    return state->queued != NULL;
}

static void write_worker(const json_t *worker, struct pen_buf *out)
{
    char host[21];
    double seen = (double)pen_clock_wall_ms() * 1e-3 - pen_remote_time(worker, "last_seen_at");
    const json_t *batches = json_object_get(worker, "batches"), *batch;
    size_t i;
    pen_remote_label(worker, "host", host, sizeof host);
    pen_buf_printf(out, "%-20s  %7d  %7d  %4.0f s  ", host,
                   (int)json_integer_value(json_object_get(worker, "pid")),
                   (int)json_integer_value(json_object_get(worker, "threads")),
                   seen > 0 ? seen : 0);
    json_array_foreach(batches, i, batch)
    {
        char view[33], job_id[14], kind[16];
        pen_remote_label(batch, "view", view, sizeof view);
        pen_remote_label(batch, "job", job_id, sizeof job_id);
        pen_remote_label(batch, "kind", kind, sizeof kind);
        int attempt = (int)json_integer_value(json_object_get(batch, "attempt"));
        pen_buf_printf(out, "%s%s… %s of %s", i ? "; " : "", job_id, kind, view);
        if (attempt > 1)
            pen_buf_printf(out, ", attempt %d", attempt);
    }
    pen_buf_puts(out, json_array_size(batches) ? "\n" : "nothing\n");
}

/* Writes a job's line. If there is no space for a bar, it has only the percentage. */
static void write_job(const json_t *job, int columns, struct pen_buf *out)
{
    char name[25], id[41], label[64], bar[256], left[16];
    const json_t *progress = json_object_get(job, "progress");
    const json_t *eta = json_object_get(progress, "eta_seconds");
    double fraction = json_number_value(json_object_get(progress, "fraction"));
    double seconds = json_is_number(eta) ? json_number_value(eta) : -1;
    pen_remote_label(job, "name", name, sizeof name);
    pen_remote_label(job, "id", id, sizeof id);
    if (columns >= BAR_COLUMNS) {
        snprintf(label, sizeof label, "%-36s", id);
        pen_progress_text(label, fraction, seconds, columns - NAME_COLUMNS, bar, sizeof bar);
        pen_buf_printf(out, "%s  %s\n", bar, name);
        return;
    }
    pen_progress_time(seconds, left);
    pen_buf_printf(out, "%-36s  %3d %%  %7s left  %s\n", id, (int)(fraction * 100), left, name);
}

static void write_state(const struct state *state, int columns, struct pen_buf *out)
{
    char now[25];
    size_t i;
    const json_t *item;
    pen_clock_format(pen_clock_wall_ms(), now);
    pen_buf_printf(out, "%.19sZ  workers %zu, running %zu%s, queued %zu%s\n", now,
                   json_array_size(state->workers), json_array_size(state->running),
                   state->more_running ? " and more" : "", json_array_size(state->queued),
                   state->more_queued ? " and more" : "");
    if (json_array_size(state->workers) > 0)
        pen_buf_printf(out, "\n%-20s  %7s  %7s  %6s  %s\n", "WORKER", "PID", "THREADS", "SEEN",
                       "WORKS ON");
    json_array_foreach(state->workers, i, item) write_worker(item, out);
    if (json_array_size(state->running) > 0)
        pen_buf_puts(out, "\nRUNNING\n");
    json_array_foreach(state->running, i, item) write_job(item, columns, out);
}

/* Cuts each line to the width, and ends it with `end`. */
static void cut_lines(const struct pen_buf *text, int columns, const char *end, struct pen_buf *out)
{
    const char *c = (const char *)text->data;
    size_t left = strlen(c), length;
    pen_buf_puts(out, "");
    for (int column = 0; left > 0; c += length, left -= length) {
        if (*c == '\n') {
            pen_buf_puts(out, end);
            column = 0;
            length = 1;
            continue;
        }
        column += pen_utf8_char_columns(c, left, &length);
        if (column <= columns)
            pen_buf_add(out, c, length);
    }
}

/* Draws over the last text, and clears the rest of each line and the lines below. */
static void draw(const struct pen_buf *text, int columns)
{
    struct pen_buf lines = {0};
    cut_lines(text, columns, "\033[K\n", &lines);
    fputs("\033[H", stdout);
    fputs(lines.failed ? "out of memory" : (const char *)lines.data, stdout);
    fputs("\033[J", stdout);
    pen_buf_release(&lines);
    fflush(stdout);
}

static void show(const struct state *state, const struct values *values, bool live)
{
    struct winsize size;
    int columns = COLUMNS;
    struct pen_buf text = {0}, lines = {0};
    if (values->json) {
        pen_report_line(json_pack("{s:O, s:O, s:O}", "workers", state->workers, "running",
                                  state->running, "queued", state->queued));
        return;
    }
    const bool terminal = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0;
    if (terminal && size.ws_col > 30)
        columns = size.ws_col;
    write_state(state, columns, &text);
    if (text.failed)
        pen_report_say(stderr, "penumbra: out of memory");
    else if (live)
        draw(&text, columns);
    else if (terminal) {
        cut_lines(&text, columns, "\n", &lines);
        pen_report_show(stdout, lines.failed ? "out of memory\n" : (const char *)lines.data);
    } else
        pen_report_show(stdout, (const char *)text.data);
    pen_buf_release(&text);
    pen_buf_release(&lines);
}

static bool update(struct pen_client *client, const struct values *values, bool live,
                   struct pen_errors *errors)
{
    struct state state;
    bool ok = get_state(client, &state, errors);
    if (ok)
        show(&state, values, live);
    state_release(&state);
    return ok;
}

static bool watch(struct pen_client *client, const struct values *values, struct pen_errors *errors)
{
    bool live = !values->once && !values->json && isatty(STDOUT_FILENO);
    struct pen_keys keys;
    if (!live)
        return update(client, values, false, errors);
    fputs("\033[2J", stdout);
    pen_keys_begin(&keys);
    bool ok;
    do
        ok = update(client, values, true, errors);
    while (ok && pen_keys_wait(&keys, (int)(values->interval * 1000)));
    pen_keys_end(&keys);
    return ok;
}

static int run(int argc, char **argv)
{
    struct values values = {.remote = PEN_REMOTE_DEFAULT, .interval = 1};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_top, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct pen_status st;
    struct pen_errors errors = {0};
    struct pen_client *client = pen_client_open(&values.remote, &st);
    if (!client)
        return pen_report_json(NULL, values.json, &st);
    code = watch(client, &values, &errors) ? 0 : pen_report_errors_json(NULL, values.json, &errors);
    pen_client_close(client);
    return code;
}

const struct pen_command pen_command_top = {
    .program = "penumbra",
    .name = "top",
    .arguments = "",
    .summary = "Shows the workers and running jobs of a daemon, updated every second; q ends it.",
    .options = options,
    .min_args = 0,
    .max_args = 0,
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* `penumbra list`: the jobs of a daemon as a table, newest first. */
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/utf8.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/progress.h"
#include "cmd/client/remote_job.h"
#include "cmd/report.h"

enum { PAGE = 500 }; /* the largest limit that the daemon takes */

static const char *const states[] = {"queued", "running", "succeeded", "failed", "cancelled", NULL};

struct values {
    struct pen_remote remote;
    const char *state, *kind, *name, *label;
    int limit;
    bool json;
};

static const struct pen_option options[] = {
    {.name = "state",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, state),
     .value = "STATE",
     .choices = states,
     .help = "only jobs in this state: queued, running, succeeded, failed or cancelled"},
    {.name = "kind",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, kind),
     .value = "KIND",
     .help = "only jobs of this kind, such as render"},
    {.name = "name",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, name),
     .value = "NAME",
     .help = "only jobs of exactly this name"},
    {.name = "label",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, label),
     .value = "KEY:VALUE",
     .help = "only jobs with this label"},
    {.name = "limit",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, limit),
     .value = "N",
     .min = 1,
     .max = 1000000,
     .help = "at most N jobs, 50 by default"},
    PEN_JSON_OPTION(struct values, "print {\"jobs\": […]}"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

static bool make_path(struct pen_client *client, const struct values *values, int limit,
                      const char *cursor, struct pen_buf *path)
{
    bool ok = pen_buf_printf(path, "/v1/jobs?limit=%d", limit < PAGE ? limit : PAGE);
    if (values->state)
        ok = ok && pen_buf_printf(path, "&state=%s", values->state);
    if (values->kind)
        ok = ok && pen_buf_puts(path, "&kind=") && pen_client_escape(client, path, values->kind);
    if (values->name)
        ok = ok && pen_buf_puts(path, "&name=") && pen_client_escape(client, path, values->name);
    if (values->label)
        ok = ok && pen_buf_puts(path, "&label=") && pen_client_escape(client, path, values->label);
    if (cursor)
        ok = ok && pen_buf_puts(path, "&cursor=") && pen_client_escape(client, path, cursor);
    return ok;
}

/* Gets one page: appends its jobs, and sets the cursor of the next page, "" if this was the
 * last. */
static bool get_page(struct pen_client *client, const struct values *values, json_t *jobs,
                     char cursor[512], struct pen_errors *errors)
{
    struct pen_buf path = {0};
    json_t *page = NULL;
    int left = values->limit - (int)json_array_size(jobs);
    bool ok = make_path(client, values, left, cursor[0] ? cursor : NULL, &path);
    if (ok) {
        ok = pen_remote_get(client, (const char *)path.data, &page, errors);
    } else {
        struct pen_status st;
        pen_fail(&st, PEN_NO_MEMORY, "out of memory");
        pen_errors_add(errors, &st);
    }
    if (ok) {
        json_array_extend(jobs, json_object_get(page, "jobs"));
        snprintf(cursor, 512, "%s", pen_remote_text(page, "next"));
    }
    json_decref(page);
    pen_buf_release(&path);
    return ok;
}

/* Writes how long the job has been running, or how long it ran. */
static void format_time(const json_t *job, char out[16])
{
    double from = pen_remote_time(job, "started_at");
    double to = pen_remote_time(job, "finished_at");
    if (from >= 0 && to < 0)
        to = (double)pen_clock_wall_ms() * 1e-3;
    if (from < 0 || to < from)
        snprintf(out, 16, "-");
    else if (to - from < 10)
        snprintf(out, 16, "%.2f s", to - from);
    else
        pen_progress_time(to - from, out);
}

/* The widths of the table. A terminal of 80 columns has space for all columns but the time of
 * creation. */
struct table {
    bool created;
    int name_columns;
};

static struct table table_for_output(void)
{
    enum { CREATED = 21, OTHERS = 71, LEAST = 9, ALL = 200 };
    struct winsize size;
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
        return (struct table){.created = true, .name_columns = ALL};
    int left = size.ws_col - OTHERS;
    struct table table = {.created = left >= CREATED + LEAST};
    left -= table.created ? CREATED : 0;
    table.name_columns = left < LEAST ? LEAST : left;
    return table;
}

/* Returns the number of bytes of the characters that fit into some columns. */
static int bytes_of(const char *text, int columns)
{
    const size_t all = strlen(text);
    size_t bytes = 0, length = 0;
    for (int used = 0; bytes < all; bytes += length) {
        used += pen_utf8_char_columns(text + bytes, all - bytes, &length);
        if (used > columns)
            break;
    }
    return (int)bytes;
}

static void print_line(const struct table *table, const char *id, const char *kind,
                       const char *state, const char *created, const char *took, const char *name)
{
    char when[24] = "";
    if (table->created)
        snprintf(when, sizeof when, "%-19s  ", created);
    pen_report_say(stdout, "%-36s  %-9s  %-11s  %s%7s  %.*s", id, kind, state, when, took,
                   bytes_of(name, table->name_columns), name);
}

static void print_row(const struct table *table, const json_t *job)
{
    char took[16], id[64], kind[16], state[24], name[820], created[20];
    double fraction =
        json_number_value(json_object_get(json_object_get(job, "progress"), "fraction"));
    format_time(job, took);
    pen_remote_label(job, "id", id, sizeof id);
    pen_remote_label(job, "kind", kind, sizeof kind);
    pen_remote_label(job, "state", state, sizeof state);
    pen_remote_label(job, "name", name, sizeof name);
    pen_remote_label(job, "created_at", created, sizeof created);
    if (strlen(created) > 10)
        created[10] = ' ';
    if (fraction > 0 && strcmp(state, "running") == 0)
        snprintf(state, sizeof state, "running %2.0f%%", 100 * fraction);
    print_line(table, id, kind, state, created, took, name);
}

static void print_table(const json_t *jobs)
{
    const struct table table = table_for_output();
    size_t i;
    const json_t *job;
    if (json_array_size(jobs) == 0)
        return;
    print_line(&table, "ID", "KIND", "STATE", "CREATED (UTC)", "TIME", "NAME");
    json_array_foreach(jobs, i, job) print_row(&table, job);
}

static int run(int argc, char **argv)
{
    struct values values = {.remote = PEN_REMOTE_DEFAULT, .limit = 50};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_list, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct pen_status st;
    struct pen_errors errors = {0};
    struct pen_client *client = pen_client_open(&values.remote, &st);
    if (!client)
        return pen_report_json(NULL, values.json, &st);
    json_t *jobs = json_array();
    char cursor[512] = "";
    bool ok = true;
    do
        ok = get_page(client, &values, jobs, cursor, &errors);
    while (ok && cursor[0] && (int)json_array_size(jobs) < values.limit);
    if (!ok)
        code = pen_report_errors_json(NULL, values.json, &errors);
    else if (values.json)
        pen_report_line(json_pack("{s:O}", "jobs", jobs));
    else
        print_table(jobs);
    json_decref(jobs);
    pen_client_close(client);
    return ok ? 0 : code;
}

const struct pen_command pen_command_list = {
    .program = "penumbra",
    .name = "list",
    .arguments = "",
    .summary = "Lists the jobs of a daemon, newest first.",
    .options = options,
    .min_args = 0,
    .max_args = 0,
    .run = run,
};

/* SPDX-License-Identifier: MIT */
#include "cmd/client/bench_history.h"

#include <dirent.h>
#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "cmd/client/report_source.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "study/history.h"

/* The reports, as read. */
struct reports {
    json_t **item;
    int count;
};

static bool out_of_memory(struct pen_status *st)
{
    return pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

/* Takes the reference to the report. */
static bool add_report(struct reports *reports, json_t *report, struct pen_status *st)
{
    json_t **grown = realloc(reports->item, ((size_t)reports->count + 1) * sizeof *grown);
    if (!grown) {
        json_decref(report);
        return out_of_memory(st);
    }
    grown[reports->count++] = report;
    reports->item = grown;
    return true;
}

/* Fails unless a report is of a benchmark: an accuracy study has no history. */
static bool check_kind(const json_t *report, struct pen_errors *errors)
{
    struct pen_status st;
    const char *kind = json_string_value(json_object_get(report, "kind"));
    if (strcmp(kind ? kind : "", "benchmark") == 0)
        return true;
    pen_fail_at(&st, PEN_INVALID, "/kind", "must be \"benchmark\", found \"%.60s\"",
                kind ? kind : "");
    pen_errors_add(errors, &st);
    return false;
}

/* Reads a file of the folder. A file that is no report is named and left out. */
static bool read_file(const struct pen_bench_history *h, const char *name, struct reports *reports,
                      struct pen_status *st)
{
    struct pen_errors errors = {0};
    struct pen_buf path = {0};
    json_t *report = NULL;
    pen_buf_printf(&path, "%s/%s", h->folder, name);
    if (path.failed)
        return out_of_memory(st);
    const bool read = pen_report_source_read((const char *)path.data, NULL, &report, &errors) &&
                      check_kind(report, &errors);
    if (!read)
        pen_report_errors("penumbra: left out", (const char *)path.data, &errors);
    pen_buf_release(&path);
    const char *scene = json_string_value(json_object_get(report, "scene"));
    if (read && (!h->scene || strcmp(scene ? scene : "", h->scene) == 0))
        return add_report(reports, report, st);
    json_decref(report);
    return true;
}

static int is_json(const struct dirent *entry)
{
    return pen_name_ends_in(entry->d_name, ".json");
}

static bool read_folder(const struct pen_bench_history *h, struct reports *reports,
                        struct pen_status *st)
{
    struct dirent **names;
    const int count = scandir(h->folder, &names, is_json, alphasort);
    bool ok = true;
    if (count < 0)
        return pen_fail(st, errno == ENOENT ? PEN_NOT_FOUND : PEN_IO, "--history: %.200s: %s",
                        h->folder, strerror(errno));
    for (int i = 0; i < count; i++) {
        ok = ok && read_file(h, names[i]->d_name, reports, st);
        free(names[i]);
    }
    free(names);
    if (ok && reports->count == 0)
        return pen_fail(st, PEN_NOT_FOUND, "--history: %.200s has no report of a benchmark%s%.80s",
                        h->folder, h->scene ? " of the scene " : "", h->scene ? h->scene : "");
    return ok;
}

int pen_bench_history(const struct pen_bench_history *h)
{
    struct reports reports = {0};
    struct pen_status st;
    json_t *history = NULL;
    bool ok = pen_report_output_check(&h->output, &st) && read_folder(h, &reports, &st);
    if (ok)
        history = pen_history_new(reports.item, reports.count, h->least_effect, &st);
    ok = history && pen_report_output_write(&h->output, history, NULL, &st);
    for (int i = 0; i < reports.count; i++)
        json_decref(reports.item[i]);
    free(reports.item);
    json_decref(history);
    return ok ? 0 : pen_report_json(NULL, h->output.json, &st);
}

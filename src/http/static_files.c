/* SPDX-License-Identifier: MIT */
/* Makes the files from the data that is embedded in the program. */
#include "http/internal/static_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "io/builtin.h"
#include "jobs/jobs.h"
#include "report/report.h"

struct static_files {
    char page_policy[512];
    size_t count;
    struct static_file file[];
};

/* Writes the policy of the page. All parts of the page come from this server, and none is inline. A
 * report that the page shows in a frame (blob:) inherits this policy, so its script and style are
 * allowed. */
static void write_page_policy(struct static_files *files)
{
    char script[PEN_REPORT_SOURCE_BYTES], style[PEN_REPORT_SOURCE_BYTES];
    pen_report_sources(script, style);
    snprintf(files->page_policy, sizeof files->page_policy,
             "default-src 'none'; script-src 'self' %s; style-src 'self' %s; connect-src 'self'; "
             "img-src 'self' blob: data:; frame-src blob:; base-uri 'none'; form-action 'none'; "
             "frame-ancestors 'none'",
             script, style);
}

static bool add(struct static_files *files, const char *name, const char *type, struct blob *blob)
{
    if (!blob)
        return false;
    struct static_file *file = &files->file[files->count++];
    snprintf(file->name, sizeof file->name, "%s", name);
    file->type = type;
    file->blob = blob;
    pen_http_etag(&blob->content, file->etag);
    /* Compressed now, since later a thread of connections would do it. */
    if (strcmp(type, "image/png") != 0)
        blob->gzip = pen_http_blob_gzip(blob);
    return true;
}

static struct blob *copy(const void *data, size_t bytes)
{
    struct pen_buf content = {0};
    pen_buf_add(&content, data, bytes);
    return pen_http_blob_take(&content);
}

static const char *type_of(const char *name)
{
    static const char *const types[][2] = {{".html", "text/html; charset=utf-8"},
                                           {".css", "text/css; charset=utf-8"},
                                           {".js", "text/javascript; charset=utf-8"},
                                           {".svg", "image/svg+xml"},
                                           {".yaml", "application/yaml"},
                                           {".png", "image/png"},
                                           {".json", "application/json"}};
    const char *ending = strrchr(name, '.');
    for (size_t i = 0; ending && i < sizeof types / sizeof types[0]; i++) {
        if (strcmp(ending, types[i][0]) == 0)
            return types[i][1];
    }
    return "application/octet-stream";
}

/* Adds the files of a table. The name of their folder is put before their names. */
static bool add_table(struct static_files *files, const struct pen_embedded_file *file,
                      const char *folder)
{
    for (; file->name; file++) {
        char name[64];
        const char *type = type_of(file->name);
        snprintf(name, sizeof name, "%s%s", folder, file->name);
        if (!add(files, name, type, copy(file->data, file->bytes)))
            return false;
        if (strncmp(type, "text/html", 9) == 0)
            files->file[files->count - 1].policy = files->page_policy;
    }
    return true;
}

static bool add_builtin_scenes(struct static_files *files)
{
    for (size_t i = 0; i < pen_builtin_count(); i++) {
        char name[64];
        size_t bytes;
        snprintf(name, sizeof name, "scenes/%s", pen_builtin_name(i));
        const char *text = pen_builtin_text(i, &bytes);
        if (!add(files, name, "application/json", copy(text, bytes)))
            return false;
    }
    json_t *list = pen_jobs_scenes();
    bool ok = list && add(files, "scenes", "application/json", pen_http_blob_json(list));
    json_decref(list);
    return ok;
}

static size_t count_of(const struct pen_embedded_file *table)
{
    size_t count = 0;
    while (table[count].name)
        count++;
    return count;
}

struct static_files *pen_http_static_files_new(struct pen_status *st)
{
    const size_t count =
        1 + pen_builtin_count() + count_of(pen_api_files) + count_of(pen_page_files);
    struct static_files *files = calloc(1, sizeof *files + count * sizeof files->file[0]);
    if (files)
        write_page_policy(files);
    if (files && add_table(files, pen_api_files, "") && add_table(files, pen_page_files, "page/") &&
        add_builtin_scenes(files))
        return files;
    pen_http_static_files_free(files);
    pen_fail(st, PEN_NO_MEMORY, "no memory for the built-in files");
    return NULL;
}

void pen_http_static_files_free(struct static_files *files)
{
    for (size_t i = 0; files && i < files->count; i++)
        pen_http_blob_unref(files->file[i].blob);
    free(files);
}

const struct static_file *pen_http_static_files_find(const struct static_files *files,
                                                     const char *name)
{
    for (size_t i = 0; i < files->count; i++) {
        if (strcmp(files->file[i].name, name) == 0)
            return &files->file[i];
    }
    return NULL;
}

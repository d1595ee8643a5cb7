/* SPDX-License-Identifier: MIT */
/* The files and their entity tags are made once, from what the program carries inside itself. */
#include "http/internal/statics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "io/builtin.h"
#include "jobs/jobs.h"

struct statics {
    size_t count;
    struct static_file file[];
};

static bool add(struct statics *statics, const char *name, const char *type, struct blob *blob)
{
    if (!blob)
        return false;
    struct static_file *file = &statics->file[statics->count++];
    snprintf(file->name, sizeof file->name, "%s", name);
    file->type = type;
    file->blob = blob;
    pen_http_blob_etag(blob, file->etag);
    return true;
}

static struct blob *copy(const void *data, size_t bytes)
{
    struct pen_buf content = {0};
    pen_buf_add(&content, data, bytes);
    return pen_http_blob_take(&content);
}

static bool add_api_files(struct statics *statics)
{
    for (const struct pen_embedded_file *file = pen_api_files; file->name; file++) {
        const char *type = strstr(file->name, ".yaml") ? "application/yaml" : "application/json";
        if (!add(statics, file->name, type, copy(file->data, file->bytes)))
            return false;
    }
    return true;
}

static bool add_builtin_scenes(struct statics *statics)
{
    for (size_t i = 0; i < pen_builtin_count(); i++) {
        char scene[48], name[64];
        size_t bytes;
        snprintf(name, sizeof name, "scenes/%s", pen_builtin_name(i, scene, sizeof scene));
        const char *text = pen_builtin_text(i, &bytes);
        if (!add(statics, name, "application/json", copy(text, bytes)))
            return false;
    }
    json_t *list = pen_jobs_scenes();
    bool ok = list && add(statics, "scenes", "application/json", pen_http_blob_json(list));
    json_decref(list);
    return ok;
}

struct statics *pen_http_statics_new(struct pen_status *st)
{
    size_t count = 1 + pen_builtin_count();
    for (const struct pen_embedded_file *file = pen_api_files; file->name; file++)
        count++;
    struct statics *statics = calloc(1, sizeof *statics + count * sizeof statics->file[0]);
    if (statics && add_api_files(statics) && add_builtin_scenes(statics))
        return statics;
    pen_http_statics_free(statics);
    pen_fail(st, PEN_NO_MEMORY, "no memory for the built-in files");
    return NULL;
}

void pen_http_statics_free(struct statics *statics)
{
    for (size_t i = 0; statics && i < statics->count; i++)
        pen_http_blob_unref(statics->file[i].blob);
    free(statics);
}

const struct static_file *pen_http_statics_find(const struct statics *statics, const char *name)
{
    for (size_t i = 0; i < statics->count; i++) {
        if (strcmp(statics->file[i].name, name) == 0)
            return &statics->file[i];
    }
    return NULL;
}

/* SPDX-License-Identifier: MIT */
/* Model files by names inside a folder. No link may lead out of it: a scene from elsewhere then
 * shows no file that it should not. */
#include "cmd/model_files.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "cmd/files.h"

const char *const pen_model_ups[] = {"y", "z", NULL};

/* `self` is the folder's path without links. */
static bool fetch(void *self, const char *name, struct pen_buf *out, struct pen_status *st)
{
    const char *folder = self;
    const size_t length = strlen(folder);
    char real[PATH_MAX];
    struct pen_buf path = {0};
    if (!pen_buf_printf(&path, "%s/%s", folder, name))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    bool ok = realpath((const char *)path.data, real) != NULL;
    if (!ok)
        pen_fail(st, errno == ENOENT || errno == ENOTDIR ? PEN_NOT_FOUND : PEN_IO,
                 "cannot open \"%.100s\": %s", name, strerror(errno));
    else if (strncmp(real, folder, length) != 0 || (real[length] != '/' && length > 1))
        ok = pen_fail(st, PEN_FORBIDDEN, "\"%.100s\" is a link that leads out of the folder", name);
    ok = ok && pen_file_read(real, 0, out, st);
    pen_buf_release(&path);
    return ok;
}

bool pen_model_files_open(const char *scene, const struct pen_model_options *options,
                          struct pen_models *models, struct pen_status *st)
{
    const char *slash = scene ? strrchr(scene, '/') : NULL;
    char *folder =
        slash ? strndup(scene, slash > scene ? (size_t)(slash - scene) : 1) : strdup(".");
    *models = (struct pen_models){.fetch = fetch,
                                  .max_triangles = options ? (uint32_t)options->max_triangles : 0};
    models->self = folder ? realpath(folder, NULL) : NULL;
    if (!folder)
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
    else if (!models->self)
        pen_fail(st, errno == ENOENT ? PEN_NOT_FOUND : PEN_IO, "cannot open %s: %s", folder,
                 strerror(errno));
    free(folder);
    return models->self != NULL;
}

void pen_model_files_release(struct pen_models *models)
{
    pen_models_release(models);
    free(models->self);
    models->self = NULL;
}

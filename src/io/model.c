/* SPDX-License-Identifier: MIT */
/* The door to the readers of models. */
#include "io/model.h"

#include <stdlib.h>
#include <strings.h>

#include "io/mesh/build.h"

/* The limits of a file: these, and as many more for each byte. */
enum { MEMORY = 1 << 20, MEMORY_PER_BYTE = 4, STEPS = 30000000, STEPS_PER_BYTE = 3 };

enum pen_model_kind pen_model_kind_of_name(const char *name)
{
    static const char *const ends[] = {"", ".ply", ".obj", ".stl"};
    const char *dot = strrchr(name, '.');
    for (int i = 1; dot && i < 4; i++)
        if (strcasecmp(dot, ends[i]) == 0)
            return (enum pen_model_kind)i;
    return PEN_MODEL_NONE;
}

bool pen_model_name_is_inside(const char *name)
{
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (part[0] == '.' && part[1] == '.' && (part[2] == '/' || part[2] == '\0'))
            return false;
    }
    return name[0] != '\0' && name[0] != '/';
}

/* By enum pen_model_kind. */
static bool (*const readers[])(struct pen_build *) = {NULL, pen_ply_read, pen_obj_read,
                                                      pen_stl_read};

bool pen_model_read(const struct pen_model_file *file, struct pen_model *model,
                    struct pen_errors *notes, struct pen_status *st)
{
    const char *text = file->bytes > 0 ? file->data : "";
    struct pen_build b = {.file = file,
                          .m = model,
                          .notes = notes,
                          .scan = {text, text, text + file->bytes, false, st},
                          .left = MEMORY + MEMORY_PER_BYTE * file->bytes,
                          .steps = STEPS + STEPS_PER_BYTE * (int64_t)file->bytes,
                          .limit = file->max_triangles ? file->max_triangles : PEN_MODEL_TRIANGLES};
    *model = (struct pen_model){0};
    if (file->bytes >> 33)
        return pen_fail(st, PEN_TOO_LARGE, "The file has more than 8 GiB");
    if (file->kind == PEN_MODEL_NONE)
        return pen_fail(st, PEN_UNSUPPORTED, "Models are .ply, .obj or .stl files");
    const bool ok = readers[file->kind](&b) && pen_build_finish(&b);
    pen_build_release(&b);
    if (!ok)
        pen_model_release(model);
    return ok;
}

void pen_model_release(struct pen_model *model)
{
    free(model->vertex);
    free(model->corner);
    free(model->normal);
    free(model->corner_normal);
    free(model->material_of);
    free(model->material);
    *model = (struct pen_model){0};
}

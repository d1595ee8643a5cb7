/* SPDX-License-Identifier: MIT */
/* The model files of a scene on this machine: those in the scene's folder and below. */
#ifndef PEN_CMD_MODEL_FILES_H
#define PEN_CMD_MODEL_FILES_H

#include "io/models.h"

/* What the command line says about models. */
struct pen_model_options {
    const char *up;    /* "y" or "z"; NULL: by the kind of file */
    int max_triangles; /* 0: PEN_MODEL_TRIANGLES */
};
extern const char *const pen_model_ups[];

#define PEN_MODEL_OPTIONS(values)                                                                  \
    {.name = "up",                                                                                 \
     .kind = PEN_OPTION_CHOICE,                                                                    \
     .offset = offsetof(values, model.up),                                                         \
     .value = "y|z",                                                                               \
     .choices = pen_model_ups,                                                                     \
     .help = "the axis that is up in a model; z of .stl, else y by default"},                      \
    {                                                                                              \
        .name = "max-triangles", .kind = PEN_OPTION_INT,                                           \
        .offset = offsetof(values, model.max_triangles), .value = "N", .min = 1,                   \
        .max = PEN_MODEL_TRIANGLES_MAX,                                                            \
        .help = "the most triangles of a model file, 20000000 by default"                          \
    }

/* Makes the files beside `scene`, a path, available; NULL: those of the working folder.
 * Owns: the caller calls pen_model_files_release.
 * Fails: PEN_IO, PEN_NO_MEMORY. */
bool pen_model_files_open(const char *scene, const struct pen_model_options *options,
                          struct pen_models *models, struct pen_status *st);
void pen_model_files_release(struct pen_models *models);

#endif

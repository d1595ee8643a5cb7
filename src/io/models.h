/* SPDX-License-Identifier: MIT */
/* The model files of scenes: an object {"type": "mesh", "file": NAME} names one. Nothing here opens
 * a file; the program gives a callback for the bytes, and a program without it refuses `file`.
 *
 * A model alone is a scene, too: pen_models_scene writes it.
 *
 * Threads: one at a time. */
#ifndef PEN_IO_MODELS_H
#define PEN_IO_MODELS_H

#include "io/model.h"

struct pen_models {
    pen_model_fetch
        *fetch; /* for models and their MTL; names are paths inside the scene's folder */
    void *self;
    uint32_t max_triangles; /* 0: PEN_MODEL_TRIANGLES */
    /* The model of pen_models_scene, which the next pen_models_read of that name takes. */
    char *known_name;
    struct pen_model known;
    struct pen_errors *known_notes;
};

/* Reads the model of a file. Warnings are added to notes, with code PEN_OK.
 * Owns: the caller calls pen_model_release.
 * Fails: PEN_UNSUPPORTED (the name ends in none of .ply, .obj, .stl), PEN_FORBIDDEN (it leads out
 * of the folder), or as the callback and pen_model_read. */
bool pen_models_read(struct pen_models *models, const char *name, struct pen_model *model,
                     struct pen_errors *notes, struct pen_status *st);

/* Appends a scene that shows the model, as JSON. The camera looks from the front right above. The
 * model's bounding sphere just fits its field of view of 40 degrees. A key light casts shadows, and
 * a fill light does not. The material is grey, unless the model has materials.
 * `up` is the axis that is up in the model, 'y' or 'z'; 0: z of STL, else y.
 * Fails: as pen_models_read; PEN_INVALID for a name that is not UTF-8. */
bool pen_models_scene(struct pen_models *models, const char *name, char up, struct pen_buf *out,
                      struct pen_status *st);

/* Frees what is kept; the struct may then be used again. */
void pen_models_release(struct pen_models *models);

#endif

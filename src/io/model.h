/* SPDX-License-Identifier: MIT */
/* Models: meshes of triangles from files in memory: PLY, OBJ with MTL, and binary or ASCII STL.
 * Nothing here opens a file; a callback gives the bytes of an MTL.
 *
 * Every vertex is finite and every index is in range. Every triangle has three different corners
 * and an area, decided exactly. A float of the file stays as it is. A decimal becomes the nearest
 * float. Only if the model is far from the origin of its coordinates, compared with its size, the
 * vertices are relative to `shift`, and each is rounded once.
 *
 * Memory: at most 4 times the bytes of the files, and 1 MiB. Time: proportional to the bytes. */
#ifndef PEN_IO_MODEL_H
#define PEN_IO_MODEL_H

#include "base/buf.h"
#include "base/status.h"
#include "geom/mesh.h"

enum pen_model_kind { PEN_MODEL_NONE, PEN_MODEL_PLY, PEN_MODEL_OBJ, PEN_MODEL_STL };

enum {
    PEN_MODEL_TRIANGLES = 20000000,         /* the default of max_triangles */
    PEN_MODEL_TRIANGLES_MAX = (1 << 26) - 1 /* an acceleration structure holds no more */
};

struct pen_model_material {
    float diffuse[3], specular[3], emission[3]; /* Kd, by default grey; Ks; Ke */
    float shininess, opacity, ior; /* Ns, by default 1; d (1 - Tr), by default 1; Ni, else 0 */
};

struct pen_model {
    double shift[3];    /* a vertex is at shift + vertex; 0 for nearly all files */
    float (*vertex)[3]; /* also those that no triangle uses */
    uint32_t vertex_count;
    uint32_t (*corner)[3];
    uint32_t triangle_count;
    float (*normal)[3]; /* finite, of any length, also 0; NULL: none */
    uint32_t normal_count;
    /* NULL: vertex i has normal i, if there are normals. PEN_NO_NORMAL: the corner has none. */
    uint32_t (*corner_normal)[3];
    uint16_t *material_of; /* of each triangle; NULL: all have the first, if there is one */
    struct pen_model_material *material; /* those that triangles use */
    uint32_t material_count;
    /* What the notes tell in words. */
    uint32_t flat;       /* triangles without area; left out */
    uint32_t repeated;   /* faces with a corner twice in a row; left out if fewer than 3 remain */
    uint32_t open_edges; /* edges of one triangle */
    uint32_t crowded_edges; /* edges of three or more */
};

/* Whether a name is a path inside a folder: relative, with / between folders, without "..". */
bool pen_model_name_is_inside(const char *name);

/* Appends the bytes of the file `name` to `out`. The name is a path inside the model's folder. The
 * callback must refuse a link that leads out of it, and limit the size.
 * Fails: returns false. *st says why. */
typedef bool pen_model_fetch(void *self, const char *name, struct pen_buf *out,
                             struct pen_status *st);

struct pen_model_file {
    const void *data; /* borrowed */
    size_t bytes;
    enum pen_model_kind kind;
    uint32_t max_triangles; /* 0: PEN_MODEL_TRIANGLES */
    pen_model_fetch *fetch; /* NULL: a file that names an MTL is refused */
    void *self;
};

/* The kind of a file by the end of its name, in upper or lower case; PEN_MODEL_NONE if unknown. */
enum pen_model_kind pen_model_kind_of_name(const char *name);

/* Reads a model. Warnings are added to notes, with code PEN_OK, and where they have a place, its
 * line. Decimals are read in the locale "C".
 * Owns: the caller calls pen_model_release, also after a failure.
 * Fails: PEN_SYNTAX with line and column, or with a byte's offset in the message; PEN_INVALID;
 * PEN_UNSUPPORTED; PEN_TOO_LARGE; PEN_NO_MEMORY; or as `fetch`. The model is then empty. */
bool pen_model_read(const struct pen_model_file *file, struct pen_model *model,
                    struct pen_errors *notes, struct pen_status *st);

/* Frees the arrays and leaves an empty model; {0} is one. */
void pen_model_release(struct pen_model *model);

#endif

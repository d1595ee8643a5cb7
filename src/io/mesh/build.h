/* SPDX-License-Identifier: MIT */
/* The part that the readers of models share: memory with a limit, the shift of far models, and
 * faces to triangles. */
#ifndef PEN_IO_MESH_BUILD_H
#define PEN_IO_MESH_BUILD_H

#include "io/mesh/scan.h"
#include "io/model.h"
#include "math/vec3.h"

struct pen_build {
    const struct pen_model_file *file;
    struct pen_model *m;
    struct pen_errors *notes;
    struct pen_scan scan;
    size_t left;         /* bytes that may still be allocated */
    int64_t steps;       /* of slow decisions that may still be made, some 4 ns each */
    uint32_t limit;      /* of triangles */
    uint32_t space;      /* for triangles, in the model's arrays */
    double lo[3], hi[3]; /* of the coordinates in the file */
    bool doubles;        /* the file has doubles, not floats or decimals */
    double lost;         /* by the rounding of coordinates to floats, the most of one */
    uint16_t material;   /* of the next face */
    /* The face that is read: its corners, and their normals if has_normals is set. */
    uint32_t *face, *face_normal;
    uint32_t face_count, face_space;
    struct pen_vec3 *point; /* of the face that is cut */
    uint32_t (*piece)[3];
    uint32_t point_space;
};

/* Memory within the limit. Several arrays may be freed in any order; `bytes` is as allocated.
 * Fails: NULL with *st. */
void *pen_build_alloc(struct pen_build *b, uint64_t count, size_t size);
void *pen_build_zeroed(struct pen_build *b, uint64_t count, size_t size);
void pen_build_free(struct pen_build *b, void *memory, uint64_t count, size_t size);

/* Makes an array longer, for `need` elements or more. *space is that of *array. */
bool pen_build_grow(struct pen_build *b, void **array, uint32_t *space, uint64_t need, size_t size);

/* Adds a warning; `at` is its place, or NULL. */
void pen_build_note(struct pen_build *b, const char *at, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Takes steps from those that are left. Returns false, with an error at `at`, if too few are. */
bool pen_build_steps(struct pen_build *b, const char *at, int64_t steps);

/* Before all coordinates are read: forgets their bounds. */
void pen_build_begin_vertices(struct pen_build *b);

/* Makes a vertex of three numbers of the file. */
void pen_build_vertex(struct pen_build *b, const struct pen_number x[3], float out[3]);

/* After all coordinates: returns true if the model is far from the origin and has no shift yet. Its
 * shift is then set, and the coordinates must be read again. */
bool pen_build_far(struct pen_build *b);

/* After all faces: the same for the vertices of triangles, since others may be anywhere. If it
 * returns true, the triangles are forgotten, and vertices and faces must be read again. */
bool pen_build_faces_far(struct pen_build *b);

/* Takes memory for triangles, after counting them. With `materials`, also for their materials.
 * Fails: returns false if there are none, or too many. */
bool pen_build_space(struct pen_build *b, uint64_t triangles, bool materials);

/* Makes space for `count` corners of the face at `at`, not fewer than it has. */
bool pen_build_corners(struct pen_build *b, const char *at, uint32_t count);

/* Appends a corner to the face that is read at `at`. */
static inline bool pen_build_corner(struct pen_build *b, const char *at, uint32_t vertex)
{
    if (b->face_count == b->face_space && !pen_build_corners(b, at, b->face_count + 1))
        return false;
    b->face[b->face_count++] = vertex;
    return true;
}

/* Cuts the face that is read into triangles and adds those that have an area. */
bool pen_build_face(struct pen_build *b, const char *at);

/* After all faces: counts edges and adds the warnings. */
bool pen_build_finish(struct pen_build *b);

/* Frees what is needed only while a file is read. */
void pen_build_release(struct pen_build *b);

/* Counts the edges of one triangle and of three or more (edges.c). Edges are the same if their ends
 * are at the same places. */
bool pen_build_edges(struct pen_build *b);

/* A table of vertices by their place; {0} is empty. Its hash has a random key, so that no file can
 * make it slow. The key changes no result. */
struct pen_weld {
    uint32_t *slot; /* a vertex's number + 1, or 0 */
    uint32_t mask, used;
    uint64_t key[2];
};

/* The first vertex of the model at the place of `vertex`, one of its vertices, which is added to
 * the table if there is none. -0 is 0.
 * Fails: returns UINT32_MAX with *st. */
uint32_t pen_weld_vertex(struct pen_weld *w, struct pen_build *b, uint32_t vertex);

void pen_weld_release(struct pen_weld *w, struct pen_build *b);

/* The readers. */
bool pen_ply_read(struct pen_build *b);
bool pen_obj_read(struct pen_build *b);
bool pen_stl_read(struct pen_build *b);

#endif

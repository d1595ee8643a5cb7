/* SPDX-License-Identifier: MIT */
/* The header of a PLY file: what its elements are made of.
 * Source: Turk, "The PLY polygon file format", 1994. */
#ifndef PEN_IO_MESH_PLY_H
#define PEN_IO_MESH_PLY_H

#include "io/mesh/build.h"

enum pen_ply_type { PLY_I8, PLY_U8, PLY_I16, PLY_U16, PLY_I32, PLY_U32, PLY_F32, PLY_F64 };

enum { PLY_ELEMENTS = 16, PLY_PROPERTIES = 192 };

/* The part of a property; the numbers of the first six are indices of coordinates. */
enum pen_ply_role { PLY_X, PLY_Y, PLY_Z, PLY_NX, PLY_NY, PLY_NZ, PLY_CORNERS, PLY_SKIPPED };

struct pen_ply_property {
    enum pen_ply_type type, count_type;
    enum pen_ply_role role;
    bool list;
};

struct pen_ply_element {
    const char *name; /* in the file */
    size_t name_length;
    uint32_t count, first, properties;
    uint32_t bytes; /* of one in a binary file, with empty lists */
    bool lists;     /* it has lists */
    unsigned roles; /* one bit per role */
    const char *start;
};

struct pen_ply {
    struct pen_build *b;
    bool binary, swapped; /* swapped: the other byte order than this machine's */
    struct pen_ply_element element[PLY_ELEMENTS];
    struct pen_ply_property property[PLY_PROPERTIES];
    uint32_t elements, properties;
    struct pen_ply_element *vertices, *faces;
};

/* The size in bytes. */
static inline uint32_t pen_ply_size(enum pen_ply_type type)
{
    return 1u << (type < PLY_F32 ? (unsigned)type / 2 : (unsigned)type - 4);
}

/* Reads the header and moves to the data. */
bool pen_ply_header(struct pen_ply *ply);

#endif

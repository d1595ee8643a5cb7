/* SPDX-License-Identifier: MIT */
/* The part that the targets for models share. */
#ifndef PEN_TESTS_FUZZ_MODEL_H
#define PEN_TESTS_FUZZ_MODEL_H

#include <math.h>

#include "fuzz/fuzz.h"
#include "io/model.h"

/* Checks what src/io/model.h promises of every model. */
static inline void check_model(const struct pen_model *m)
{
    const uint32_t normals = m->normal_count;
    must(m->triangle_count > 0 && m->vertex_count > 2);
    for (uint32_t i = 0; i < 3 * m->vertex_count; i++)
        must(isfinite(m->vertex[i / 3][i % 3]));
    for (uint32_t i = 0; i < 3 * normals; i++)
        must(isfinite(m->normal[i / 3][i % 3]));
    must(m->corner_normal || normals == 0 || normals == m->vertex_count);
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *c = m->corner[t];
        must(c[0] != c[1] && c[1] != c[2] && c[2] != c[0]);
        for (int i = 0; i < 3; i++) {
            must(c[i] < m->vertex_count);
            must(!m->corner_normal || m->corner_normal[t][i] == PEN_NO_NORMAL ||
                 m->corner_normal[t][i] < normals);
        }
        must(!m->material_of || m->material_of[t] < m->material_count);
    }
    for (uint32_t i = 0; i < m->material_count; i++) {
        const struct pen_model_material *is = &m->material[i];
        for (int k = 0; k < 3; k++)
            must(is->diffuse[k] >= 0 && is->diffuse[k] <= 1 && is->specular[k] >= 0 &&
                 is->specular[k] <= 1 && is->emission[k] >= 0);
        must(is->shininess >= 0 && is->ior >= 0 && is->opacity >= 0 && is->opacity <= 1);
    }
    must(isfinite(m->shift[0]) && isfinite(m->shift[1]) && isfinite(m->shift[2]));
    must(m->open_edges + 2 * m->crowded_edges <= 3 * m->triangle_count);
}

/* Reads bytes as a model. Checks what is read, or that an error has a code and a message. */
static inline void read_model(const uint8_t *data, size_t size, enum pen_model_kind kind,
                              pen_model_fetch *fetch, void *self)
{
    const struct pen_model_file file = {data, size, kind, 100000, fetch, self};
    struct pen_errors notes = {0};
    struct pen_status st = {0};
    struct pen_model m;
    if (pen_model_read(&file, &m, &notes, &st))
        check_model(&m);
    else
        must(st.code != PEN_OK && st.msg[0] && !m.vertex && !m.corner && !m.material);
    for (size_t i = 0; i < notes.count; i++)
        must(notes.item[i].code == PEN_OK && notes.item[i].msg[0]);
    pen_model_release(&m);
}

#endif

/* SPDX-License-Identifier: MIT */
/* The rows of a report as cells of text, to be laid out as a table. */
#ifndef PEN_STUDY_INTERNAL_GRID_H
#define PEN_STUDY_INTERNAL_GRID_H

#include "study/internal/read.h"

struct pen_grid {
    size_t rows, columns; /* row 0 has the titles */
    struct pen_buf *cell; /* cell[row * columns + column], neither escaped nor aligned */
    bool *words;          /* by column: it holds words, so it is set flush left */
};

/* Makes the grid of a report: the row's number, its settings, and the columns asked for.
 * Returns false when out of memory. Owns: release it in any case. */
bool pen_grid_make(const json_t *report, const struct pen_column *columns, struct pen_grid *grid);
void pen_grid_release(struct pen_grid *grid);

/* The text of a cell. */
const char *pen_grid_text(const struct pen_grid *grid, size_t row, size_t column);

#endif

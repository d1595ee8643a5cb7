/* SPDX-License-Identifier: MIT */
/* The functions of the rows, by file. */
#ifndef TESTS_PROPERTY_ROWS_H
#define TESTS_PROPERTY_ROWS_H

#include "property/row.h"

/* rows_watertight.c */
void rows_bumpy(struct pen_row_run *run);
void rows_sheet(struct pen_row_run *run);

/* rows_round.c */
void rows_sphere_roots(struct pen_row_run *run);
void rows_sphere_grazing(struct pen_row_run *run);
void rows_tube_roots(struct pen_row_run *run);
void rows_tube_grazing(struct pen_row_run *run);
void rows_tube_far(struct pen_row_run *run);
void rows_cylinder_roots(struct pen_row_run *run);
void rows_cylinder_caps(struct pen_row_run *run);
void rows_cylinder_grazing(struct pen_row_run *run);
void rows_oracle(struct pen_row_run *run);

#endif

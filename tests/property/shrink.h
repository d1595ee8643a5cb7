/* SPDX-License-Identifier: MIT */
/* Makes a failing case as simple as possible while it still fails. */
#ifndef TESTS_PROPERTY_SHRINK_H
#define TESTS_PROPERTY_SHRINK_H

#include "property/row.h"

/* Tries zeros, whole numbers and halved mantissas for each argument, until none helps or the limit
 * of tries is reached. why[ROW_WHY] becomes the reason of the simplest form. */
void shrink_case(struct row_case *c, row_judge_fn *judge, char *why);

#endif

/* SPDX-License-Identifier: MIT */
/* The rows, in the order of the catalogue: seven tables, one after the other. */
#include <stddef.h>

#include "property/rows.h"

static const struct row *const tables[] = {row_table_flat,  row_table_space, row_table_same,
                                           row_table_light, row_table_rooms, row_table_roots,
                                           row_table_cone};

const struct row *row_at(int i)
{
    for (size_t k = 0; k < sizeof tables / sizeof tables[0]; k++)
        for (const struct row *row = tables[k]; row->id; row++)
            if (i-- == 0)
                return row;
    return NULL;
}

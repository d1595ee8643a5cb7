/* SPDX-License-Identifier: MIT */
/* The table of the driver's operations. */
#include "store/sqlite/sqlite.h"

#define ENTRY(name) .name = pen_sqlite_##name,
#define COUNT(name) +1

const struct pen_driver_ops *pen_sqlite_ops(void)
{
    static const struct pen_driver_ops ops = {PEN_SQLITE_OPS(ENTRY)};
    _Static_assert((0 PEN_SQLITE_OPS(COUNT)) * sizeof(void (*)(void)) == sizeof ops,
                   "an operation is missing in PEN_SQLITE_OPS");
    return &ops;
}

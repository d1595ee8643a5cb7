/* SPDX-License-Identifier: MIT */
/* The tables of a store: schema.sql, embedded by the build. */
#ifndef PEN_STORE_INTERNAL_SCHEMA_H
#define PEN_STORE_INTERNAL_SCHEMA_H

#include "base/embed.h"

/* Grows with every change of schema.sql. A build opens stores of its own version alone. */
enum { PEN_SCHEMA_VERSION = 18 };

extern const struct pen_embedded_file pen_store_schema[];

#endif

/* SPDX-License-Identifier: MIT */
/* The same bits in every way of rendering: H096 and H100 to H105. Cases that need other builds or
 * other processes (H101's killed worker, H103, H104) are in matrix.sh. */
#include <stddef.h>

#include "property/rows.h"

static const char golden[] = "tests/golden/hashes.txt, bit for bit";

/* More than there are films and ways; the rest is no case. */
enum { ALL = 1200 };

const struct row row_table_same[] = {
    {
        .id = "H096",
        .name = "h096_accelerators",
        .what = "every golden film with every accelerator: auto, none, cbr, manual, median",
        .oracle = golden,
        .run = rows_films_accelerators,
        .full = ALL,
        .check = 20,
    },
    {
        .id = "H100",
        .name = "h100_threads",
        .what = "every golden film with 1, 2, 3, 8 and 64 threads",
        .oracle = golden,
        .run = rows_films_threads,
        .full = ALL,
        .check = 20,
    },
    {
        .id = "H101",
        .name = "h101_tiles",
        .what = "every golden film in tiles of 1, 7, 32 and one for all, in tiles in a random "
                "order, and cancelled in the middle and resumed",
        .oracle = golden,
        .run = rows_films_tiles,
        .full = ALL,
        .check = 20,
    },
    {
        .id = "H102",
        .name = "h102_instructions",
        .what = "every golden film with baseline, AVX2 and AVX-512 instructions, baseline with "
                "every accelerator",
        .oracle = golden,
        .run = rows_films_sets,
        .full = ALL,
        .check = 20,
    },
    {
        .id = "H103",
        .name = "h103_films",
        .what = "every golden film, as this build renders it",
        .oracle = golden,
        .run = rows_films_plain,
        .full = ALL,
        .check = 4,
    },
    {
        .id = "H096 H100 H101 H102",
        .name = "scenes_same",
        .what = "random scenes of primitives of every kind, many of which touch or coincide: the "
                "same film and numbers of rays with every accelerator and instruction set, in "
                "blocks and pixel by pixel, with 1 and 3 threads, in tiles of 5, 16 and 64; and "
                "with packets the same binary64 values before they are rounded",
        .oracle = "base instructions, pixel by pixel, bit for bit",
        .run = rows_scenes_same,
        .full = 2000,
        .check = 12,
    },
    {
        .id = "H105",
        .name = "h105_mxcsr",
        .what = "every golden film made by a thread that flushes subnormals, treats them as 0, or "
                "rounds down, up or to zero, and so do the threads that it starts",
        .oracle = golden,
        .run = rows_films_states,
        .full = ALL,
        .check = 60,
    },
    {.id = NULL},
};

/* SPDX-License-Identifier: MIT */
/* Prints a scene of the benchmarks as JSON.
 *
 * usage: make_scene NAME [SIZE]
 *        make_scene --list       the names, with the default size of each */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/scenes/haines.h"
#include "bench/scenes/parlour.h"

static const struct {
    const char *name;
    void (*print)(int size);
    int size;
} scenes[] = {
    {"balls", haines_balls, 4},
    {"gears", haines_gears, 4},
    {"lattice", haines_lattice, 12},
    {"mount", haines_mount, 6},
    {"rings", haines_rings, 7},
    {"teapot", haines_teapot, 12},
    {"tetra", haines_tetra, 6},
    {"parlour", parlour_hard, 1},
    {"soft-room", parlour_soft, 1},
    {"field", field, 10000},
    {"row", row, 9},
    {"tubes", tubes, 9},
    {"cones", cones, 9},
};

int main(int argc, char **argv)
{
    size_t count = sizeof scenes / sizeof *scenes;
    for (size_t i = 0; i < count && argc > 1; i++) {
        if (!strcmp(argv[1], "--list"))
            printf("%s %d\n", scenes[i].name, scenes[i].size);
        if (strcmp(argv[1], scenes[i].name) != 0)
            continue;
        int size = argc > 2 ? atoi(argv[2]) : scenes[i].size;
        if (size < 1)
            break;
        scenes[i].print(size);
        return fflush(stdout) ? 1 : 0;
    }
    if (argc > 1 && !strcmp(argv[1], "--list"))
        return 0;
    fprintf(stderr, "usage: make_scene NAME [SIZE] | --list\n");
    return 2;
}

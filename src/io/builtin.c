/* SPDX-License-Identifier: MIT */
/* Reads pen_builtin_files, the table that the build makes from the directory scenes. */
#include "io/builtin.h"

#include <string.h>

#include "base/embed.h"
#include "io/message.h"

size_t pen_builtin_count(void)
{
    size_t count = 0;
    while (pen_builtin_files[count].name)
        count++;
    return count;
}

const char *pen_builtin_name(size_t i)
{
    return pen_builtin_files[i].name;
}

const char *pen_builtin_text(size_t i, size_t *bytes)
{
    *bytes = pen_builtin_files[i].bytes;
    return (const char *)pen_builtin_files[i].data;
}

static const struct {
    const char *name, *line;
} summaries[] = {
    {"forest", "a lake in a birch wood at dusk; groups in groups, a wide mirror"},
    {"glass", "a drink, a ball, a prism and a diamond: refraction, solids in solids"},
    {"gloss", "brushed steel, gold and lacquer, frosted glass: blurred rays"},
    {"lens", "lanterns along a pier at dusk: depth of field, in three views"},
    {"patterns", "a game of chess: checkers and gradients on surfaces, under a sky"},
    {"room", "495 primitives and three point lights; all hard shadows"},
    {"room-soft", "the room with lights that have a radius, 64 shadow rays to each"},
    {"soft-shadow", "a box, a sphere and a cylinder under one disk light"},
    {"spheres", "the smallest scene with glass and a mirror"},
    {"teapot", "a teapot of 1424 triangles among 441 marbles"},
};

const char *pen_builtin_summary(size_t i)
{
    for (size_t k = 0; k < sizeof summaries / sizeof summaries[0]; k++) {
        if (strcmp(summaries[k].name, pen_builtin_name(i)) == 0)
            return summaries[k].line;
    }
    return pen_builtin_name(i);
}

const char *pen_builtin_find(const char *name, size_t *bytes)
{
    for (size_t i = 0; pen_builtin_files[i].name; i++) {
        if (strcmp(pen_builtin_files[i].name, name) == 0)
            return pen_builtin_text(i, bytes);
    }
    return NULL;
}

const char *pen_builtin_nearest(const char *name)
{
    enum { NAMES_MAX = 64 }; /* scenes after these are not suggested */
    const char *names[NAMES_MAX + 1];
    size_t count = 0;
    for (; count < NAMES_MAX && pen_builtin_files[count].name; count++)
        names[count] = pen_builtin_files[count].name;
    names[count] = NULL;
    return pen_nearest_name(name, names);
}

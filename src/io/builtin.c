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

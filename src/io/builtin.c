/* SPDX-License-Identifier: MIT */
/* The built-in scenes: the table that the build makes of scenes/, by name without ".json". */
#include "io/builtin.h"

#include <string.h>

#include "base/embed.h"

static size_t stem_length(const char *file)
{
    const char *dot = strrchr(file, '.');
    return dot ? (size_t)(dot - file) : strlen(file);
}

size_t pen_builtin_count(void)
{
    size_t count = 0;
    while (pen_builtin_files[count].name)
        count++;
    return count;
}

const char *pen_builtin_name(size_t i, char *name, size_t name_bytes)
{
    const char *file = pen_builtin_files[i].name;
    size_t length = stem_length(file);
    if (length >= name_bytes)
        length = name_bytes - 1;
    memcpy(name, file, length);
    name[length] = '\0';
    return name;
}

const char *pen_builtin_text(size_t i, size_t *bytes)
{
    *bytes = pen_builtin_files[i].bytes;
    return (const char *)pen_builtin_files[i].data;
}

const char *pen_builtin_find(const char *name, size_t *bytes)
{
    size_t length = strlen(name);
    for (size_t i = 0; pen_builtin_files[i].name; i++) {
        const char *file = pen_builtin_files[i].name;
        if (stem_length(file) == length && memcmp(file, name, length) == 0)
            return pen_builtin_text(i, bytes);
    }
    return NULL;
}

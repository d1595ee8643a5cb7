/* SPDX-License-Identifier: MIT */
/* The valid name that a misspelt word most likely means. */
#include <stdbool.h>
#include <string.h>

#include "io/message.h"

/* Words longer than LONGEST are not compared: no key of the format is that long, and a comparison
 * takes the product of both lengths. Names farther than FARTHEST edits are not suggested. */
enum { LONGEST = 64, FARTHEST = 2 };

static char fold(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c == '-' ? '_' : c;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* The number of edits (insertions, deletions, substitutions, swaps of neighbours) from a to b.
 * Upper and lower case compare equal, as do - and _.
 * Source: the "optimal string alignment" form of Damerau, Comm. ACM 7(3), 1964. */
static int distance(const char *a, size_t na, const char *b, size_t nb)
{
    int row[3][LONGEST + 1]; /* for the prefixes of a that are two, one and zero letters shorter */
    for (size_t j = 0; j <= nb; j++)
        row[1][j] = (int)j;
    for (size_t i = 1; i <= na; i++) {
        int *before = row[(i + 2) % 3], *above = row[i % 3], *now = row[(i + 1) % 3];
        now[0] = (int)i;
        for (size_t j = 1; j <= nb; j++) {
            char x = fold(a[i - 1]), y = fold(b[j - 1]);
            now[j] = least(least(above[j] + 1, now[j - 1] + 1), above[j - 1] + (x != y));
            if (i > 1 && j > 1 && x == fold(b[j - 2]) && y == fold(a[i - 2]))
                now[j] = least(now[j], before[j - 2] + 1);
        }
    }
    return row[(na + 1) % 3][nb];
}

static bool equal(const char *a, const char *b)
{
    while (*a && fold(*a) == fold(*b))
        a++, b++;
    return fold(*a) == fold(*b);
}

/* Words that other programs use for keys of the format. A word may have several rows: the first key
 * that is a name at this place counts. */
static const struct {
    const char *word, *key;
} others[] = {
    {"fov", "fov_degrees"},
    {"fovy", "fov_degrees"},
    {"vfov", "fov_degrees"},
    {"field_of_view", "fov_degrees"},
    {"eye", "position"},
    {"origin", "position"},
    {"location", "position"},
    {"position", "center"},
    {"target", "look_at"},
    {"aperture", "aperture_radius"},
    {"lens_radius", "aperture_radius"},
    {"focal_distance", "focus_distance"},
    {"spp", "samples_per_pixel"},
    {"samples", "samples_per_pixel"},
    {"antialiasing", "samples_per_pixel"},
    {"shadow_samples", "light_samples"},
    {"depth", "max_depth"},
    {"bounces", "max_depth"},
    {"max_bounces", "max_depth"},
    {"noise_threshold", "target_error"},
    {"gamma", "transfer"},
    {"color", "intensity"},
    {"colour", "intensity"},
    {"color", "kd"},
    {"colour", "kd"},
    {"power", "intensity"},
    {"strength", "intensity"},
    {"brightness", "intensity"},
    {"angle", "angular_radius"},
    {"diffuse", "kd"},
    {"albedo", "kd"},
    {"base_color", "kd"},
    {"specular", "ks"},
    {"ambient", "ka"},
    {"emissive", "emission"},
    {"exponent", "shininess"},
    {"roughness", "reflection_blur"},
    {"glossiness", "reflection_blur"},
    {"reflection", "kr"},
    {"reflectivity", "kr"},
    {"mirror", "kr"},
    {"transmission", "kt"},
    {"transparency", "kt"},
    {"refraction", "ior"},
    {"refractive_index", "ior"},
    {"index_of_refraction", "ior"},
    {"points", "vertices"},
    {"geometry", "objects"},
    {"shapes", "objects"},
    {"children", "objects"},
    {"prio", "priority"},
    {"timeout", "timeout_seconds"},
    {"retries", "max_attempts"},
    {"tags", "labels"},
    {"settings", "render"},
};

static const char *name_of_other(const char *word, const char *const *names)
{
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if (!equal(word, others[i].word))
            continue;
        for (const char *const *name = names; *name; name++)
            if (equal(*name, others[i].key))
                return *name;
    }
    return NULL;
}

const char *pen_nearest_name(const char *word, const char *const *names)
{
    const char *nearest = name_of_other(word, names);
    int best = FARTHEST + 1;
    size_t length = strnlen(word, LONGEST + 1);
    if (nearest || length > LONGEST)
        return nearest;
    for (; *names; names++) {
        size_t other = strnlen(*names, LONGEST + 1);
        if (other > LONGEST || other > length + FARTHEST || length > other + FARTHEST)
            continue;
        int d = distance(word, length, *names, other);
        if (d < best && 2 * (size_t)d < length) {
            best = d;
            nearest = *names;
        }
    }
    return nearest;
}

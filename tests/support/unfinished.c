/* SPDX-License-Identifier: MIT */
#include "support/unfinished.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

#include "film/film.h"

static size_t picture_bytes(const struct unfinished_bed *bed)
{
    return 3 * (size_t)bed->width * (size_t)bed->height * sizeof(float);
}

static bool read_picture(void *user, int place, uint64_t hash, int width, int height, float *rgb)
{
    const struct unfinished_bed *bed = user;
    const struct pen_film film = {width, height, rgb};
    ck_assert(width == bed->width && height == bed->height);
    if (!bed->picture[place])
        return false;
    memcpy(rgb, bed->picture[place], picture_bytes(bed));
    return pen_film_hash(&film) == hash;
}

bool unfinished_keep(void *user, const struct pen_unfinished *u)
{
    struct unfinished_bed *bed = user;
    json_decref(bed->state);
    bed->state = u->state(u->study);
    ck_assert_ptr_nonnull(bed->state);
    bed->width = u->width;
    bed->height = u->height;
    for (int i = 0; i < u->picture_count; i++) {
        const struct pen_film film = {u->width, u->height, (float *)(uintptr_t)u->picture[i].rgb};
        free(bed->picture[i]);
        bed->picture[i] = NULL;
        if (!film.rgb)
            continue;
        ck_assert_uint_eq(pen_film_hash(&film), u->picture[i].hash);
        bed->picture[i] = malloc(picture_bytes(bed));
        memcpy(bed->picture[i], film.rgb, picture_bytes(bed));
    }
    bed->kept = (struct pen_kept_study){.state = bed->state, .picture = read_picture, .user = bed};
    bed->calls++;
    return bed->runs_left == 0 || --bed->runs_left > 0;
}

void unfinished_release(struct unfinished_bed *bed)
{
    json_decref(bed->state);
    for (int i = 0; i < PEN_STUDY_PICTURES_MAX; i++)
        free(bed->picture[i]);
    *bed = (struct unfinished_bed){0};
}

json_t *unfinished_changed(const json_t *state, const char *pointer, const char *value)
{
    json_t *changed = json_deep_copy(state), *at = changed;
    char path[64], *key = path + 1, *slash;
    json_t *new = json_loads(value, JSON_DECODE_ANY, NULL);
    snprintf(path, sizeof path, "%s", pointer);
    for (; (slash = strchr(key, '/')); key = slash + 1) {
        *slash = '\0';
        at = json_is_array(at) ? json_array_get(at, (size_t)atoi(key)) : json_object_get(at, key);
    }
    ck_assert_msg(new != NULL &&at != NULL, "%s: %s", pointer, value);
    if (json_is_array(at))
        ck_assert_int_eq(json_array_set_new(at, (size_t)atoi(key), new), 0);
    else
        ck_assert_int_eq(json_object_set_new(at, key, new), 0);
    return changed;
}

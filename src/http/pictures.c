/* SPDX-License-Identifier: MIT */
/* A list of kept pictures, the one used last in front. A kept picture that nobody reads goes when
 * the list is full, or when the budget is needed for another. */
#include "http/internal/pictures.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { KEPT = 64, KEY_BYTES = 300, BUDGET_BYTES = 256 << 20 };

struct kept {
    char key[KEY_BYTES];
    struct picture picture;
};

struct pictures {
    atomic_size_t budget; /* reserved, or of answers. atomic: relaxed, a sum */
    atomic_size_t beside; /* the place beside it; 0: it is free. atomic: relaxed, a sum */
    pthread_mutex_t lock;
    int count;               /* guarded by lock */
    struct kept *kept[KEPT]; /* guarded by lock */
};

struct pictures *pen_http_pictures_new(void)
{
    struct pictures *pictures = calloc(1, sizeof *pictures);
    if (pictures)
        pthread_mutex_init(&pictures->lock, NULL);
    return pictures;
}

static void drop(struct pictures *pictures, int i)
{
    struct kept *kept = pictures->kept[i];
    pictures->count--;
    memmove(&pictures->kept[i], &pictures->kept[i + 1],
            (size_t)(pictures->count - i) * sizeof(struct kept *));
    pen_http_blob_unref(kept->picture.blob);
    free(kept);
}

void pen_http_pictures_free(struct pictures *pictures)
{
    if (!pictures)
        return;
    while (pictures->count > 0)
        drop(pictures, pictures->count - 1);
    pthread_mutex_destroy(&pictures->lock);
    free(pictures);
}

/* The key as text. Returns false for one that is too long; such a picture is not kept. */
static bool write_key(const struct picture_key *key, char text[KEY_BYTES])
{
    const char *layer = key->layer ? key->layer : "beauty";
    const char *format = key->format ? key->format : pen_image_formats[0];
    return snprintf(text, KEY_BYTES, "%s/%s/%s/%s%s", key->job, layer, format, key->view ? "=" : "",
                    key->view ? key->view : "") < KEY_BYTES;
}

/* Finds a picture and brings it to the front. Called with the lock held. */
static bool find(struct pictures *pictures, const char *key, struct picture *out)
{
    for (int i = 0; i < pictures->count; i++) {
        struct kept *kept = pictures->kept[i];
        if (strcmp(kept->key, key) != 0)
            continue;
        memmove(&pictures->kept[1], &pictures->kept[0], (size_t)i * sizeof(struct kept *));
        pictures->kept[0] = kept;
        *out = kept->picture;
        pen_http_blob_ref(out->blob);
        return true;
    }
    return false;
}

bool pen_http_pictures_find(struct pictures *pictures, const struct picture_key *key,
                            struct picture *out)
{
    char text[KEY_BYTES];
    if (!write_key(key, text))
        return false;
    pthread_mutex_lock(&pictures->lock);
    bool found = find(pictures, text, out);
    pthread_mutex_unlock(&pictures->lock);
    return found;
}

static size_t used(const atomic_size_t *sum)
{
    return atomic_load_explicit(sum, memory_order_relaxed);
}

/* Whether so many bytes of the budget, or the place beside it, are free; if need be, drops pictures
 * that nobody reads. Called with the lock held, until the bytes are counted. */
static bool make_room(struct pictures *pictures, size_t bytes, bool alone, struct pen_status *st)
{
    const atomic_size_t *sum = alone ? &pictures->beside : &pictures->budget;
    const size_t most = alone || bytes > BUDGET_BYTES ? 0 : BUDGET_BYTES - bytes;
    for (int i = pictures->count - 1; i >= 0 && used(sum) > most; i--) {
        if (atomic_load(&pictures->kept[i]->picture.blob->refs) == 1)
            drop(pictures, i);
    }
    return used(sum) <= most ||
           pen_fail(st, PEN_UNAVAILABLE,
                    "there is no memory for a large answer now; try again later");
}

bool pen_http_pictures_reserve(struct pictures *pictures, struct picture_room *room,
                               struct pen_status *st)
{
    room->alone = room->bytes > BUDGET_BYTES;
    pthread_mutex_lock(&pictures->lock);
    const bool ok = make_room(pictures, room->bytes, room->alone, st);
    if (ok)
        atomic_fetch_add_explicit(room->alone ? &pictures->beside : &pictures->budget, room->bytes,
                                  memory_order_relaxed);
    pthread_mutex_unlock(&pictures->lock);
    if (!ok)
        *room = (struct picture_room){0};
    return ok;
}

void pen_http_pictures_give_up(struct pictures *pictures, struct picture_room *room)
{
    atomic_fetch_sub_explicit(room->alone ? &pictures->beside : &pictures->budget, room->bytes,
                              memory_order_relaxed);
    *room = (struct picture_room){0};
}

/* Called with the lock held. */
static void keep(struct pictures *pictures, const char *key, const struct picture *picture)
{
    struct kept *kept = malloc(sizeof *kept);
    if (!kept)
        return;
    memcpy(kept->key, key, KEY_BYTES);
    kept->picture = *picture;
    pen_http_blob_ref(picture->blob);
    if (pictures->count == KEPT)
        drop(pictures, KEPT - 1);
    memmove(&pictures->kept[1], &pictures->kept[0],
            (size_t)pictures->count * sizeof(struct kept *));
    pictures->kept[0] = kept;
    pictures->count++;
}

/* Takes a blob in the place of what was reserved for it. Called with the lock held. */
static bool take(struct pictures *pictures, const char *key, struct blob *blob,
                 const struct picture_room *room, struct picture *out, struct pen_status *st)
{
    if (key[0] && find(pictures, key, out)) /* another thread was quicker */
        return true;
    if (room->bytes == 0 && !make_room(pictures, blob->content.bytes, false, st))
        return false;
    out->blob = pen_http_blob_ref(blob);
    pen_http_blob_count(blob, room->alone ? &pictures->beside : &pictures->budget);
    if (key[0])
        keep(pictures, key, out);
    return true;
}

bool pen_http_pictures_take(struct pictures *pictures, const struct picture_key *key,
                            struct pen_image *image, struct picture_room *room, struct picture *out,
                            struct pen_status *st)
{
    char text[KEY_BYTES] = "";
    struct picture_room none = {0};
    room = room ? room : &none;
    if (key && !write_key(key, text))
        text[0] = '\0';
    memcpy(out->type, image->type, sizeof out->type);
    memcpy(out->etag, image->etag, sizeof out->etag);
    struct blob *blob = pen_http_blob_take(&image->bytes); /* may write a file: without the lock */
    bool ok = blob || pen_fail(st, PEN_NO_MEMORY, "no memory for a picture");
    pthread_mutex_lock(&pictures->lock);
    ok = ok && take(pictures, text, blob, room, out, st);
    pen_http_pictures_give_up(pictures, room);
    pthread_mutex_unlock(&pictures->lock);
    pen_http_blob_unref(blob);
    return ok;
}

bool pen_http_pictures_count(struct pictures *pictures, struct blob *blob, struct pen_status *st)
{
    if (!blob || blob->content.bytes < PEN_BLOB_FILE_BYTES)
        return true;
    pthread_mutex_lock(&pictures->lock);
    const bool counted = blob->sum != NULL;
    const bool ok = counted || make_room(pictures, blob->content.bytes, false, st);
    if (ok && !counted)
        pen_http_blob_count(blob, &pictures->budget);
    pthread_mutex_unlock(&pictures->lock);
    return ok;
}

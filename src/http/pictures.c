/* SPDX-License-Identifier: MIT */
/* A list of kept pictures, the one used last in front. A kept picture that nobody reads goes when
 * the list is full, or when the budget is needed for another. */
#include "http/internal/pictures.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    KEPT = 64,
    KEY_BYTES = 300,
    SMALL_BYTES = 1 << 20,
    BUDGET_BYTES = 128 << 20,
    RESERVE_BYTES = 32 << 20 /* beyond the budget, for small pictures */
};

struct pictures {
    atomic_size_t bytes; /* of all pictures in memory. atomic: relaxed, a sum */
    pthread_mutex_t lock;
    int count; /* guarded by lock */
    struct kept {
        char key[KEY_BYTES];
        struct picture picture;
    } * kept[KEPT]; /* guarded by lock */
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

/* Whether a picture of this size may be in memory; if need be, drops pictures that nobody reads.
 * Called with the lock held. */
static bool make_room(struct pictures *pictures, size_t bytes)
{
    size_t budget = BUDGET_BYTES + (bytes <= SMALL_BYTES ? (size_t)RESERVE_BYTES : 0);
    for (int i = pictures->count - 1; i >= 0; i--) {
        if (atomic_load_explicit(&pictures->bytes, memory_order_relaxed) + bytes <= budget)
            return true;
        if (atomic_load(&pictures->kept[i]->picture.blob->refs) == 1)
            drop(pictures, i);
    }
    size_t others = atomic_load_explicit(&pictures->bytes, memory_order_relaxed);
    return others + bytes <= budget || others == 0; /* any picture may be alone */
}

static void keep(struct pictures *pictures, const char *key, const struct picture *picture)
{
    struct kept *kept = malloc(sizeof *kept);
    if (!kept)
        return;
    if (pictures->count == KEPT)
        drop(pictures, KEPT - 1);
    memcpy(kept->key, key, KEY_BYTES);
    kept->picture = *picture;
    pen_http_blob_ref(picture->blob);
    memmove(&pictures->kept[1], &pictures->kept[0],
            (size_t)pictures->count * sizeof(struct kept *));
    pictures->kept[0] = kept;
    pictures->count++;
}

bool pen_http_pictures_take(struct pictures *pictures, const struct picture_key *key,
                            struct pen_image *image, struct picture *out, struct pen_status *st)
{
    char text[KEY_BYTES] = "";
    bool keyed = key && write_key(key, text);
    pthread_mutex_lock(&pictures->lock);
    if (keyed && find(pictures, text, out)) {
        pthread_mutex_unlock(&pictures->lock);
        pen_buf_release(&image->bytes);
        return true;
    }
    bool ok = make_room(pictures, image->bytes.bytes) ||
              pen_fail(st, PEN_UNAVAILABLE,
                       "there is no memory for a large picture now; try again later");
    if (ok) {
        memcpy(out->type, image->type, sizeof out->type);
        memcpy(out->etag, image->etag, sizeof out->etag);
        out->blob = pen_http_blob_take(&image->bytes);
        pen_http_blob_count(out->blob, &pictures->bytes);
        ok = out->blob || pen_fail(st, PEN_NO_MEMORY, "no memory for a picture");
    }
    if (ok && keyed)
        keep(pictures, text, out);
    pthread_mutex_unlock(&pictures->lock);
    pen_buf_release(&image->bytes);
    return ok;
}

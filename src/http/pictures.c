/* SPDX-License-Identifier: MIT */
/* The pictures that were kept last, as a ring. */
#include "http/internal/pictures.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { KEPT = 256, KEY_BYTES = 340 }; /* enough for a list of thumbnails */

struct kept {
    char key[KEY_BYTES];
    struct picture picture; /* blob is NULL while the place is empty */
};

struct pictures {
    size_t budget_bytes;
    atomic_size_t bytes; /* of the answers. atomic: relaxed, a sum */
    pthread_mutex_t lock;
    int next; /* guarded by lock: the place that is filled next, which holds the oldest picture */
    struct kept kept[KEPT]; /* guarded by lock */
};

struct pictures *pen_http_pictures_new(size_t budget_bytes)
{
    struct pictures *pictures = calloc(1, sizeof *pictures);
    if (pictures) {
        pictures->budget_bytes = budget_bytes;
        pthread_mutex_init(&pictures->lock, NULL);
    }
    return pictures;
}

static void drop(struct kept *kept)
{
    pen_http_blob_unref(kept->picture.blob);
    kept->picture.blob = NULL;
}

void pen_http_pictures_free(struct pictures *pictures)
{
    if (!pictures)
        return;
    for (int i = 0; i < KEPT; i++)
        drop(&pictures->kept[i]);
    pthread_mutex_destroy(&pictures->lock);
    free(pictures);
}

/* Writes the key of a picture. The name of a view has at most 200 bytes, so a key of a kept picture
 * is never cut. */
static void write_key(const char *job, const struct pen_image_query *query, char key[KEY_BYTES])
{
    const char *layer = query->layer ? query->layer : "beauty";
    const char *format = query->format ? query->format : pen_image_formats[0];
    snprintf(key, KEY_BYTES, "%s/%s/%s/%d/%s/%s%s", job, query->with ? query->with : "", layer,
             query->max_edge, format, query->view ? "=" : "", query->view ? query->view : "");
}

/* Called with the lock held. */
static bool find(const struct pictures *pictures, const char *key, struct picture *out)
{
    for (int i = 0; i < KEPT; i++) {
        const struct kept *kept = &pictures->kept[i];
        if (!kept->picture.blob || strcmp(kept->key, key) != 0)
            continue;
        *out = kept->picture;
        pen_http_blob_ref(out->blob);
        return true;
    }
    return false;
}

bool pen_http_pictures_find(struct pictures *pictures, const char *job,
                            const struct pen_image_query *query, struct picture *out)
{
    char key[KEY_BYTES];
    write_key(job, query, key);
    pthread_mutex_lock(&pictures->lock);
    const bool found = find(pictures, key, out);
    pthread_mutex_unlock(&pictures->lock);
    return found;
}

/* Counts an answer, if it is large. If necessary, drops pictures without a reader, the oldest
 * first. Called with the lock held. */
static bool count(struct pictures *pictures, struct blob *blob, struct pen_status *st)
{
    const size_t bytes = blob->content.bytes;
    const size_t others =
        bytes < pictures->budget_bytes ? pictures->budget_bytes - bytes : 0; /* at most */
    if (blob->sum || bytes < PEN_BLOB_FILE_BYTES)
        return true;
    for (int i = 0; i < KEPT && atomic_load(&pictures->bytes) > others; i++) {
        struct kept *kept = &pictures->kept[(pictures->next + i) % KEPT];
        if (kept->picture.blob && atomic_load(&kept->picture.blob->refs) == 1)
            drop(kept);
    }
    if (atomic_load(&pictures->bytes) > others)
        return pen_fail(st, PEN_UNAVAILABLE,
                        "there is no memory for a large answer now; try again later");
    pen_http_blob_count(blob, &pictures->bytes);
    return true;
}

/* Called with the lock held. */
static void keep(struct pictures *pictures, const char *key, const struct picture *picture)
{
    struct kept *kept = &pictures->kept[pictures->next];
    drop(kept);
    memcpy(kept->key, key, KEY_BYTES);
    kept->picture = *picture;
    pen_http_blob_ref(picture->blob);
    pictures->next = (pictures->next + 1) % KEPT;
}

bool pen_http_pictures_take(struct pictures *pictures, const char *job,
                            const struct pen_image_query *query, struct pen_image *image,
                            struct picture *out, struct pen_status *st)
{
    char key[KEY_BYTES];
    struct picture picture;
    write_key(job, query, key);
    memcpy(picture.type, image->type, sizeof picture.type);
    memcpy(picture.etag, image->etag, sizeof picture.etag);
    picture.blob =
        pen_http_blob_take(&image->bytes); /* may write a file, so the lock is not held */
    if (!picture.blob)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a picture");
    pthread_mutex_lock(&pictures->lock);
    bool ok = find(pictures, key, out); /* another thread may have kept it meanwhile */
    if (!ok && count(pictures, picture.blob, st)) {
        keep(pictures, key, &picture);
        ok = find(pictures, key, out);
    }
    pthread_mutex_unlock(&pictures->lock);
    pen_http_blob_unref(picture.blob);
    return ok;
}

bool pen_http_pictures_count(struct pictures *pictures, struct blob *blob, struct pen_status *st)
{
    if (!blob)
        return true;
    pthread_mutex_lock(&pictures->lock);
    const bool ok = count(pictures, blob, st);
    pthread_mutex_unlock(&pictures->lock);
    return ok;
}

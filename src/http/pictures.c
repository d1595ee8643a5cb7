/* SPDX-License-Identifier: MIT */
/* A list of kept pictures, the one used last in front. A kept picture that nobody reads goes when
 * the list is full, or when the budget is needed for another; so does one whose readers give way.
 * The picture in the place beside the budget is not in the list, and goes with its last reader.
 *
 * Order of locks: that of the pictures, of a budget (answers.h), of a loop. */
#include "http/internal/pictures.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "http/internal/answers.h"

enum {
    KEPT = 64,
    KEY_BYTES = 300,
    BUDGET_BYTES = 128 << 20,
    RESERVE_BYTES = 64 << 20, /* beyond the budget, for small pictures */
    PAUSE_MS = 20,            /* after which a thread that waits for memory looks again */
    SMALL_FILE = 1 << 20,     /* a picture is small up to so many bytes, */
    SMALL_ROOM = 16 << 20     /* and while it is made, unless its file is known to be larger */
};

struct kept {
    char key[KEY_BYTES];
    struct picture picture;
};

struct pictures {
    struct answer_memory budget; /* reserved, or of pictures */
    struct answer_memory beside; /* the place beside it; 0 bytes: it is free */
    pthread_mutex_t lock;
    int count;               /* guarded by lock */
    struct kept *kept[KEPT]; /* guarded by lock */
    struct kept *alone;      /* guarded by lock: the picture in that place, if it can be found */
};

struct pictures *pen_http_pictures_new(void)
{
    struct pictures *pictures = calloc(1, sizeof *pictures);
    if (!pictures)
        return NULL;
    pthread_mutex_init(&pictures->lock, NULL);
    pen_http_answers_init(&pictures->budget);
    pen_http_answers_init(&pictures->beside);
    return pictures;
}

static void drop(struct pictures *pictures, int i)
{
    struct kept *kept = pictures->kept[i];
    pictures->count--;
    memmove(&pictures->kept[i], &pictures->kept[i + 1],
            (size_t)(pictures->count - i) * sizeof(struct kept *));
    kept->picture.blob->is_kept = false;
    pen_http_blob_unref(kept->picture.blob);
    free(kept);
}

static void drop_alone(struct pictures *pictures)
{
    struct kept *kept = pictures->alone;
    pictures->alone = NULL;
    if (kept)
        pen_http_blob_unref(kept->picture.blob);
    free(kept);
}

/* The last reader of the picture beside the budget has gone, unless another came. */
static void on_idle(void *user)
{
    struct pictures *pictures = user;
    pthread_mutex_lock(&pictures->lock);
    if (pictures->alone && atomic_load(&pictures->alone->picture.blob->refs) == 1)
        drop_alone(pictures);
    pthread_mutex_unlock(&pictures->lock);
}

void pen_http_pictures_free(struct pictures *pictures)
{
    if (!pictures)
        return;
    while (pictures->count > 0)
        drop(pictures, pictures->count - 1);
    drop_alone(pictures);
    pen_http_answers_release(&pictures->beside);
    pen_http_answers_release(&pictures->budget);
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
    struct kept *found = pictures->alone;
    if (!found || strcmp(found->key, key) != 0 || found->picture.blob->readers.given_up)
        found = NULL;
    for (int i = 0; !found && i < pictures->count; i++) {
        struct kept *kept = pictures->kept[i];
        if (strcmp(kept->key, key) != 0)
            continue;
        memmove(&pictures->kept[1], &pictures->kept[0], (size_t)i * sizeof(struct kept *));
        pictures->kept[0] = found = kept;
    }
    if (!found)
        return false;
    *out = found->picture;
    pen_http_blob_ref(out->blob);
    return true;
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

/* Drops those whose readers were told to give way: nobody is to become another reader of them.
 * Called with the lock held. */
static void drop_given_up(struct pictures *pictures)
{
    for (int i = pictures->count - 1; i >= 0; i--) {
        if (pictures->kept[i]->picture.blob->readers.given_up)
            drop(pictures, i);
    }
}

/* Whether so many bytes fit into the budget; if need be, drops pictures that nobody reads, then
 * those that are read slowly. Called with the lock held. */
static bool make_room(struct pictures *pictures, size_t bytes, bool is_small)
{
    struct answer_memory *budget = &pictures->budget;
    const size_t limit = BUDGET_BYTES + (is_small ? (size_t)RESERVE_BYTES : 0);
    for (int i = pictures->count - 1; i >= 0 && !pen_http_answers_fit(budget, bytes, limit); i--) {
        if (atomic_load(&pictures->kept[i]->picture.blob->refs) == 1)
            drop(pictures, i);
    }
    const bool fits = pen_http_answers_make_room(budget, bytes, limit);
    drop_given_up(pictures);
    return fits;
}

/* Whether the place beside the budget is free; if it is read slowly, its readers are told to give
 * way. Called with the lock held. */
static bool is_beside_free(struct pictures *pictures)
{
    if (atomic_load_explicit(&pictures->beside.bytes, memory_order_relaxed) == 0)
        return true;
    pen_http_answers_make_room(&pictures->beside, 1, 1);
    return false;
}

static bool fail_full(struct pen_status *st)
{
    return pen_fail(st, PEN_UNAVAILABLE,
                    "there is no memory for a large picture now; try again later");
}

static struct answer_memory *memory_of(struct pictures *pictures, bool alone)
{
    return alone ? &pictures->beside : &pictures->budget;
}

static bool try_reserve(struct pictures *pictures, const struct picture_room *room)
{
    const bool is_small = room->bytes <= SMALL_ROOM && room->file_bytes <= SMALL_FILE;
    pthread_mutex_lock(&pictures->lock);
    const bool ok =
        room->alone ? is_beside_free(pictures) : make_room(pictures, room->bytes, is_small);
    if (ok)
        atomic_fetch_add_explicit(&memory_of(pictures, room->alone)->bytes, room->bytes,
                                  memory_order_relaxed);
    pthread_mutex_unlock(&pictures->lock);
    return ok;
}

bool pen_http_pictures_reserve(struct pictures *pictures, struct picture_room *room, int wait_ms,
                               struct pen_status *st)
{
    const struct timespec pause = {.tv_nsec = PAUSE_MS * 1000000L};
    room->alone = room->bytes > BUDGET_BYTES;
    for (int ms = 0; !try_reserve(pictures, room); ms += PAUSE_MS) {
        if (ms >= wait_ms) {
            *room = (struct picture_room){0};
            return fail_full(st);
        }
        nanosleep(&pause, NULL);
    }
    return true;
}

void pen_http_pictures_give_up(struct pictures *pictures, struct picture_room *room)
{
    atomic_fetch_sub_explicit(&memory_of(pictures, room->alone)->bytes, room->bytes,
                              memory_order_relaxed);
    *room = (struct picture_room){0};
}

static void keep(struct pictures *pictures, const char *key, const struct picture *picture,
                 bool alone)
{
    struct kept *kept = malloc(sizeof *kept);
    if (!kept)
        return;
    memcpy(kept->key, key, KEY_BYTES);
    kept->picture = *picture;
    pen_http_blob_ref(picture->blob);
    picture->blob->is_kept = true;
    if (alone) {
        picture->blob->idle = on_idle;
        picture->blob->idle_user = pictures;
        pictures->alone = kept;
        return;
    }
    if (pictures->count == KEPT)
        drop(pictures, KEPT - 1);
    memmove(&pictures->kept[1], &pictures->kept[0],
            (size_t)pictures->count * sizeof(struct kept *));
    pictures->kept[0] = kept;
    pictures->count++;
}

/* Makes the image a picture. Called with the lock held. */
static bool take(struct pictures *pictures, const char *key, struct pen_image *image,
                 struct picture_room *room, struct picture *out, struct pen_status *st)
{
    const size_t bytes = image->bytes.bytes;
    const bool was_alone = room->alone;
    if (!was_alone)
        pen_http_pictures_give_up(pictures, room);
    const bool fits = make_room(pictures, bytes, bytes <= SMALL_FILE);
    if (!fits && !was_alone)
        return fail_full(st);
    memcpy(out->type, image->type, sizeof out->type);
    memcpy(out->etag, image->etag, sizeof out->etag);
    out->blob = pen_http_blob_take(&image->bytes);
    if (!out->blob)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a picture");
    pen_http_blob_count(out->blob, memory_of(pictures, !fits));
    if (key[0])
        keep(pictures, key, out, !fits);
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
    pthread_mutex_lock(&pictures->lock);
    const bool ok =
        (text[0] && find(pictures, text, out)) || take(pictures, text, image, room, out, st);
    pen_http_pictures_give_up(pictures, room);
    pthread_mutex_unlock(&pictures->lock);
    pen_buf_release(&image->bytes);
    return ok;
}

/* SPDX-License-Identifier: MIT */
/* A large store. How long a submit waits while a job of gigabytes is removed and its space is given
 * back; how long the removal takes; how long opening and checking the store takes at a start.
 *
 * usage: bench_disk [GiB] [folder]     makes the store in a new folder below `folder` (/tmp), and
 * removes it in the end */
#include <inttypes.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "base/clock.h"
#include "store/store.h"

enum { PICTURE_BYTES = 4 << 20, SUBMITS_MAX = 100000 };

static char url[200];
static atomic_bool over;
static int first_number = 1000; /* of the next submits */

static void must(bool ok, const struct pen_status *st, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "%s: %s\n", what, st->msg);
    exit(1);
}

static struct pen_store *open_store(void)
{
    struct pen_status st;
    struct pen_store *store = pen_store_open(url, true, &st);
    must(store != NULL, &st, "open");
    return store;
}

static void submit(struct pen_store *store, int n)
{
    char id[PEN_ID_BYTES], scene[64];
    unsigned char sha256[32] = {0};
    struct pen_status st;
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    const struct pen_view_new view = {"main", 4, 4};
    const struct pen_batch_new batch = {.tile_count = 1, .pixels = 16};
    snprintf(id, sizeof id, "01900000-0000-7000-8000-%012d", n);
    snprintf(scene, sizeof scene, "{\"scene\": %d}", n);
    memcpy(sha256, &n, sizeof n);
    struct pen_job_new job = {.id = id,
                              .created_ms = 1,
                              .kind = "render",
                              .request = "{}",
                              .scene = scene,
                              .scene_bytes = strlen(scene),
                              .scene_sha256 = sha256,
                              .max_attempts = 3,
                              .view_count = 1,
                              .views = &view,
                              .batch_count = 1,
                              .batches = &batch};
    must(pen_store_submit(store, &job, &result, &answer, &st), &st, "submit");
    pen_buf_release(&answer);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Submits every 10 ms until the removal is over. */
static void *submit_on(void *user)
{
    static double took_ms[SUBMITS_MAX];
    struct pen_store *store = open_store();
    int count = 0;
    (void)user;
    while (!atomic_load(&over) && count < SUBMITS_MAX) {
        const struct timespec pause = {.tv_nsec = 10000000};
        int64_t begun_ns = pen_clock_ns();
        submit(store, first_number + count);
        took_ms[count++] = (double)(pen_clock_ns() - begun_ns) * 1e-6;
        nanosleep(&pause, NULL);
    }
    qsort(took_ms, (size_t)count, sizeof took_ms[0], by_value);
    first_number += count;
    printf("%d submits: median %.1f ms, p99 %.1f ms, longest %.1f ms\n", count, took_ms[count / 2],
           took_ms[count * 99 / 100], took_ms[count - 1]);
    pen_store_close(store);
    return NULL;
}

static double seconds_since(int64_t begun_ns)
{
    return (double)(pen_clock_ns() - begun_ns) * 1e-9;
}

static void fill(struct pen_store *store, double gib)
{
    struct pen_status st;
    struct pen_claim claim;
    bool found = false;
    char layer[24];
    char *picture = malloc(PICTURE_BYTES);
    unsigned long long seed = 1;
    if (!picture)
        exit(1);
    for (int i = 0; i < PICTURE_BYTES; i++)
        picture[i] = (char)((seed = seed * 6364136223846793005u + 1442695040888963407u) >> 56);
    submit(store, 1);
    must(pen_store_claim(store, "w", 3600 * 1000, 1, &claim, &found, &st) && found, &st, "claim");
    for (int i = 0; i < gib * (1 << 30) / PICTURE_BYTES; i++) {
        snprintf(layer, sizeof layer, "layer-%d", i);
        must(pen_store_artefact_put(store, &claim, layer, "pfm", picture, PICTURE_BYTES, &st), &st,
             "picture");
    }
    must(pen_store_cancel(store, "01900000-0000-7000-8000-000000000001", NULL, &st), &st, "cancel");
    free(picture);
}

/* As the worker's housekeeping does. */
static void remove_all(struct pen_store *store)
{
    struct pen_status st;
    bool more = true;
    int slices = 0;
    double longest_ms = 0;
    int64_t begun_ns = pen_clock_ns();
    must(pen_store_delete(store, "01900000-0000-7000-8000-000000000001", NULL, "{}", &st), &st,
         "delete");
    printf("delete answered after %.1f ms\n", seconds_since(begun_ns) * 1e3);
    for (begun_ns = pen_clock_ns(); more; slices++) {
        int64_t slice_ns = pen_clock_ns();
        must(pen_store_purge(store, &more, &st), &st, "slice");
        int64_t took_ns = pen_clock_ns() - slice_ns;
        longest_ms = (double)took_ns * 1e-6 > longest_ms ? (double)took_ns * 1e-6 : longest_ms;
        const struct timespec pause = {.tv_nsec = took_ns < 5000000     ? 5000000
                                                  : took_ns < 999999999 ? (long)took_ns
                                                                        : 999999999};
        nanosleep(&pause, NULL);
    }
    printf("removed in %d slices, the longest %.1f ms, and the space returned, after %.1f s\n",
           slices, longest_ms, seconds_since(begun_ns));
}

static void start(void)
{
    enum { CHECK_MS = 300 };
    struct pen_status st;
    bool finished;
    int64_t begun_ns = pen_clock_ns();
    struct pen_store *store = open_store();
    must(pen_store_check(store, CHECK_MS, &finished, &st), &st, "check");
    printf("opened and checked as at a start in %.3f s%s\n", seconds_since(begun_ns),
           finished ? "" : ", unfinished");
    pen_store_close(store);
}

/* What submits take on this machine now, without anything else on the store. */
static void measure_undisturbed(void)
{
    const struct timespec five_seconds = {.tv_sec = 5};
    pthread_t thread;
    printf("undisturbed, ");
    pthread_create(&thread, NULL, submit_on, NULL);
    nanosleep(&five_seconds, NULL);
    atomic_store(&over, true);
    pthread_join(thread, NULL);
    atomic_store(&over, false);
}

static double mib_on_disk(void)
{
    struct stat info;
    return stat(url, &info) == 0 ? (double)info.st_size / (1 << 20) : 0;
}

int main(int argc, char **argv)
{
    double gib = argc > 1 ? strtod(argv[1], NULL) : 4;
    char folder[100], command[160];
    pthread_t thread;
    snprintf(folder, sizeof folder, "%s/penumbra-disk-XXXXXX", argc > 2 ? argv[2] : "/tmp");
    if (gib <= 0 || !mkdtemp(folder))
        return 2;
    snprintf(url, sizeof url, "%s/penumbra.db", folder);
    struct pen_store *store = open_store();
    fill(store, gib);
    pen_store_close(store);
    printf("a store of %.0f MiB\n", mib_on_disk());
    start();
    measure_undisturbed();
    store = open_store();
    pthread_create(&thread, NULL, submit_on, NULL);
    remove_all(store);
    atomic_store(&over, true);
    pthread_join(thread, NULL);
    pen_store_close(store);
    printf("a store of %.1f MiB is left\n", mib_on_disk());
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command) != 0;
}

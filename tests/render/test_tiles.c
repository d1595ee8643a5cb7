/* SPDX-License-Identifier: MIT */
/* The division of a task's pixels among threads. Threads share the last tiles. Finished rows are
 * reported in order. A PNG that is written meanwhile has the bytes of a PNG written afterwards. */
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "film/encode.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

/* A scene of little work with pictures of that size. */
static struct pen_scene *small_scene(int width, int height, int tile)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(0.3, 0.2, 0), 3, kit_material(&kit, kit_glow(0.9, 0.4, 0.1)));
    kit_sphere(&kit, pen_vec3(-2, -1, 1), 2, kit_material(&kit, kit_matte(0.7)));
    kit_point(&kit, pen_vec3(5, 7, 9), pen_vec3(1, 1, 1));
    kit.settings.width = width;
    kit.settings.height = height;
    kit.settings.tile = tile;
    return kit_freeze(&kit);
}

static size_t film_bytes(void)
{
    return sizeof(float) * 3 * (size_t)kit.settings.width * (size_t)kit.settings.height;
}

static struct pen_render_task task_of(const struct pen_scene *scene, float *rgb)
{
    return (struct pen_render_task){
        .scene = scene, .settings = &kit.settings, .tile_count = -1, .rgb = rgb};
}

/* ---- Threads that wait for each other ---- */

enum { THREADS = 3, PATIENCE_S = SUITE_HANG_S };

/* A meeting of threads. The first call of each thread waits until all have called. */
struct meeting {
    pthread_mutex_t lock;
    pthread_cond_t all;
    int wanted, present;
    bool here[THREADS];
    bool late; /* a thread has waited in vain */
};

static struct timespec patience(void)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += PATIENCE_S;
    return until;
}

static void meet(void *user, int thread, int x, int y)
{
    struct meeting *m = user;
    const struct timespec until = patience();
    (void)x, (void)y;
    pthread_mutex_lock(&m->lock);
    if (!m->here[thread]) {
        m->here[thread] = true;
        if (++m->present == m->wanted)
            pthread_cond_broadcast(&m->all);
        while (m->present < m->wanted && !m->late)
            m->late = pthread_cond_timedwait(&m->all, &m->lock, &until) != 0;
    }
    pthread_mutex_unlock(&m->lock);
}

/* Threads that wait in their first block, and again for `nap_ms` when all are there. */
static void meet_and_wait(void *user, int thread, int x, int y)
{
    struct meeting *m = user;
    const struct timespec nap = {0, 20000000};
    bool first = !m->here[thread];
    meet(user, thread, x, y);
    if (first)
        nanosleep(&nap, NULL);
}

static struct meeting meeting_of(int threads)
{
    return (struct meeting){
        .lock = PTHREAD_MUTEX_INITIALIZER, .all = PTHREAD_COND_INITIALIZER, .wanted = threads};
}

/* Three threads can be in one tile at once, if there is no other. The time of the tile is what they
 * spent on it together. */
START_TEST(test_tiles__threads_share_one_tile)
{
    struct pen_scene *scene = small_scene(61, 45, 64);
    float *want = kit_film(scene, &kit.settings, 1), *film = calloc(1, film_bytes());
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_thread_pool *pool = pen_thread_pool_new(THREADS, &st);
    struct meeting meeting = meeting_of(THREADS);
    struct pen_render_task task = task_of(scene, film);
    task.pixel_begins = meet_and_wait;
    task.pixel_user = &meeting;
    task.keep_tile_ms = true;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_msg(!meeting.late, "no other thread took a block of the tile");
    ck_assert_int_eq(stats.threads, THREADS);
    ck_assert_uint_eq(stats.tile_count, 1);
    ck_assert_uint_eq(stats.rays.primary, 61 * 45);
    ck_assert_double_ge(stats.tile_ms[0], 60);
    ck_assert_double_le(stats.tile_ms[0], stats.render_ms * THREADS * 1.0001);
    ck_assert(memcmp(film, want, film_bytes()) == 0);
    free(stats.tile_ms);
    free(film);
    free(want);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
}
END_TEST

/* The last tile of several is shared, too: all threads meet in it. */
struct last_tile {
    struct meeting meeting;
    int y; /* of its first row */
};

static void meet_in_last_tile(void *user, int thread, int x, int y)
{
    struct last_tile *last = user;
    if (y >= last->y)
        meet(&last->meeting, thread, x, y);
}

static void count_tile(void *user, struct pen_rect rect)
{
    (void)rect;
    ++*(int *)user;
}

START_TEST(test_tiles__the_last_tile_is_shared)
{
    struct pen_scene *scene = small_scene(32, 32 * 5, 32);
    float *want = kit_film(scene, &kit.settings, 1), *film = calloc(1, film_bytes());
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_thread_pool *pool = pen_thread_pool_new(THREADS, &st);
    struct last_tile last = {meeting_of(THREADS), 32 * 4};
    int tiles = 0;
    struct pen_render_task task = task_of(scene, film);
    task.pixel_begins = meet_in_last_tile;
    task.pixel_user = &last;
    task.tile_done = count_tile;
    task.user = &tiles;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_msg(!last.meeting.late, "a thread took no block of the last tile");
    ck_assert_uint_eq(stats.tile_count, 5);
    ck_assert_int_eq(tiles, 5);
    ck_assert(memcmp(film, want, film_bytes()) == 0);
    free(film);
    free(want);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
}
END_TEST

/* ---- Rows ---- */

/* What a task tells of its rows, checked against the finished film. */
struct rows {
    const struct pen_film *film;
    const float *want;
    atomic_int inside;
    int rows, calls;
    struct pen_png_writer *png;
};

static void rows_done(void *user, int rows)
{
    struct rows *r = user;
    size_t row = (size_t)r->film->width * 3, begin = (size_t)r->rows * row;
    ck_assert_int_eq(atomic_fetch_add(&r->inside, 1), 0); /* one call at a time */
    ck_assert_int_gt(rows, r->rows);
    ck_assert_int_le(rows, r->film->height);
    ck_assert(memcmp(r->film->rgb + begin, r->want + begin,
                     ((size_t)(rows - r->rows)) * row * sizeof *r->want) == 0);
    r->rows = rows;
    r->calls++;
    if (r->png)
        pen_png_rows(r->png, rows);
    atomic_fetch_sub(&r->inside, 1);
}

/* Makes threads finish tiles in an order that differs from case to case. */
static void wait_at_random(void *user, int thread, int x, int y)
{
    const uint64_t *seed = user;
    (void)thread;
    struct random r = {*seed + (uint64_t)x * 7919 + (uint64_t)y * 104729, 0};
    if (x % PEN_BLOCK_SIDE == 0 && y % PEN_BLOCK_SIDE == 0 && random_below(&r, 4) == 0) {
        const struct timespec nap = {0, (long)random_below(&r, 60000)};
        nanosleep(&nap, NULL);
    }
}

static void check_png(struct rows *rows, struct pen_thread_pool *pool, struct pen_render_task task,
                      int bits)
{
    struct pen_png_options options = {.bits = bits};
    struct pen_buf after = {0}, meanwhile = {0};
    struct pen_render_stats stats;
    struct pen_status st;
    memset(task.rgb, 0xFF, film_bytes());
    rows->png = pen_png_begin(rows->film, &options, &meanwhile, &st);
    task.rows_done = rows_done;
    task.rows_user = rows;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(rows->rows, rows->film->height);
    ck_assert(pen_png_end(rows->png, &st));
    ck_assert(pen_png_write(rows->film, &options, &after, &st));
    ck_assert(after.bytes == meanwhile.bytes &&
              memcmp(after.data, meanwhile.data, after.bytes) == 0);
    pen_png_free(rows->png);
    pen_buf_release(&after);
    pen_buf_release(&meanwhile);
}

/* Random sizes, tiles, numbers of threads, and orders in which tiles are finished. */
START_TEST(test_tiles__png_is_written_while_tiles_finish)
{
    static const int tiles[] = {1, 5, 8, 12, 32, 100};
    struct random r = random_begin(5);
    struct pen_thread_pool *pools[4];
    struct pen_status st;
    for (int i = 0; i < 4; i++)
        pools[i] = pen_thread_pool_new(i + 1, &st);
    for (int i = 0; i < random_cases(80); i++) {
        const int width = 1 + (int)random_below(&r, 90), height = 1 + (int)random_below(&r, 90);
        struct pen_scene *scene = small_scene(width, height, tiles[random_below(&r, 6)]);
        struct pen_film film = {width, height, malloc(film_bytes())};
        float *want = kit_film(scene, &kit.settings, 1);
        struct rows rows = {.film = &film, .want = want};
        struct pen_render_task task = task_of(scene, film.rgb);
        uint64_t seed = random_bits(&r);
        task.pixel_begins = wait_at_random;
        task.pixel_user = &seed;
        check_png(&rows, pools[random_below(&r, 4)], task, i % 2 ? 16 : 8);
        free(want);
        free(film.rgb);
        pen_scene_free(scene);
    }
    for (int i = 0; i < 4; i++)
        pen_thread_pool_free(pools[i]);
}
END_TEST

/* A thread that writes rows, and another that renders meanwhile. */
struct slow_rows {
    struct meeting meeting; /* of the thread in rows_done and the one at the last block */
    int last_x, last_y;     /* the first pixel of the last block */
    int rows, calls;
};

static void slow_rows_done(void *user, int rows)
{
    struct slow_rows *s = user;
    s->rows = rows;
    if (s->calls++ == 0)
        meet(&s->meeting, 0, 0, 0);
}

static void last_block_begins(void *user, int thread, int x, int y)
{
    struct slow_rows *s = user;
    (void)thread;
    if (x == s->last_x && y == s->last_y)
        meet(&s->meeting, 1, x, y);
}

/* While one thread takes its time in rows_done, another renders all the rest. It tells no rows
 * meanwhile; the first does so afterwards. */
START_TEST(test_tiles__rows_done_holds_up_no_other_thread)
{
    struct pen_scene *scene = small_scene(40, 80, 8);
    float *film = malloc(film_bytes());
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    struct slow_rows slow = {.meeting = meeting_of(2), .last_x = 32, .last_y = 72};
    struct pen_render_task task = task_of(scene, film);
    task.pixel_begins = last_block_begins;
    task.pixel_user = &slow;
    task.rows_done = slow_rows_done;
    task.rows_user = &slow;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_msg(!slow.meeting.late, "no thread came to the last block meanwhile");
    ck_assert_int_eq(slow.rows, 80);
    ck_assert_int_ge(slow.calls, 2);
    ck_assert_int_le(slow.calls, 10);
    pen_thread_pool_free(pool);
    free(film);
    pen_scene_free(scene);
}
END_TEST

struct stopping {
    atomic_bool cancel;
    struct pen_png_writer *png;
};

static void stop_at_rows(void *user, int rows)
{
    struct stopping *s = user;
    pen_png_rows(s->png, rows);
    if (rows >= 40)
        atomic_store(&s->cancel, true);
}

/* Keeps threads from the lower half until the render is cancelled. */
static void wait_for_cancel(void *user, int thread, int x, int y)
{
    struct stopping *s = user;
    const struct timespec nap = {0, 1000000};
    (void)thread, (void)x;
    for (int i = 0; y >= 320 && !atomic_load(&s->cancel) && i < PATIENCE_S * 1000; i++)
        nanosleep(&nap, NULL);
}

/* A cancelled render ends in an error, and the file that was begun is given up. */
START_TEST(test_tiles__a_cancelled_render_has_no_picture)
{
    struct pen_scene *scene = small_scene(64, 640, 8);
    struct pen_film film = {64, 640, malloc(film_bytes())};
    struct pen_png_options options = {.bits = 8};
    struct pen_buf out = {0};
    struct pen_status st;
    struct pen_render_stats stats;
    struct stopping stopping = {.png = pen_png_begin(&film, &options, &out, &st)};
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    struct pen_render_task task = task_of(scene, film.rgb);
    task.cancel = &stopping.cancel;
    task.pixel_begins = wait_for_cancel;
    task.pixel_user = &stopping;
    task.rows_done = stop_at_rows;
    task.rows_user = &stopping;
    ck_assert(!pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(st.code, PEN_CANCELLED);
    ck_assert_uint_ge(stats.tile_count, 40);
    ck_assert_uint_le(stats.tile_count, 322);
    pen_thread_pool_free(pool);
    pen_png_free(stopping.png);
    pen_buf_release(&out);
    free(film.rgb);
    pen_scene_free(scene);
}
END_TEST

PEN_SUITE("tiles", test_tiles__threads_share_one_tile, test_tiles__the_last_tile_is_shared,
          test_tiles__png_is_written_while_tiles_finish,
          test_tiles__rows_done_holds_up_no_other_thread,
          test_tiles__a_cancelled_render_has_no_picture)

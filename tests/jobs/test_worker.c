/* SPDX-License-Identifier: MIT */
/* The worker, from a submitted job to its picture: the same bits as a direct render, for any
 * division of the job into batches. Failures, cancels, timeouts and deaths of workers. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "film/picture.h"
#include "store/db.h"
#include "support/jobs.h"
#include "support/store_rows.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

/* Many samples make many rays, so that a small image has several batches. */
static const char several_batches[] =
    ", \"render\": {\"width\": 150, \"height\": 110, \"samples_per_pixel\": 1000, \"tile\": 8}";
static const char one_batch[] = ", \"render\": {\"width\": 40, \"height\": 30}";

/* Renders a bare scene without store and worker. */
static struct pen_film *render_directly(const char *text)
{
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc desc;
    struct pen_errors errors = {0};
    struct pen_status st;
    ck_assert(pen_scene_load(text, strlen(text), &limits, arena, &desc, &errors));
    struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_AUTO, 0, &st);
    store_must(scene != NULL, &st, "freeze");
    struct pen_film *film = pen_film_new(desc.settings.width, desc.settings.height, &st);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    struct pen_render_task task = {
        .scene = scene, .settings = &desc.settings, .tile_count = -1, .rgb = film->rgb};
    struct pen_render_stats stats;
    store_must(pen_render_run(pool, &task, &stats, &st), &st, "render");
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    pen_arena_free(arena);
    return film;
}

/* The job's PFM must hold the film's values bit for bit. */
static void compare_with_film(const struct pen_film *film)
{
    struct pen_buf pfm = jobs_image(&bed, id, NULL, "pfm");
    size_t row = (size_t)film->width * 3 * sizeof(float);
    ck_assert_uint_gt(pfm.bytes, row * (size_t)film->height);
    const unsigned char *bottom = pfm.data + pfm.bytes - row * (size_t)film->height;
    for (int y = 0; y < film->height; y++) {
        const unsigned char *stored = bottom + row * (size_t)(film->height - 1 - y);
        ck_assert_mem_eq(stored, film->rgb + (size_t)y * (size_t)film->width * 3, row);
    }
    pen_buf_release(&pfm);
}

static void count_batches(int kinds[2])
{
    static struct store_batch batch[1000];
    const int count = store_batches(bed.bed.url, id, batch, 1000);
    kinds[0] = kinds[1] = 0;
    for (int i = 0; i < count; i++)
        kinds[batch[i].kind]++;
}

START_TEST(test_worker__one_batch_gives_the_pixels_of_a_direct_render)
{
    int kinds[2];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(one_batch), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    count_batches(kinds);
    ck_assert_int_eq(kinds[PEN_BATCH_RENDER], 1);
    ck_assert_int_eq(kinds[PEN_BATCH_ASSEMBLE], 0);
    struct pen_film *film = render_directly(jobs_scene(one_batch));
    compare_with_film(film);
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_worker__several_batches_give_the_pixels_of_a_direct_render)
{
    int kinds[2];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(several_batches), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    count_batches(kinds);
    ck_assert_int_gt(kinds[PEN_BATCH_RENDER], 3);
    ck_assert_int_eq(kinds[PEN_BATCH_ASSEMBLE], 1);
    struct pen_film *film = render_directly(jobs_scene(several_batches));
    compare_with_film(film);
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

/* A hilly mesh in the document: the worker's scene uses arrays of its description. */
static const char *mesh_scene(const char *more)
{
    enum { SIDE = 40 };
    static char text[1 << 18];
    size_t used =
        (size_t)snprintf(text, sizeof text,
                         "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 9, 9],"
                         " \"look_at\": [0, 0, 0]}, \"lights\": [{\"type\": \"directional\","
                         " \"direction\": [1, -2, 0], \"intensity\": [1, 1, 1]}],"
                         " \"objects\": [{\"type\": \"mesh\", \"material\": {\"kd\": 0.7},"
                         " \"positions\": [");
    for (int i = 0; i < SIDE * SIDE; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s[%g, %g, %g]", i ? ", " : "",
                                 0.2 * (i % SIDE) - 4, 0.2 * (i * i % 7), 0.2 * (i / SIDE) - 4);
    used += (size_t)snprintf(text + used, sizeof text - used, "], \"faces\": [");
    for (int i = 0; i < (SIDE - 1) * SIDE; i++)
        if (i % SIDE < SIDE - 1)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s[%d, %d, %d]",
                                     i ? ", " : "", i, i + SIDE, i + 1);
    snprintf(text + used, sizeof text - used, "]}]%s}", more);
    return text;
}

START_TEST(test_worker__meshes_give_the_pixels_of_a_direct_render)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, mesh_scene(several_batches), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    struct pen_status st;
    int triangles = 0;
    json_t *stats = pen_jobs_stats(bed.jobs, id, &st);
    ck_assert_int_eq(json_unpack(stats, "{s:{s:i}}", "meshes", "triangles", &triangles), 0);
    ck_assert_int_eq(triangles, 39 * 39);
    json_decref(stats);
    struct pen_film *film = render_directly(mesh_scene(several_batches));
    compare_with_film(film);
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

/* A batch that takes longer than it should ends with the tiles that are begun; the others become
 * batches of their own, and a view that had one batch gets an assemble batch. */
START_TEST(test_worker__long_batches_are_divided)
{
    static const char *const settings[] = {
        ", \"render\": {\"width\": 60, \"height\": 45, \"samples_per_pixel\": 400, \"tile\": 8}",
        several_batches,
        /* Larger than the picture: its tiles are smaller. */
        ", \"render\": {\"width\": 150, \"height\": 110, \"samples_per_pixel\": 400,"
        " \"tile\": 65536}"};
    static const int edges[][3] = {{8, 8, 48}, {8, 8, 266}, {65536, 64, 6}};
    jobs_bed_open(&bed);
    bed.batch_ms = 1;
    jobs_worker_start(&bed);
    for (int i = 0; i < 3; i++) {
        int kinds[2];
        struct pen_status st;
        double share = 0;
        int tiles = 0, wanted = 0, edge = 0;
        jobs_submit(&bed, jobs_scene(settings[i]), id);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        count_batches(kinds);
        /* How many depends on the number of threads and their speed. */
        ck_assert_int_gt(kinds[PEN_BATCH_RENDER], 1);
        ck_assert_int_eq(kinds[PEN_BATCH_ASSEMBLE], 1);
        struct pen_film *film = render_directly(jobs_scene(settings[i]));
        compare_with_film(film);
        pen_film_free(film);
        json_t *job = jobs_get(&bed, id), *stats = pen_jobs_stats(bed.jobs, id, &st);
        ck_assert_int_eq(json_unpack(job, "{s:{s:F}}", "progress", "fraction", &share), 0);
        ck_assert_int_eq(json_unpack(stats, "{s:{s:i}}", "tiles", "count", &tiles), 0);
        ck_assert_double_eq(share, 1);
        ck_assert_int_eq(
            json_unpack(job, "{s:{s:i}, s:i}", "render", "tile", &wanted, "tile_edge", &edge), 0);
        ck_assert_int_eq(wanted, edges[i][0]);
        ck_assert_int_eq(edge, edges[i][1]);
        ck_assert_int_eq(tiles, edges[i][2]);
        json_decref(job);
        json_decref(stats);
    }
    jobs_bed_close(&bed);
}
END_TEST

static bool is_slow(void *user, const char *job_name)
{
    (void)user;
    return job_name && strcmp(job_name, "slow") == 0;
}

static bool wait_at_pixel(void *user, int x, int y)
{
    (void)user;
    (void)x;
    (void)y;
    usleep(1000);
    return true;
}

static atomic_bool urgent_is_sent;

static bool wait_for_urgent(void *user, int x, int y)
{
    while (!atomic_load(&urgent_is_sent))
        usleep(1000);
    return wait_at_pixel(user, x, y);
}

START_TEST(test_worker__job_of_higher_priority_comes_within_a_long_batch)
{
    static const struct pen_worker_fault slow = {.wanted = is_slow, .pixel = wait_for_urgent};
    char urgent[PEN_ID_BYTES];
    bed.fault = &slow;
    jobs_bed_open(&bed);
    bed.batch_ms = 1;
    jobs_worker_start(&bed);
    jobs_submit(&bed,
                "{\"scene\": \"builtin:spheres\", \"name\": \"slow\","
                " \"render\": {\"width\": 96, \"height\": 64, \"tile\": 8}}",
                id);
    while (store_job_state(bed.bed.store, id) == PEN_JOB_QUEUED)
        usleep(1000);
    jobs_submit(&bed,
                "{\"scene\": \"builtin:spheres\", \"priority\": 5,"
                " \"render\": {\"width\": 16, \"height\": 12}}",
                urgent);
    atomic_store(&urgent_is_sent, true);
    ck_assert_int_eq(jobs_wait(&bed, urgent), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    ck_assert(jobs_did_not_wait(&bed, urgent, id));
    jobs_bed_close(&bed);
    bed.fault = NULL;
}
END_TEST

/* Pixels are stored in slices. */
START_TEST(test_worker__large_batches_give_the_pixels_of_a_direct_render)
{
    static const char *const sizes[] = {
        ", \"render\": {\"width\": 611, \"height\": 401}",
        ", \"render\": {\"width\": 401, \"height\": 611, \"tile\": 7}",
        ", \"render\": {\"width\": 511, \"height\": 303, \"tile\": 400}",
        ", \"render\": {\"width\": 300, \"height\": 450, \"tile\": 4096}"};
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < 4; i++) {
        jobs_submit(&bed, jobs_scene(sizes[i]), id);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        struct pen_film *film = render_directly(jobs_scene(sizes[i]));
        compare_with_film(film);
        pen_film_free(film);
    }
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_worker__each_view_is_rendered_from_its_camera)
{
    static const char views[] =
        ", \"views\": [{\"name\": \"near\"}, {\"name\": \"far\", \"camera\": {\"position\":"
        " [0, 1, 30]}}], \"render\": {\"width\": 20, \"height\": 20}";
    static const char near_only[] = ", \"render\": {\"width\": 20, \"height\": 20}";
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(views), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    struct pen_film *film = render_directly(jobs_scene(near_only));
    compare_with_film(film);
    struct pen_buf near = jobs_image(&bed, id, "near", "pfm");
    struct pen_buf far = jobs_image(&bed, id, "far", "pfm");
    ck_assert_uint_eq(near.bytes, far.bytes);
    ck_assert_int_ne(memcmp(near.data, far.data, near.bytes), 0);
    pen_buf_release(&near);
    pen_buf_release(&far);
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

/* Waits until some of the job's pixels are committed. */
static void wait_for_progress(void)
{
    for (int i = 0; i < 600; i++) {
        struct pen_job_record job = store_job_get(bed.bed.store, id);
        int64_t done = job.done_pixels;
        enum pen_job_state state = job.state;
        pen_job_record_release(&job);
        ck_assert(!pen_job_state_ended(state));
        if (done > 0)
            return;
        usleep(50000);
    }
    ck_abort_msg("no progress");
}

/* One batch of many seconds: two mirrors that face each other, and no limit on the bounces. */
static const char endless_batch[] =
    "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 0], \"look_at\":"
    " [0, 0, -1]}, \"materials\": {\"mirror\": {\"kr\": 1}}, \"objects\": ["
    "{\"type\": \"plane\", \"point\": [0, 0, -1], \"normal\": [0, 0, 1], \"material\": \"mirror\"},"
    "{\"type\": \"plane\", \"point\": [0, 0, 1], \"normal\": [0, 0, -1], \"material\": "
    "\"mirror\"}],"
    "\"render\": {\"width\": 400, \"height\": 400, \"max_depth\": 65536, \"min_contribution\": 0}}";

static void wait_for_state(enum pen_job_state wanted)
{
    for (int i = 0; i < 6000 && store_job_state(bed.bed.store, id) != wanted; i++)
        usleep(10000);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), wanted);
}

static void cancel_job(void)
{
    struct pen_job_snapshot snapshot;
    struct pen_status st;
    store_must(pen_jobs_cancel(bed.jobs, id, NULL, &snapshot, &st), &st, "cancel");
    ck_assert_int_eq(snapshot.state, PEN_JOB_CANCELLED);
    json_decref(snapshot.json);
}

START_TEST(test_worker__cancel_reaches_a_running_batch)
{
    char next[PEN_ID_BYTES];
    int kinds[2];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, endless_batch, id);
    count_batches(kinds);
    ck_assert_int_eq(kinds[PEN_BATCH_RENDER], 1);
    wait_for_state(PEN_JOB_RUNNING);
    usleep(300000);
    jobs_submit(&bed, jobs_scene(one_batch), next);
    cancel_job();
    int64_t begin_ns = pen_clock_ns();
    /* The next job is done only after the worker has left the first one. */
    ck_assert_int_eq(jobs_wait(&bed, next), PEN_JOB_SUCCEEDED);
    int64_t took_ms = (pen_clock_ns() - begin_ns) / 1000000;
    ck_assert_timed(took_ms < 30000);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_CANCELLED);
    jobs_bed_close(&bed);
}
END_TEST

static void check_error(const char *type, int status)
{
    json_t *job = jobs_get(&bed, id);
    json_t *error = json_object_get(job, "error");
    ck_assert_str_eq(json_string_value(json_object_get(error, "type")), type);
    ck_assert_int_eq(json_integer_value(json_object_get(error, "status")), status);
    ck_assert_ptr_nonnull(json_string_value(json_object_get(error, "detail")));
    ck_assert_str_eq(json_string_value(json_object_get(job, "state")), "failed");
    json_decref(job);
}

static atomic_int stuck_reports;
static atomic_bool holds_up, in_call;

/* On a busy machine render threads may be slow to stop after a call, which does not matter here. */
static void count_stuck(void *user)
{
    (void)user;
    atomic_fetch_add(&stuck_reports, atomic_load(&in_call));
}

/* Another writer of the store, which is slow, as when the disk is slow to sync: from the first
 * pixel of the batch on, for two seconds. */
static pthread_t slow_writer;

static void *write_slowly(void *user)
{
    struct pen_status st;
    struct pen_db *db = pen_db_open(bed.bed.url, false, &st);
    (void)user;
    store_must(db && pen_db_begin(db, PEN_DB_WRITE, &st), &st, "write lock");
    atomic_store(&in_call, true);
    usleep(2000000);
    atomic_store(&in_call, false);
    pen_db_end(db, false, &st);
    pen_db_close(db);
    return NULL;
}

static bool is_any(void *user, const char *job_name)
{
    (void)user, (void)job_name;
    return true;
}

static bool begin_to_write(void *user, int x, int y)
{
    (void)user;
    if (x == 0 && y == 0 && atomic_exchange(&holds_up, false)) {
        ck_assert_int_eq(pthread_create(&slow_writer, NULL, write_slowly, NULL), 0);
        while (!atomic_load(&in_call))
            usleep(100);
    }
    return true;
}

static void begin_with_slow_writer(void)
{
    static const struct pen_worker_fault fault = {.wanted = is_any, .pixel = begin_to_write};
    jobs_bed_open(&bed);
    bed.fault = &fault;
    bed.stuck = count_stuck;
    atomic_store(&holds_up, true);
    jobs_worker_start(&bed);
}

/* Long after a batch is done for readers, its worker may still wait for the store. Its render
 * threads, which have ended, are not taken for stuck. */
START_TEST(test_worker__slow_commit_is_not_a_stuck_thread)
{
    begin_with_slow_writer();
    jobs_submit(&bed, jobs_scene(one_batch), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    pthread_join(slow_writer, NULL);
    ck_assert_int_eq(atomic_load(&stuck_reports), 0);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_worker__job_that_takes_too_long_fails)
{
    char body[2000];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    snprintf(body, sizeof body, "{\"timeout_seconds\": 0.5, \"scene\": %s}", endless_batch);
    jobs_submit(&bed, body, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    check_error("urn:penumbra:problem:timeout", 504);
    jobs_bed_close(&bed);
}
END_TEST

/* A batch may be done before the first check of the heartbeat. */
START_TEST(test_worker__short_job_that_takes_longer_than_its_timeout_fails)
{
    char body[4200];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    snprintf(body, sizeof body, "{\"timeout_seconds\": 0.001, \"scene\": %s}",
             jobs_scene(", \"render\": {\"width\": 150, \"height\": 110}"));
    jobs_submit(&bed, body, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    check_error("urn:penumbra:problem:timeout", 504);
    jobs_bed_close(&bed);
}
END_TEST

/* The timeout counts what workers have told of their time, under earlier attempts too. */
START_TEST(test_worker__job_whose_time_was_spent_by_other_workers_fails)
{
    struct pen_status st;
    char body[4200];
    jobs_bed_open(&bed);
    snprintf(body, sizeof body, "{\"timeout_seconds\": 3600, \"scene\": %s}",
             jobs_scene(one_batch));
    jobs_submit(&bed, body, id);
    struct pen_claim claim = store_claim(bed.bed.store, "w");
    claim.spent_us = (int64_t)3600 * 1000000;
    store_must(pen_store_release(bed.bed.store, &claim, &st), &st, "release");
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    check_error("urn:penumbra:problem:timeout", 504);
    jobs_bed_close(&bed);
}
END_TEST

/* Time in which no worker has the job, and steps of the clock, are not counted. */
START_TEST(test_worker__job_that_was_started_long_ago_has_its_time_left)
{
    struct pen_status st;
    char body[4200];
    jobs_bed_open(&bed);
    snprintf(body, sizeof body, "{\"timeout_seconds\": 3600, \"scene\": %s}",
             jobs_scene(one_batch));
    jobs_submit(&bed, body, id);
    struct pen_claim claim = store_claim(bed.bed.store, "w");
    store_must(pen_store_release(bed.bed.store, &claim, &st), &st, "release");
    store_run_sql(&bed.bed, "UPDATE job SET started_ms = started_ms - 86400000", NULL, 0);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_bed_close(&bed);
}
END_TEST

/* Stops a job of several batches once some are done, as if they had taken so long. */
static void stop_after(int64_t spent_us)
{
    char sql[80];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(several_batches), id);
    wait_for_progress();
    jobs_worker_stop(&bed);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_RUNNING);
    snprintf(sql, sizeof sql, "UPDATE job SET spent_us = %lld", (long long)spent_us);
    store_run_sql(&bed.bed, sql, NULL, 0);
}

START_TEST(test_worker__job_that_has_taken_too_long_fails)
{
    stop_after(INT64_C(40000000));
    bed.max_seconds = 40;
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    check_error("urn:penumbra:problem:too-large", 413);
    jobs_bed_close(&bed);
}
END_TEST

/* What has passed before its pixels, or in other ways than by rendering, is counted once and not
 * for each of its pixels. */
START_TEST(test_worker__job_that_took_long_to_begin_succeeds)
{
    stop_after(INT64_C(1000000000));
    bed.max_seconds =
        1200; /* three quarters at most are done: at that pace, all would take 1333 s */
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_bed_close(&bed);
}
END_TEST

/* A millisecond for each of 240 000 pixels, on two threads, in batches of four seconds: the third
 * tells that a minute is not enough. */
START_TEST(test_worker__job_whose_pace_tells_that_it_takes_too_long_fails)
{
    static const struct pen_worker_fault slow = {.wanted = is_slow, .pixel = wait_at_pixel};
    double share = 1;
    bed.fault = &slow;
    jobs_bed_open(&bed);
    bed.max_seconds = 60;
    jobs_worker_start(&bed);
    jobs_submit(&bed,
                "{\"scene\": \"builtin:spheres\", \"name\": \"slow\","
                " \"render\": {\"width\": 600, \"height\": 400, \"light_samples\": 1}}",
                id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    check_error("urn:penumbra:problem:too-large", 413);
    json_t *job = jobs_get(&bed, id);
    ck_assert_int_eq(json_unpack(job, "{s:{s:F}}", "progress", "fraction", &share), 0);
    ck_assert(share > 0 && share < 0.35);
    json_decref(job);
    jobs_bed_close(&bed);
    bed.fault = NULL;
}
END_TEST

START_TEST(test_worker__job_that_is_expected_to_take_what_is_allowed_succeeds)
{
    stop_after(INT64_C(40000000));
    bed.max_seconds = 10000000;
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_bed_close(&bed);
}
END_TEST

static void *stop_when_ended(void *stop)
{
    jobs_wait(&bed, id);
    atomic_store((atomic_bool *)stop, true);
    pen_store_wake(bed.bed.store);
    return NULL;
}

START_TEST(test_worker__scene_beyond_the_memory_cap_fails_its_job_alone)
{
    struct pen_status st;
    struct pen_worker_options options = {.id = "small:1:1", .threads = 1, .scene_cap_bytes = 500};
    atomic_bool stop = false;
    jobs_bed_open(&bed);
    options.store_url = bed.bed.url;
    jobs_submit(&bed, jobs_scene(one_batch), id);
    pthread_t thread;
    ck_assert_int_eq(pthread_create(&thread, NULL, stop_when_ended, &stop), 0);
    store_must(pen_worker_run(&options, &stop, &st), &st, "worker");
    pthread_join(thread, NULL);
    check_error("urn:penumbra:problem:no-memory", 503);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_worker__stop_leaves_the_rest_to_the_next_worker)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(several_batches), id);
    wait_for_progress();
    jobs_worker_stop(&bed);
    ck_assert_int_eq(store_worker_died(bed.bed.store, "test:1:1"), 0);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_RUNNING);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_worker__killed_in_mid_job_another_finishes_with_the_same_bytes)
{
    int status;
    store_bed_make(&bed.bed);
    pid_t pid = jobs_worker_fork(&bed);
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(several_batches), id);
    wait_for_progress();
    kill(pid, SIGKILL);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    ck_assert(WIFSIGNALED(status));
    store_worker_died(bed.bed.store, "doomed:1:1");
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.state, PEN_JOB_RUNNING);
    ck_assert_int_gt(job.done_pixels, 0);
    pen_job_record_release(&job);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    struct pen_film *film = render_directly(jobs_scene(several_batches));
    compare_with_film(film);
    pen_film_free(film);
    job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("worker", test_worker__one_batch_gives_the_pixels_of_a_direct_render,
          test_worker__several_batches_give_the_pixels_of_a_direct_render,
          test_worker__meshes_give_the_pixels_of_a_direct_render,
          test_worker__long_batches_are_divided,
          test_worker__job_of_higher_priority_comes_within_a_long_batch,
          test_worker__large_batches_give_the_pixels_of_a_direct_render,
          test_worker__each_view_is_rendered_from_its_camera,
          test_worker__cancel_reaches_a_running_batch,
          test_worker__slow_commit_is_not_a_stuck_thread,
          test_worker__job_that_takes_too_long_fails,
          test_worker__short_job_that_takes_longer_than_its_timeout_fails,
          test_worker__job_whose_time_was_spent_by_other_workers_fails,
          test_worker__job_that_was_started_long_ago_has_its_time_left,
          test_worker__job_that_has_taken_too_long_fails,
          test_worker__job_that_took_long_to_begin_succeeds,
          test_worker__job_whose_pace_tells_that_it_takes_too_long_fails,
          test_worker__job_that_is_expected_to_take_what_is_allowed_succeeds,
          test_worker__scene_beyond_the_memory_cap_fails_its_job_alone,
          test_worker__stop_leaves_the_rest_to_the_next_worker,
          test_worker__killed_in_mid_job_another_finishes_with_the_same_bytes)

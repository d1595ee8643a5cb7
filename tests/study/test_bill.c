/* SPDX-License-Identifier: MIT */
/* The bill: each effect's row lacks that effect. Its picture and rays are those of a scene that is
 * changed by hand, and the reports show them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "report/report.h"
#include "study/bill.h"
#include "study/leave_out.h"
#include "support/kit.h"
#include "support/suite.h"
#include "support/unfinished.h"

static struct kit kit;

/* A scene that calls for every effect. */
static void everything(void)
{
    static const struct pen_pattern tiles = {true, {1, 0.5, 0.25}, {0, 0.25, 0.5},
                                             0.75, {0, 0, 0},      {0, 0, 0}};
    static const struct pen_patterns tiled = {.of = {[PEN_COLOUR_KD] = &tiles}};
    struct pen_material m = kit_matte(0.1);
    kit_medley(&kit);
    kit.settings.width = 20;
    kit.settings.height = 15;
    kit.settings.lens_samples = kit.settings.blur_samples = 2;
    kit.settings.samples_per_pixel = 3;
    kit.desc.has_sky = true;
    kit.desc.sky = (struct pen_sky){{0.1, 0.2, 0.6}, {0.05, 0.04, 0.03}, {0, 1, 0}};
    kit.view.camera.aperture_radius = 0.25;
    kit.view.camera.focus_distance = 8;
    kit.materials[0].patterns = &tiled;
    m.kt = pen_vec3(0.9, 0.8, 0.9);
    m.kr = pen_vec3(0.1, 0.1, 0.1);
    m.ior = 1.5;
    m.reflection_blur = 10;
    m.transmission_blur = 5;
    kit_sphere(&kit, pen_vec3(-1, 2, 1), 0.75, kit_material(&kit, m));
    const uint32_t first = kit.desc.object_count;
    kit_smooth(&kit, pen_vec3(1.5, -0.25, 3), 1);
    kit_group(&kit, first, NULL);
}

static struct pen_bill bill_of(const struct pen_bill_task *task)
{
    struct pen_bill bill;
    struct pen_status st;
    ck_assert_msg(pen_bill_make(task, &bill, &st), "%s", st.msg);
    return bill;
}

static struct pen_bill_task task_of(struct pen_thread_pool *pool)
{
    return (struct pen_bill_task){
        .frame = {.desc = &kit.desc, .pool = pool}, .settings = &kit.settings, .repeats = 2};
}

/* The effects of the scene without one of them. Includes effects of other views, which the kit does
 * not have. */
static unsigned effects_without(unsigned effect, struct pen_settings *settings)
{
    struct pen_scene_desc without;
    struct pen_arena *arena = pen_arena_new(0);
    *settings = kit.settings;
    ck_assert(pen_scene_leave_out(&kit.desc, effect, arena, &without, settings));
    const unsigned effects = pen_desc_effects(&without, settings);
    pen_arena_free(arena);
    return effects;
}

START_TEST(test_bill__each_effect_can_be_left_out)
{
    everything();
    struct pen_settings settings;
    const unsigned all = (1u << PEN_FX_COUNT) - 1;
    ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), all);
    for (int i = 0; i < PEN_FX_COUNT; i++) {
        const unsigned left = effects_without(1u << i, &settings), gone = all & ~left;
        if (1u << i == PEN_FX_ANTI_ALIASING) { /* the lens needs several samples */
            ck_assert_uint_eq(gone, 0);
            ck_assert_int_eq(settings.samples_per_pixel, 1);
            continue;
        }
        ck_assert_msg(gone >> i & 1, "%s stays", pen_effect_name(i));
        const unsigned with_it =
            1u << i == PEN_FX_TRANSMISSION
                ? PEN_FX_SHADOW_TRANSMITTANCE | PEN_FX_REFRACTION | PEN_FX_FROSTED
                : 0;
        ck_assert_msg((gone & ~(1u << i)) == with_it, "without %s: %x", pen_effect_name(i), gone);
    }
}
END_TEST

START_TEST(test_bill__rows_are_the_scene_changed)
{
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    everything();
    struct pen_bill_task task = task_of(pool);
    struct pen_bill bill = bill_of(&task);
    ck_assert_int_eq(bill.rows, PEN_FX_COUNT + 1);
    ck_assert(bill.row[0].effect == 0 && bill.row[0].rmse == 0 && bill.row[0].flip == 0);
    for (int i = 0; i < bill.rows; i++) {
        const struct pen_bill_row *row = &bill.row[i];
        struct pen_settings settings = kit.settings;
        struct pen_scene_desc desc = kit.desc;
        struct pen_arena *arena = pen_arena_new(0);
        ck_assert(pen_scene_leave_out(&kit.desc, row->effect, arena, &desc, &settings));
        struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_AUTO, 0, &st);
        float *film = kit_film(scene, &settings, 1);
        ck_assert_mem_eq(film, row->rgb, 3 * 20 * 15 * sizeof *film);
        ck_assert(row->time.min > 0 && row->time.min <= row->time.median &&
                  row->time.median <= row->time.max);
        ck_assert(row->effect == 0 || (row->rmse > 0 && row->flip > 0 && row->flip < 1));
        free(film);
        pen_scene_free(scene);
        pen_arena_free(arena);
    }
    const uint64_t shadows = bill.row[0].rays.shadow;
    for (int i = 1; i < bill.rows; i++) {
        const struct pen_ray_counts *rays = &bill.row[i].rays;
        if (bill.row[i].effect == PEN_FX_TRANSMISSION)
            ck_assert_uint_eq(rays->transmission, 0);
        if (bill.row[i].effect == PEN_FX_HARD_SHADOWS || bill.row[i].effect == PEN_FX_SOFT_SHADOWS)
            ck_assert_uint_lt(rays->shadow, shadows);
    }
    pen_bill_release(&bill);
    pen_thread_pool_free(pool);
}
END_TEST

/* Transmitting surfaces block all light: the picture has opaque shadows. */
START_TEST(test_bill__opaque_shadows)
{
    kit_init(&kit);
    struct pen_material clear = kit_matte(0);
    clear.kt = pen_vec3(1, 1, 1);
    kit_sheet(&kit, 0, 9, kit_material(&kit, kit_matte(1)));
    kit_sphere(&kit, pen_vec3(0, 4, 4), 1, kit_material(&kit, clear));
    struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 8, 8), pen_vec3(1, 1, 1));
    for (int soft = 0; soft < 2; soft++) {
        light->radius = 0.25 * soft;
        kit.desc.opaque_shadows = false;
        ck_assert(kit_pixel(&kit, 0, 0, NULL).x > 0.1);
        kit.desc.opaque_shadows = true;
        ck_assert(kit_pixel(&kit, 0, 0, NULL).x == 0);
    }
    kit.desc.opaque_shadows = false;
}
END_TEST

START_TEST(test_bill__reports)
{
    static const char *const formats[] = {"text", "csv", "md", "json", "html"};
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    everything();
    struct pen_bill_task task = task_of(pool);
    struct pen_bill bill = bill_of(&task);
    struct pen_buf figures = {0};
    json_t *json = pen_bill_json(&bill, "a <scene>");
    pen_bill_figures(&bill, &figures);
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        struct pen_buf out = {0};
        ck_assert(pen_report_write(json, formats[i], &figures, &out, &st));
        char *text = (char *)out.data;
        for (char *c = text; strcmp(formats[i], "md") == 0 && (c = strchr(c, '\\'));)
            memmove(c, c + 1, strlen(c)); /* before each _ */
        for (int fx = 0; fx < PEN_FX_COUNT; fx++)
            ck_assert_msg(strstr(text, pen_effect_name(fx)) != NULL, "%s: %s", formats[i],
                          pen_effect_name(fx));
        ck_assert(strstr(text, "<scene>") == NULL || strcmp(formats[i], "json") == 0);
        pen_buf_release(&out);
    }
    pen_buf_release(&figures);
    const json_t *rows = json_object_get(json, "rows"), *first = json_array_get(rows, 0);
    ck_assert_uint_eq(json_array_size(rows), PEN_FX_COUNT + 1);
    ck_assert(json_is_null(json_object_get(first, "without")));
    ck_assert(json_object_get(first, "cost_ms") == NULL);
    ck_assert(json_object_get(json_array_get(rows, 1), "cost_ms") != NULL);
    json_decref(json);
    pen_bill_release(&bill);
    pen_thread_pool_free(pool);
}
END_TEST

/* Delays the threads, as other programs that use the processors do. */
static void wait_a_little(void *user, int thread, int x, int y)
{
    (void)thread;
    if (x == 0 && y == 0)
        ++*(int *)user;
    usleep(x == 0 ? 1000 : 0);
}

START_TEST(test_bill__spoiled_runs_are_repeated_and_tell_no_cost)
{
    int renders = 0;
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    everything();
    struct pen_bill_task task = task_of(pool);
    task.frame.pixel_begins = wait_a_little;
    task.frame.pixel_user = &renders;
    struct pen_bill bill = bill_of(&task);
    ck_assert_int_eq(bill.use.runs, 2 * bill.rows);
    ck_assert_int_eq(bill.use.spoiled, bill.use.runs);
    ck_assert_int_eq(renders,
                     bill.rows * (1 + 2 * 3)); /* a warm-up, and each run with two repeats */
    json_t *json = pen_bill_json(&bill, "x"),
           *row = json_array_get(json_object_get(json, "rows"), 1);
    ck_assert(json_is_null(json_object_get(row, "cost_ms")));
    ck_assert(json_is_null(json_object_get(row, "cost_below_ms")));
    ck_assert(json_is_number(json_object_get(row, "cost_rays")));
    struct pen_buf out = {0};
    ck_assert(pen_report_write(json, "text", NULL, &out, &st));
    const char *text = (const char *)out.data;
    ck_assert_msg(strstr(text, " runs are spoiled: other programs used") - text < 12, "%s", text);
    pen_buf_release(&out);
    json_decref(json);
    pen_bill_release(&bill);
    pen_thread_pool_free(pool);
}
END_TEST

/* Cancels once the last run is done. */
static void cancel_at_end(void *user, int done, int total)
{
    if (done == total)
        atomic_store((atomic_bool *)user, true);
}

START_TEST(test_bill__comparing_can_be_cancelled)
{
    struct pen_status st;
    struct pen_bill bill;
    atomic_bool cancel = false;
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    everything();
    struct pen_bill_task task = task_of(pool);
    task.frame.cancel = &cancel;
    task.frame.progress = cancel_at_end;
    task.frame.user = &cancel;
    ck_assert(!pen_bill_make(&task, &bill, &st) && st.code == PEN_CANCELLED);
    pen_bill_release(&bill);
    pen_thread_pool_free(pool);
}
END_TEST

/* Makes the bill until it ends, interrupted after each run. Returns the number of interruptions. */
static int make_in_parts(struct pen_bill_task *task, struct pen_bill *bill)
{
    struct unfinished_bed bed = {0};
    struct pen_status st;
    int interruptions = 0;
    task->frame.between = unfinished_keep;
    task->frame.user = &bed;
    for (bed.runs_left = 1; !pen_bill_make(task, bill, &st); bed.runs_left = 1) {
        ck_assert_msg(st.code == PEN_UNAVAILABLE, "%s", st.msg);
        pen_bill_release(bill);
        task->frame.kept = &bed.kept;
        interruptions++;
    }
    unfinished_release(&bed);
    return interruptions;
}

START_TEST(test_bill__interrupted_one_is_that_of_a_whole_one)
{
    struct pen_status st;
    struct pen_bill parts;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    everything();
    struct pen_bill_task task = task_of(pool);
    struct pen_bill whole = bill_of(&task);
    struct pen_bill_task again = task;
    ck_assert_int_eq(make_in_parts(&again, &parts), 3 * whole.rows);
    ck_assert_int_eq(parts.rows, whole.rows);
    for (int i = 0; i < whole.rows; i++) {
        const struct pen_bill_row *a = &whole.row[i], *b = &parts.row[i];
        ck_assert_mem_eq(a->rgb, b->rgb, 3 * 20 * 15 * sizeof *a->rgb);
        ck_assert_mem_eq(&a->rays, &b->rays, sizeof a->rays);
        ck_assert(a->effect == b->effect && strcmp(a->kernel, b->kernel) == 0);
        ck_assert(a->rmse == b->rmse && a->max_error == b->max_error && a->flip == b->flip);
        ck_assert(b->time.min > 0 && b->time.min <= b->time.median &&
                  b->time.median <= b->time.max);
    }
    ck_assert_mem_eq(&whole.whole.rays, &parts.whole.rays, sizeof whole.whole.rays);
    ck_assert_ptr_nonnull(parts.whole.tile_ms);
    pen_bill_release(&whole);
    pen_bill_release(&parts);
    pen_thread_pool_free(pool);
}
END_TEST

/* Whether the bill resumes from a state in which the first row took this long in the first pass. */
static bool goes_on_with(struct pen_bill_task *task, const struct pen_kept_study *kept)
{
    task->frame.kept = kept;
    struct pen_bill bill = bill_of(task);
    const bool goes_on = bill.row[0].runs[0].ms == 1e9;
    pen_bill_release(&bill);
    return goes_on;
}

START_TEST(test_bill__what_is_kept_of_another_one_is_not_used)
{
    static const char *const changes[][2] = {{"/version", "99"},
                                             {"/pool_threads", "7"},
                                             {"/host", "{}"},
                                             {"/done", "-1"},
                                             {"/done", "100"},
                                             {"/done", "34"},
                                             {"/rows", "[]"},
                                             {"/rows/3/runs", "[1, 2]"},
                                             {"/rows/3/runs", "[{}]"},
                                             {"/rows/3/primary", "1.5"},
                                             {"/rows/3/picture_hash", "\"\""},
                                             {"/rows/3/picture_hash", "7"},
                                             {"/rows/3/kernel", "\"none\""}};
    struct pen_status st;
    struct pen_bill bill;
    struct unfinished_bed bed = {.runs_left = 33};
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    everything();
    kit.settings.width = 10;
    kit.settings.height = 8;
    struct pen_bill_task task = task_of(pool), first = task;
    first.frame.between = unfinished_keep;
    first.frame.user = &bed;
    ck_assert(!pen_bill_make(&first, &bill, &st)); /* after three runs of the second repeat */
    pen_bill_release(&bill);
    json_t *marked = unfinished_changed(bed.state, "/rows/0/runs/0/ms", "1e9");
    struct pen_kept_study kept = bed.kept;
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        json_t *changed = unfinished_changed(marked, changes[i][0], changes[i][1]);
        kept.state = changed;
        ck_assert_msg(!goes_on_with(&task, &kept), "%s: %s", changes[i][0], changes[i][1]);
        json_decref(changed);
    }
    kept.state = NULL;
    ck_assert(!goes_on_with(&task, &kept));
    kept.state = marked;
    ck_assert(goes_on_with(&task, &kept));
    bed.picture[4][7] += 1;
    ck_assert(!goes_on_with(&task, &kept));
    json_decref(marked);
    unfinished_release(&bed);
    pen_thread_pool_free(pool);
}
END_TEST

PEN_SUITE("bill", test_bill__each_effect_can_be_left_out, test_bill__rows_are_the_scene_changed,
          test_bill__opaque_shadows, test_bill__reports,
          test_bill__spoiled_runs_are_repeated_and_tell_no_cost,
          test_bill__comparing_can_be_cancelled, test_bill__interrupted_one_is_that_of_a_whole_one,
          test_bill__what_is_kept_of_another_one_is_not_used)

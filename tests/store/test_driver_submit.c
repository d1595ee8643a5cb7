/* SPDX-License-Identifier: MIT */
/* Contract of a driver: what a submit writes. Unique constraints alone decide who was first with a
 * key, a scene document, a job id or an assemble batch; the loser's transaction goes on. */
#include <stdio.h>
#include <string.h>

#include "support/driver.h"

static struct driver_bed bed;

static bool add_key(struct pen_driver *driver, const char *key, unsigned char first_of_body,
                    int64_t created_ms)
{
    unsigned char body[32] = {first_of_body, 2, 3};
    char answer[16];
    snprintf(answer, sizeof answer, "answer %d", first_of_body);
    struct pen_key_row row = {"", key, body, answer, created_ms};
    bool added = false;
    DRIVER_DO(driver, key_add, &row, &added);
    return added;
}

START_TEST(test_driver_submit__first_with_a_key_stays)
{
    unsigned char body[32];
    struct pen_buf answer = {0};
    bool found;
    driver_bed_open(&bed, _i);
    DRIVER_RUN(bed.driver, begin_write);
    ck_assert(add_key(bed.driver, "k", 1, 1));
    ck_assert(!add_key(bed.driver, "k", 2, 1));
    ck_assert(add_key(bed.driver, "other", 3, 1)); /* the transaction goes on */
    DRIVER_RUN(bed.driver, commit);
    pen_buf_puts(&answer, "> ");
    DRIVER_DO(bed.driver, key_get, "", "k", body, &answer, &found);
    ck_assert(found);
    ck_assert_int_eq(body[0], 1);
    ck_assert_int_eq(body[2], 3);
    ck_assert_str_eq((const char *)answer.data, "> answer 1");
    DRIVER_DO(bed.driver, key_get, "", "other", body, NULL, &found);
    ck_assert(found);
    ck_assert_int_eq(body[0], 3);
    DRIVER_DO(bed.driver, key_get, "", "none", body, &answer, &found);
    ck_assert(!found);
    ck_assert_str_eq((const char *)answer.data, "> answer 1");
    pen_buf_release(&answer);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_submit__each_client_has_keys_of_its_own)
{
    unsigned char body[2][32] = {{7}, {8}}, found_body[32];
    bool added, found, more;
    driver_bed_open(&bed, _i);
    DRIVER_RUN(bed.driver, begin_write);
    for (int i = 0; i < 2; i++) {
        struct pen_key_row row = {i ? "token:b" : "token:a", "k", body[i], "answer", 10 + i};
        DRIVER_DO(bed.driver, key_add, &row, &added);
        ck_assert(added);
    }
    DRIVER_DO(bed.driver, key_get, "token:a", "k", found_body, NULL, &found);
    ck_assert(found && found_body[0] == 7);
    DRIVER_DO(bed.driver, key_get, "", "k", found_body, NULL, &found);
    ck_assert(!found);
    DRIVER_DO(bed.driver, keys_remove, 11, 100, &more);
    DRIVER_DO(bed.driver, key_get, "token:a", "k", found_body, NULL, &found);
    ck_assert(!found);
    DRIVER_DO(bed.driver, key_get, "token:b", "k", found_body, NULL, &found);
    ck_assert(found && found_body[0] == 8);
    DRIVER_RUN(bed.driver, commit);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_submit__keys_older_than_a_time_are_removed)
{
    unsigned char body[32];
    bool found, more;
    driver_bed_open(&bed, _i);
    DRIVER_RUN(bed.driver, begin_write);
    add_key(bed.driver, "old", 1, 999);
    add_key(bed.driver, "young", 2, 1000);
    DRIVER_DO(bed.driver, keys_remove, 1000, 100, &more);
    DRIVER_RUN(bed.driver, commit);
    DRIVER_DO(bed.driver, key_get, "", "old", body, NULL, &found);
    ck_assert(!found);
    DRIVER_DO(bed.driver, key_get, "", "young", body, NULL, &found);
    ck_assert(found);
    driver_bed_close(&bed);
}
END_TEST

/* What a racer tries to insert; `value` of the race is whether it did. */
enum insert { INSERT_KEY, INSERT_SCENE, INSERT_JOB, INSERT_KINDS };

struct insertion {
    enum insert kind;
    int64_t scene;
    int racer, number; /* number: of the row, the same for all racers */
    bool added, found;
    int64_t id;
};

static bool insert_key(struct pen_driver *driver, struct insertion *in, struct pen_status *st)
{
    char key[16], answer[16];
    unsigned char body[32] = {(unsigned char)in->racer};
    snprintf(key, sizeof key, "key %d", in->number);
    snprintf(answer, sizeof answer, "%d", in->racer);
    struct pen_key_row row = {"", key, body, answer, 1};
    return driver->ops->key_add(driver, &row, &in->added, st) &&
           driver->ops->key_get(driver, "", key, body, NULL, &in->found, st) &&
           (in->id = body[0], true);
}

static bool insert_scene(struct pen_driver *driver, struct insertion *in, struct pen_status *st)
{
    unsigned char hash[32] = {100, (unsigned char)in->number};
    struct pen_blob_start document = {.total = 5, .data = "scene", .bytes = 5};
    return driver->ops->scene_add(driver, hash, &document, &in->id, &in->added, st) &&
           driver->ops->scene_find(driver, hash, &in->id, &in->found, st);
}

static bool insert_job(struct pen_driver *driver, struct insertion *in, struct pen_status *st)
{
    struct store_job job;
    struct pen_job_key key = {0};
    int64_t number;
    store_job_init(&job, in->number, 1, 1);
    bool ok = driver->ops->job_add(driver, &job.job, in->scene, 16, &number, &in->added, st) &&
              (!in->added || driver->ops->view_add(driver, number, 0, &job.view[0], 1, st)) &&
              driver->ops->job_find(driver, job.id, &key, &in->found, st);
    in->id = key.number;
    return ok;
}

static bool write_insertion(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    struct insertion *in = arg;
    switch (in->kind) {
    case INSERT_KEY:
        return insert_key(driver, in, st);
    case INSERT_SCENE:
        return insert_scene(driver, in, st);
    case INSERT_JOB:
        return insert_job(driver, in, st);
    case INSERT_KINDS:
        break;
    }
    return false;
}

enum { ROWS = 16 };

static bool insert_all(struct pen_driver *driver, struct driver_race *race, int racer,
                       struct pen_status *st)
{
    struct insertion in = *(const struct insertion *)race->user;
    in.racer = racer;
    for (int i = 0; i < ROWS; i++) {
        in.number = i;
        if (!driver_write(driver, write_insertion, &in, st))
            return false;
        if (!in.found)
            return pen_fail(st, PEN_INTERNAL, "row %d is not seen by racer %d", i, racer);
        race->value[racer][2 * i] = in.added;
        race->value[racer][2 * i + 1] = in.id;
    }
    return true;
}

/* Every row is added by one racer, and all see that one. */
static void check_race(const struct driver_race *race)
{
    for (int row = 0; row < ROWS; row++) {
        int64_t added = 0;
        for (int i = 0; i < DRIVER_RACERS; i++) {
            added += race->value[i][2 * row];
            ck_assert_int_eq(race->value[i][2 * row + 1], race->value[0][2 * row + 1]);
        }
        ck_assert_msg(added == 1, "row %d was added by %d", row, (int)added);
    }
}

static void race_inserts(int kind, enum insert what)
{
    for (int racers = 0; racers < DRIVER_RACER_KINDS; racers++) {
        driver_bed_open(&bed, kind);
        struct insertion in = {.kind = what};
        struct driver_job any = driver_submit_new(bed.driver, 999, 1, 1, 0);
        in.scene = any.scene;
        check_race(driver_race(&bed, (enum driver_racers)racers, insert_all, &in));
        driver_bed_close(&bed);
    }
}

START_TEST(test_driver_submit__race_for_a_key_has_one_winner)
{
    race_inserts(_i, INSERT_KEY);
}
END_TEST

START_TEST(test_driver_submit__race_for_a_scene_document_has_one_winner)
{
    race_inserts(_i, INSERT_SCENE);
}
END_TEST

START_TEST(test_driver_submit__race_for_a_job_id_has_one_winner)
{
    race_inserts(_i, INSERT_JOB);
}
END_TEST

static int64_t add_job(struct pen_driver *driver, int n, int64_t scene, bool *added)
{
    struct store_job in;
    int64_t number = 0;
    store_job_init(&in, n, 1, 1);
    DRIVER_DO(driver, job_add, &in.job, scene, 16, &number, added);
    if (*added)
        DRIVER_DO(driver, view_add, number, 0, &in.view[0], 1);
    return number;
}

START_TEST(test_driver_submit__second_job_of_an_id_is_told_and_changes_nothing)
{
    struct store_job other;
    bool added;
    int64_t number;
    driver_bed_open(&bed, _i);
    struct driver_job first = driver_submit_new(bed.driver, 1, 1, 2, 5);
    store_job_init(&other, 1, 1, 1);
    other.job.request = "{\"name\": \"another\"}";
    other.job.priority = 7;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_add, &other.job, first.scene, 16, &number, &added);
    ck_assert(!added);
    add_job(bed.driver, 2, first.scene, &added); /* the transaction goes on */
    ck_assert(added);
    DRIVER_RUN(bed.driver, commit);
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.record.number, first.number);
    ck_assert_str_eq(row.record.request, "{\"name\": \"test\"}");
    ck_assert_int_eq(row.record.priority, 5);
    pen_job_record_release(&row.record);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_submit__numbers_grow_and_are_never_used_again)
{
    bool changed;
    driver_bed_open(&bed, _i);
    struct driver_job first = driver_submit_new(bed.driver, 1, 1, 2, 0);
    struct driver_job second = driver_submit_new(bed.driver, 2, 1, 2, 0);
    ck_assert_int_gt(second.number, first.number);
    ck_assert_int_gt(second.batch[0], first.batch[1]);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_end, second.number, PEN_JOB_CANCELLED, NULL, 9, &changed);
    DRIVER_DO(bed.driver, job_remove, second.number);
    DRIVER_RUN(bed.driver, commit);
    struct driver_job third = driver_submit_new(bed.driver, 3, 1, 2, 0);
    ck_assert_int_gt(third.number, second.number);
    ck_assert_int_gt(third.batch[0], second.batch[1]);
    driver_bed_close(&bed);
}
END_TEST

static bool add_batch(struct pen_driver *driver, int64_t job, int view, enum pen_batch_kind kind)
{
    struct pen_batch_add add = {.job = job, .batch = {.view = view, .kind = kind}};
    bool added = false;
    DRIVER_RUN(driver, begin_write);
    DRIVER_DO(driver, batch_add, &add, &added);
    DRIVER_RUN(driver, commit);
    return added;
}

START_TEST(test_driver_submit__view_has_one_assemble_batch)
{
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 2, 2, 0);
    struct driver_job other = driver_submit_new(bed.driver, 2, 1, 2, 0);
    ck_assert(add_batch(bed.driver, job.number, 0, PEN_BATCH_ASSEMBLE));
    ck_assert(!add_batch(bed.driver, job.number, 0, PEN_BATCH_ASSEMBLE));
    ck_assert(add_batch(bed.driver, job.number, 1, PEN_BATCH_ASSEMBLE));
    ck_assert(add_batch(bed.driver, other.number, 0, PEN_BATCH_ASSEMBLE));
    ck_assert(add_batch(bed.driver, job.number, 0, PEN_BATCH_RENDER));
    ck_assert(add_batch(bed.driver, job.number, 0, PEN_BATCH_RENDER));
    driver_bed_close(&bed);
}
END_TEST

static bool write_assemble(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    int64_t *value = arg;
    struct pen_batch_add add = {.job = value[0], .batch = {.kind = PEN_BATCH_ASSEMBLE}};
    bool added = false;
    bool ok = driver->ops->batch_add(driver, &add, &added, st);
    value[1] = added;
    return ok;
}

static bool add_assemble(struct pen_driver *driver, struct driver_race *race, int racer,
                         struct pen_status *st)
{
    race->value[racer][0] = *(const int64_t *)race->user;
    return driver_write(driver, write_assemble, race->value[racer], st);
}

START_TEST(test_driver_submit__race_for_an_assemble_batch_has_one_winner)
{
    driver_bed_open(&bed, _i);
    for (int i = 0; i < 4 * DRIVER_RACER_KINDS; i++) {
        int64_t added = 0;
        struct driver_job job = driver_submit_new(bed.driver, i, 1, 2, 0);
        const struct driver_race *race = driver_race(
            &bed, (enum driver_racers)(i % DRIVER_RACER_KINDS), add_assemble, &job.number);
        for (int r = 0; r < DRIVER_RACERS; r++)
            added += race->value[r][1];
        ck_assert_int_eq(added, 1);
    }
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_submit__unused_scene_documents_are_removed)
{
    struct store_job in;
    int64_t number;
    bool found, changed;
    driver_bed_open(&bed, _i);
    struct driver_job kept = driver_submit_new(bed.driver, 1, 1, 1, 0);
    struct driver_job gone = driver_submit_new(bed.driver, 2, 1, 1, 0);
    struct driver_job late = driver_submit_new(bed.driver, 3, 1, 1, 0);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_end, gone.number, PEN_JOB_CANCELLED, NULL, 9, &changed);
    DRIVER_DO(bed.driver, job_remove, gone.number);
    DRIVER_DO(bed.driver, job_end, late.number, PEN_JOB_CANCELLED, NULL, 9, &changed);
    DRIVER_DO(bed.driver, job_remove, late.number);
    DRIVER_DO(bed.driver, scene_remove_unused, kept.scene); /* it is used */
    DRIVER_DO(bed.driver, scene_remove_unused, gone.scene);
    store_job_init(&in, 1, 1, 1);
    DRIVER_DO(bed.driver, scene_find, in.sha256, &number, &found);
    ck_assert(found);
    ck_assert_int_eq(number, kept.scene);
    store_job_init(&in, 2, 1, 1);
    DRIVER_DO(bed.driver, scene_find, in.sha256, &number, &found);
    ck_assert(!found);
    store_job_init(&in, 3, 1, 1);
    DRIVER_DO(bed.driver, scene_find, in.sha256, &number, &found);
    ck_assert(found);
    DRIVER_DO(bed.driver, scene_remove_unused, 0);
    DRIVER_DO(bed.driver, scene_find, in.sha256, &number, &found);
    ck_assert(!found);
    store_job_init(&in, 1, 1, 1);
    DRIVER_DO(bed.driver, scene_find, in.sha256, &number, &found);
    ck_assert(found);
    DRIVER_RUN(bed.driver, commit);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: submit", test_driver_submit__first_with_a_key_stays,
             test_driver_submit__each_client_has_keys_of_its_own,
             test_driver_submit__keys_older_than_a_time_are_removed,
             test_driver_submit__race_for_a_key_has_one_winner,
             test_driver_submit__race_for_a_scene_document_has_one_winner,
             test_driver_submit__race_for_a_job_id_has_one_winner,
             test_driver_submit__second_job_of_an_id_is_told_and_changes_nothing,
             test_driver_submit__numbers_grow_and_are_never_used_again,
             test_driver_submit__view_has_one_assemble_batch,
             test_driver_submit__race_for_an_assemble_batch_has_one_winner,
             test_driver_submit__unused_scene_documents_are_removed)

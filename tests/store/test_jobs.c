/* SPDX-License-Identifier: MIT */
/* Jobs in the store: submit and idempotency keys, get, list, scene, cancel, delete, purge. */
#include <stdio.h>
#include <string.h>

#include "store/store.h"
#include "support/store.h"
#include "support/suite.h"

START_TEST(test_jobs__submitted_job_is_there_as_given)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct store_job in;
    store_job_init(&in, 1, 2, 3);
    in.job.priority = -7;
    in.job.timeout_ms = 5000;
    store_job_submit(bed.store, &in);
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_str_eq(job.id, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_QUEUED);
    ck_assert_int_eq(job.revision, 1);
    ck_assert_str_eq(job.kind, "render");
    ck_assert_str_eq(job.request, in.job.request);
    ck_assert_ptr_null(job.error);
    ck_assert_int_eq(job.priority, -7);
    ck_assert_int_eq(job.max_attempts, 3);
    ck_assert_int_eq(job.attempts, 0);
    ck_assert_int_eq(job.timeout_ms, 5000);
    ck_assert_int_eq(job.created_ms, 1001);
    ck_assert_int_eq(job.started_ms, 0);
    ck_assert_int_eq(job.done_pixels, 0);
    ck_assert_int_eq(job.total_pixels, 6 * 16);
    pen_job_record_release(&job);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__counts_are_by_state)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct store_job first, second;
    store_job_init(&first, 1, 1, 2);
    store_job_init(&second, 2, 1, 3);
    store_job_submit(bed.store, &first);
    store_job_submit(bed.store, &second);
    struct pen_status st;
    ck_assert(pen_store_cancel(bed.store, second.id, NULL, &st));
    store_claim(bed.store, "w");
    struct pen_counts counts;
    store_must(pen_store_counts(bed.store, &counts, &st), &st, "counts");
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_int_eq(counts.jobs[s], s == PEN_JOB_RUNNING || s == PEN_JOB_CANCELLED);
    ck_assert_int_eq(counts.leased_batches, 1);
    ck_assert_int_eq(counts.open_batches, 1); /* the other one with tiles */
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__unknown_job_is_not_found)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_status st;
    struct pen_job_record job;
    struct pen_buf buf = {0};
    ck_assert(!pen_store_job(bed.store, "nobody", &job, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_scene(bed.store, "nobody", &buf, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_cancel(bed.store, "nobody", NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_delete(bed.store, "nobody", NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_artefact(bed.store, "nobody", 0, "beauty", "png", &buf, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_cache_put(bed.store, "nobody", 0, "beauty", "pfm", "x", 1, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_pixels(bed.store, "nobody", 0, NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_stats(bed.store, "nobody", NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_batches(bed.store, "nobody", NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    ck_assert(!pen_store_commits(bed.store, "nobody", 0, NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__scene_is_given_back_byte_for_byte)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct store_job in;
    store_job_init(&in, 1, 1, 1);
    static char document[200000];
    for (size_t i = 0; i < sizeof document; i++)
        document[i] = (char)(i * i % 251);
    in.job.scene = document;
    in.job.scene_bytes = sizeof document;
    store_job_submit(bed.store, &in);
    struct pen_status st;
    struct pen_buf scene = {0};
    store_must(pen_store_scene(bed.store, in.id, &scene, &st), &st, "scene");
    ck_assert_uint_eq(scene.bytes, sizeof document);
    ck_assert_mem_eq(scene.data, document, sizeof document);
    pen_buf_release(&scene);
    store_bed_close(&bed);
}
END_TEST

static enum pen_submit_result submit_of(const char *client, struct pen_store *store, int n,
                                        const char *key, unsigned char body, struct pen_buf *answer)
{
    struct store_job in;
    unsigned char hash[32] = {body};
    char text[32];
    snprintf(text, sizeof text, "answer %d", n);
    store_job_init(&in, n, 1, 1);
    in.job.client = client;
    in.job.idempotency_key = key;
    in.job.body_sha256 = hash;
    in.job.answer = text;
    struct pen_status st;
    enum pen_submit_result result;
    store_must(pen_store_submit(store, &in.job, &result, answer, &st), &st, "submit");
    return result;
}

static enum pen_submit_result submit_with_key(struct pen_store *store, int n, const char *key,
                                              unsigned char body, struct pen_buf *answer)
{
    return submit_of(NULL, store, n, key, body, answer);
}

START_TEST(test_jobs__key_gives_the_first_answer_again)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_buf answer = {0};
    ck_assert_int_eq(submit_with_key(bed.store, 1, "k", 9, &answer), PEN_SUBMIT_CREATED);
    ck_assert_uint_eq(answer.bytes, 0);
    ck_assert_int_eq(submit_with_key(bed.store, 2, "k", 9, &answer), PEN_SUBMIT_REPEATED);
    ck_assert_str_eq((char *)answer.data, "answer 1");
    ck_assert_int_eq(submit_with_key(bed.store, 3, "k", 8, &answer), PEN_SUBMIT_REUSED);
    ck_assert_int_eq(submit_with_key(bed.store, 4, "other", 8, &answer), PEN_SUBMIT_CREATED);
    struct pen_job_filter filter = {.state = -1, .limit = 10};
    struct pen_job_record *jobs;
    struct pen_status st;
    int count;
    store_must(pen_store_jobs(bed.store, &filter, &jobs, &count, &st), &st, "list");
    ck_assert_int_eq(count, 2);
    pen_job_records_free(jobs, count);
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__same_key_of_two_clients_makes_two_jobs)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_buf answer = {0};
    ck_assert_int_eq(submit_of("token:a", bed.store, 1, "k", 9, &answer), PEN_SUBMIT_CREATED);
    ck_assert_int_eq(submit_of("token:b", bed.store, 2, "k", 9, &answer), PEN_SUBMIT_CREATED);
    ck_assert_int_eq(submit_of(NULL, bed.store, 3, "k", 8, &answer), PEN_SUBMIT_CREATED);
    ck_assert_int_eq(submit_of("token:a", bed.store, 4, "k", 8, &answer), PEN_SUBMIT_REUSED);
    ck_assert_int_eq(submit_of("token:b", bed.store, 5, "k", 9, &answer), PEN_SUBMIT_REPEATED);
    ck_assert_str_eq((char *)answer.data, "answer 2");
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__key_is_forgotten_when_it_is_old)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_buf answer = {0};
    struct pen_status st;
    submit_with_key(bed.store, 1, "k", 9, &answer);
    store_must(pen_store_purge(bed.store, 3600000, 3600000, &st), &st, "purge");
    ck_assert_int_eq(submit_with_key(bed.store, 2, "k", 9, &answer), PEN_SUBMIT_REPEATED);
    store_must(pen_store_purge(bed.store, -1000, -1000, &st), &st, "purge");
    ck_assert_int_eq(submit_with_key(bed.store, 3, "k", 9, &answer), PEN_SUBMIT_CREATED);
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__key_outlives_its_job)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_buf answer = {0};
    struct pen_status st;
    struct store_job in;
    store_job_init(&in, 1, 1, 1);
    submit_with_key(bed.store, 1, "k", 9, &answer);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    ck_assert_int_eq(submit_with_key(bed.store, 2, "k", 9, &answer), PEN_SUBMIT_REPEATED);
    ck_assert_str_eq((char *)answer.data, "answer 1");
    pen_buf_release(&answer);
    store_bed_close(&bed);
}
END_TEST

/* Lists jobs as a text: the last digit of each id, newest first. */
static void list_as_text(struct pen_store *store, const struct pen_job_filter *filter, char *out,
                         int64_t *last)
{
    struct pen_status st;
    struct pen_job_record *jobs;
    int count;
    store_must(pen_store_jobs(store, filter, &jobs, &count, &st), &st, "list");
    for (int i = 0; i < count; i++) {
        out[i] = jobs[i].id[PEN_ID_BYTES - 2];
        *last = jobs[i].number;
    }
    out[count] = '\0';
    pen_job_records_free(jobs, count);
}

START_TEST(test_jobs__list_is_newest_first_and_continues_below_a_number)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    for (int n = 0; n < 7; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 1);
        store_job_submit(bed.store, &in);
    }
    char text[16];
    int64_t last = 0;
    struct pen_job_filter filter = {.state = -1, .limit = 3};
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "654");
    struct store_job late;
    store_job_init(&late, 9, 1, 1);
    store_job_submit(bed.store, &late);
    filter.below = last;
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "321");
    filter.below = last;
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "0");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__list_filters_by_state_and_kind)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_status st;
    for (int n = 0; n < 6; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 1);
        in.job.kind = n % 2 ? "render" : "effects";
        store_job_submit(bed.store, &in);
        if (n >= 3)
            store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    }
    char text[16];
    int64_t last;
    struct pen_job_filter filter = {.state = PEN_JOB_CANCELLED, .limit = 50};
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "543");
    filter.kind = "effects";
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "4");
    filter.state = -1;
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "420");
    filter.kind = "none";
    list_as_text(bed.store, &filter, text, &last);
    ck_assert_str_eq(text, "");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__cancel_ends_a_job_once_and_leaves_ended_ones)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_status st;
    struct store_job in, done;
    store_job_init(&done, 0, 1, 2);
    store_job_submit(bed.store, &done);
    store_work_off(bed.store, "w");
    store_job_init(&in, 1, 1, 3);
    store_job_submit(bed.store, &in);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel");
    struct pen_job_record first = store_job_get(bed.store, in.id);
    ck_assert_int_eq(first.state, PEN_JOB_CANCELLED);
    ck_assert_int_eq(first.revision, 2);
    ck_assert_int_gt(first.finished_ms, 0);
    store_must(pen_store_cancel(bed.store, in.id, NULL, &st), &st, "cancel again");
    struct pen_job_record again = store_job_get(bed.store, in.id);
    ck_assert_int_eq(again.revision, first.revision);
    ck_assert_int_eq(again.finished_ms, first.finished_ms);
    store_must(pen_store_cancel(bed.store, done.id, NULL, &st), &st, "cancel an ended one");
    ck_assert_int_eq(store_job_state(bed.store, done.id), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 0);
    pen_job_record_release(&first);
    pen_job_record_release(&again);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__delete_needs_an_ended_job_and_leaves_nothing)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_status st;
    struct store_job in;
    store_job_init(&in, 1, 2, 3);
    store_job_submit(bed.store, &in);
    ck_assert(!pen_store_delete(bed.store, in.id, NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert(!pen_store_delete(bed.store, in.id, NULL, NULL, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_work_off(bed.store, "w");
    store_must(pen_store_cache_put(bed.store, in.id, -1, "beauty", "png", "all", 3, &st), &st,
               "contact sheet");
    store_must(pen_store_delete(bed.store, in.id, NULL, NULL, &st), &st, "delete");
    struct pen_job_record job;
    ck_assert(!pen_store_job(bed.store, in.id, &job, &st));
    ck_assert_int_eq(st.code, PEN_GONE);
    store_audit_clean(bed.store); /* its rows are there, but belong to no job that can be seen */
    ck_assert_int_gt(store_purge_slices(bed.store), 0);
    /* The audit at the end would find rows without an owner and unused scenes. */
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__delete_keeps_a_scene_that_another_job_names)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_status st;
    struct store_job one, two;
    store_job_init(&one, 1, 1, 1);
    store_job_init(&two, 9, 1, 1);
    store_job_submit(bed.store, &one);
    store_job_submit(bed.store, &two);
    store_work_off(bed.store, "w");
    store_must(pen_store_delete(bed.store, one.id, NULL, NULL, &st), &st, "delete");
    struct pen_buf scene = {0};
    store_must(pen_store_scene(bed.store, two.id, &scene, &st), &st, "scene");
    ck_assert_str_eq((char *)scene.data, two.scene);
    pen_buf_release(&scene);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__submit_without_batches_for_a_view_stores_nothing)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct pen_status st;
    struct store_job in;
    store_job_init(&in, 1, 2, 1);
    in.job.batch_count = 1;
    enum pen_submit_result result;
    struct pen_buf answer = {0};
    ck_assert(!pen_store_submit(bed.store, &in.job, &result, &answer, &st));
    ck_assert_int_eq(st.code, PEN_INTERNAL);
    struct pen_job_record job;
    ck_assert(!pen_store_job(bed.store, in.id, &job, &st));
    store_job_init(&in, 1, 2, 1);
    store_job_submit(bed.store, &in);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_jobs__names_of_states_go_both_ways)
{
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++) {
        enum pen_job_state state = PEN_JOB_STATE_COUNT;
        ck_assert(pen_job_state_of_name(pen_job_state_name((enum pen_job_state)i), &state));
        ck_assert_int_eq(state, i);
    }
    enum pen_job_state state;
    ck_assert(!pen_job_state_of_name("done", &state));
}
END_TEST

/* The commits listed so far; `left` is how many more to take. */
struct listed {
    struct pen_commit_record commit[16];
    int count, left;
};

static bool note_commit(void *user, const struct pen_commit_record *commit)
{
    struct listed *listed = user;
    listed->commit[listed->count++] = *commit;
    return --listed->left > 0;
}

static struct listed list_commits(struct pen_store *store, const char *id, int64_t after, int most)
{
    struct listed listed = {.left = most};
    struct pen_status st;
    store_must(pen_store_commits(store, id, after, note_commit, &listed, &st), &st, "commits");
    return listed;
}

START_TEST(test_jobs__commits_are_listed_in_their_order_by_revision)
{
    struct store_bed bed = {0};
    store_bed_open(&bed);
    struct store_job in;
    store_job_init(&in, 1, 2, 3);
    store_job_submit(bed.store, &in);
    ck_assert_int_eq(list_commits(bed.store, in.id, 0, 16).count, 0);
    struct pen_claim first = store_claim(bed.store, "w"), second = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &second), PEN_OK);
    struct pen_job_record job = store_job_get(bed.store, in.id);
    int64_t revision = job.revision;
    pen_job_record_release(&job);
    ck_assert_int_eq(store_commit(bed.store, &first), PEN_OK);
    store_work_off(bed.store, "w");

    struct listed all = list_commits(bed.store, in.id, 0, 16);
    ck_assert_int_eq(all.count, 6); /* assemble batches have no pixels */
    ck_assert_int_eq(all.commit[0].revision, revision);
    ck_assert_int_eq(all.commit[0].first_tile, second.first_tile);
    ck_assert_int_eq(all.commit[0].tile_count, second.tile_count);
    ck_assert_int_eq(all.commit[1].first_tile, first.first_tile);
    for (int i = 1; i < all.count; i++)
        ck_assert_int_gt(all.commit[i].revision, all.commit[i - 1].revision);
    ck_assert_int_eq(all.commit[5].view, 1);
    struct listed rest = list_commits(bed.store, in.id, all.commit[3].revision, 16);
    ck_assert_int_eq(rest.count, 2);
    ck_assert_int_eq(rest.commit[0].revision, all.commit[4].revision);
    ck_assert_int_eq(list_commits(bed.store, in.id, 0, 2).count, 2);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store jobs", test_jobs__submitted_job_is_there_as_given, test_jobs__counts_are_by_state,
          test_jobs__unknown_job_is_not_found, test_jobs__scene_is_given_back_byte_for_byte,
          test_jobs__key_gives_the_first_answer_again,
          test_jobs__same_key_of_two_clients_makes_two_jobs,
          test_jobs__key_is_forgotten_when_it_is_old, test_jobs__key_outlives_its_job,
          test_jobs__list_is_newest_first_and_continues_below_a_number,
          test_jobs__list_filters_by_state_and_kind,
          test_jobs__cancel_ends_a_job_once_and_leaves_ended_ones,
          test_jobs__delete_needs_an_ended_job_and_leaves_nothing,
          test_jobs__delete_keeps_a_scene_that_another_job_names,
          test_jobs__submit_without_batches_for_a_view_stores_nothing,
          test_jobs__names_of_states_go_both_ways,
          test_jobs__commits_are_listed_in_their_order_by_revision)

/* SPDX-License-Identifier: MIT */
/* Renders in rounds that are interrupted, between rounds and within them. Another process that
 * continues from the state gets the same picture and the same statistics. */
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "render/adaptive_state.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;
static struct pen_scene *scene;

/* The medley in 20 tiles, the last of each row and column smaller. */
static void set_up(void)
{
    kit_medley(&kit);
    kit.settings.target_error = 0.01;
    kit.settings.tile = 9;
    scene = kit_freeze(&kit);
}

enum { TILES = 20 };

/* A picture, and the state that is left. */
struct picture {
    struct pen_adaptive *adaptive;
    struct pen_render_stats stats;
    float *rgb;
};

static size_t values_of(const struct pen_settings *s)
{
    return 3 * (size_t)s->width * (size_t)s->height;
}

static struct picture picture_new(void)
{
    struct pen_status st;
    struct picture p = {.adaptive = pen_adaptive_new(&kit.settings, &st),
                        .rgb = calloc(values_of(&kit.settings), sizeof *p.rgb)};
    ck_assert(p.adaptive && p.rgb);
    return p;
}

static void picture_free(struct picture *p)
{
    pen_adaptive_free(p->adaptive);
    free(p->stats.tile_ms);
    free(p->rgb);
}

/* How a test pauses. */
struct pausing {
    bool (*pause)(void *user);
    bool end; /* at each pause: keep the state, and end the render */
    int pauses;
    struct random random;
    struct pen_buf kept;
};

static bool always(void *user)
{
    (void)user;
    return true;
}

static bool sometimes(void *user)
{
    struct pausing *p = user;
    return random_below(&p->random, 3) == 0;
}

static bool on_pause(void *user, const struct pen_adaptive *adaptive,
                     const struct pen_render_stats *stats)
{
    struct pausing *p = user;
    p->pauses++;
    if (!p->end)
        return true;
    pen_buf_release(&p->kept);
    pen_adaptive_save(adaptive, stats, "this build", &p->kept);
    ck_assert(!p->kept.failed);
    return false;
}

/* Renders what is left from what is kept, up to an interruption. Returns whether there was none. */
static bool render_on(struct pausing *pausing, int threads, struct picture *p)
{
    struct pen_status st;
    struct pen_render_stats earlier = {0};
    struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
    *p = picture_new();
    const bool loaded = pen_adaptive_load(p->adaptive, pausing->kept.data, pausing->kept.bytes,
                                          "this build", &earlier, p->rgb, &st);
    ck_assert(loaded == (pausing->kept.bytes > 0));
    const struct pen_render_task task = {.scene = scene,
                                         .settings = &kit.settings,
                                         .tile_count = -1,
                                         .rgb = p->rgb,
                                         .earlier = loaded ? &earlier : NULL,
                                         .pause = pausing->pause,
                                         .paused = on_pause,
                                         .pause_user = pausing,
                                         .keep_tile_ms = true};
    const bool ok = pen_render_rounds(pool, &task, p->adaptive, &p->stats, &st);
    ck_assert_msg(ok || st.code == PEN_UNAVAILABLE, "%s", st.msg);
    free(earlier.tile_ms);
    pen_thread_pool_free(pool);
    return ok;
}

/* Renders the picture to its end, with 1 to 3 threads in turn. */
static struct picture render_all(struct pausing *pausing)
{
    struct picture p;
    for (int i = 0; !render_on(pausing, 1 + i % 3, &p); i++)
        picture_free(&p);
    pen_buf_release(&pausing->kept);
    return p;
}

/* All but times. */
static void assert_same(const struct picture *got, const struct picture *want)
{
    const struct pen_adaptive_stats *a = &got->stats.adaptive, *b = &want->stats.adaptive;
    ck_assert_mem_eq(got->rgb, want->rgb, values_of(&kit.settings) * sizeof *got->rgb);
    ck_assert_mem_eq(&got->stats.rays, &want->stats.rays, sizeof got->stats.rays);
    ck_assert_uint_eq(got->stats.tile_count, want->stats.tile_count);
    ck_assert_int_eq(a->rounds, b->rounds);
    for (int i = 0; i < a->rounds; i++) {
        ck_assert_int_eq(a->round[i].level, b->round[i].level);
        ck_assert_int_eq(a->round[i].tiles, b->round[i].tiles);
        ck_assert(a->round[i].pixels == b->round[i].pixels);
        ck_assert(a->round[i].error == b->round[i].error);
        ck_assert(a->round[i].low == b->round[i].low && a->round[i].high == b->round[i].high);
    }
    ck_assert(a->met == b->met && a->capped == b->capped);
    ck_assert(a->samples.mean == b->samples.mean && a->samples.most == b->samples.most);
}

/* Renders with pauses, and compares with a render without any. Returns how many there were. */
static int check_pauses(struct pausing pausing, int *rounds)
{
    struct pausing without = {.pause = NULL};
    struct picture want = render_all(&without), got = render_all(&pausing);
    *rounds = want.stats.adaptive.rounds;
    ck_assert_int_ge(*rounds, 3);
    assert_same(&got, &want);
    picture_free(&got);
    picture_free(&want);
    return pausing.pauses;
}

START_TEST(test_rounds__interrupted_after_each_round_it_gives_the_same_film)
{
    int rounds;
    set_up();
    const int pauses = check_pauses((struct pausing){.end = true}, &rounds);
    ck_assert_int_eq(pauses, rounds - 1);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_rounds__interrupted_after_each_tile_it_gives_the_same_film)
{
    int rounds;
    set_up();
    const int pauses = check_pauses((struct pausing){.pause = always, .end = true}, &rounds);
    ck_assert_int_eq(pauses, rounds * TILES - 1);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_rounds__pauses_anywhere_give_the_same_film)
{
    set_up();
    for (uint64_t seed = 1; seed <= 20; seed++) {
        int rounds;
        const struct pausing pausing = {
            .pause = sometimes, .end = seed % 2, .random = random_begin(seed)};
        ck_assert_int_gt(check_pauses(pausing, &rounds), rounds);
    }
    pen_scene_free(scene);
}
END_TEST

/* What is kept after the first tile of the second round. */
static struct pen_buf state_within_a_round(struct pen_render_stats *stats)
{
    struct pausing pausing = {.pause = always, .end = true};
    struct picture p;
    struct pen_status st;
    for (int i = 0; i <= TILES; i++) {
        ck_assert(!render_on(&pausing, 2, &p));
        picture_free(&p);
    }
    p = picture_new();
    ck_assert(pen_adaptive_load(p.adaptive, pausing.kept.data, pausing.kept.bytes, "this build",
                                stats, p.rgb, &st));
    ck_assert_int_eq(stats->adaptive.rounds, 1);
    ck_assert_int_eq(stats->adaptive.round[1].tiles, 1);
    picture_free(&p);
    return pausing.kept;
}

static bool is_refused(const void *bytes, size_t count, const char *build)
{
    struct picture p = picture_new();
    struct pen_status st;
    const bool ok = pen_adaptive_load(p.adaptive, bytes, count, build, &p.stats, p.rgb, &st);
    ck_assert(ok || st.code == PEN_NOT_FOUND);
    picture_free(&p);
    return !ok;
}

/* Whether a state with these statistics is refused. */
static bool are_refused(const struct picture *p, const struct pen_render_stats *stats)
{
    struct pen_buf kept = {0};
    pen_adaptive_save(p->adaptive, stats, "this build", &kept);
    const bool refused = is_refused(kept.data, kept.bytes, "this build");
    pen_buf_release(&kept);
    return refused;
}

START_TEST(test_rounds__states_of_other_builds_and_pictures_are_refused)
{
    set_up();
    struct pen_render_stats stats;
    struct pen_buf kept = state_within_a_round(&stats);
    for (size_t bytes = 0; bytes < kept.bytes; bytes += bytes < 300 ? 1 : 9973)
        ck_assert(is_refused(kept.data, bytes, "this build"));
    ck_assert(is_refused(kept.data, kept.bytes - 1, "this build"));
    ck_assert(is_refused(kept.data, kept.bytes, "that build"));
    ck_assert(is_refused(kept.data, kept.bytes, ""));
    kit.settings.target_error = 0.02;
    ck_assert(is_refused(kept.data, kept.bytes, "this build"));
    kit.settings.target_error = 0.01;
    kit.settings.width--;
    ck_assert(is_refused(kept.data, kept.bytes, "this build"));
    kit.settings.width++;
    kept.data[0]++;
    ck_assert(is_refused(kept.data, kept.bytes, "this build"));
    kept.data[0]--;
    ck_assert(!is_refused(kept.data, kept.bytes, "this build"));
    free(stats.tile_ms);
    pen_buf_release(&kept);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_rounds__states_with_impossible_rounds_are_refused)
{
    static const struct {
        int rounds, tiles;
        bool refused;
    } cases[] = {
        {1, 0, false}, {1, TILES - 1, false},          {1, TILES, true},         {1, -1, true},
        {-1, 0, true}, {PEN_ROUNDS_MAX - 1, 0, false}, {PEN_ROUNDS_MAX, 0, true}};
    set_up();
    struct pen_render_stats stats;
    struct pen_buf kept = state_within_a_round(&stats);
    pen_buf_release(&kept);
    struct picture p = picture_new();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stats.adaptive.rounds = cases[i].rounds;
        for (int k = 0; k < PEN_ROUNDS_MAX; k++)
            stats.adaptive.round[k].tiles = cases[i].tiles;
        ck_assert_msg(are_refused(&p, &stats) == cases[i].refused, "%d rounds and %d tiles",
                      cases[i].rounds, cases[i].tiles);
    }
    picture_free(&p);
    free(stats.tile_ms);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_rounds__states_with_impossible_times_are_refused)
{
    static const struct {
        double render_ms;
        bool refused;
    } cases[] = {{0, false},       {1e9, false},      {-1, true}, {1e300, true},
                 {INFINITY, true}, {-INFINITY, true}, {NAN, true}};
    set_up();
    struct pen_render_stats stats;
    struct pen_buf kept = state_within_a_round(&stats);
    pen_buf_release(&kept);
    struct picture p = picture_new();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stats.render_ms = cases[i].render_ms;
        ck_assert_msg(are_refused(&p, &stats) == cases[i].refused, "%g ms", cases[i].render_ms);
    }
    picture_free(&p);
    free(stats.tile_ms);
    pen_scene_free(scene);
}
END_TEST

/* Half the error takes 2^(8/5) = 3.03 times the rays. */
START_TEST(test_rounds__share_of_rays_that_are_traced)
{
    struct pen_adaptive_stats a = {.target = 0.01};
    ck_assert(pen_adaptive_share(&a, 10) == 0);
    a.round[0].tiles = 5;
    ck_assert(pen_adaptive_share(&a, 10) == 0);
    a.rounds = 1;
    a.round[0].high = 0.02;
    ck_assert_double_eq_tol(pen_adaptive_share(&a, 10), 0.3299, 1e-4);
    a.round[1].tiles = 8;
    ck_assert_double_eq_tol(pen_adaptive_share(&a, 10), 0.3299 * 1.4, 1e-4);
    a.round[0].high = 0.01;
    ck_assert(pen_adaptive_share(&a, 10) == 0.99);
    a.round[0].high = 0;
    ck_assert(pen_adaptive_share(&a, 10) == 0.99);
    a.rounds = PEN_ROUNDS_MAX;
    a.round[PEN_ROUNDS_MAX - 1].high = 0.02;
    ck_assert_double_eq_tol(pen_adaptive_share(&a, 10), 0.3299, 1e-4);
}
END_TEST

/* Pauses when it is asked for the fifth time, and notes the tiles that are done. */
struct fifth {
    int asked, done;
};

static bool at_the_fifth(void *user)
{
    struct fifth *f = user;
    return ++f->asked == 5;
}

static void note_done(void *user, struct pen_rect rect)
{
    struct fifth *f = user;
    ck_assert_int_eq(rect.y, 0); /* five tiles are a row */
    f->done++;
}

START_TEST(test_rounds__a_pause_finishes_the_tiles_that_are_begun_and_no_more)
{
    set_up();
    kit.settings.target_error = 0;
    float *whole = kit_film(scene, &kit.settings, 1);
    for (int threads = 1; threads <= 3; threads++) {
        struct pen_status st;
        struct fifth f = {0};
        struct pen_render_stats stats;
        struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
        float *rgb = calloc(values_of(&kit.settings), sizeof *rgb);
        const struct pen_render_task task = {.scene = scene,
                                             .settings = &kit.settings,
                                             .tile_count = -1,
                                             .rgb = rgb,
                                             .tile_done = note_done,
                                             .user = &f,
                                             .pause = at_the_fifth,
                                             .pause_user = &f};
        ck_assert_msg(pen_render_run(pool, &task, &stats, &st), "%s", st.msg);
        ck_assert_uint_eq(stats.tile_count, 5);
        ck_assert_int_eq(f.done, 5);
        ck_assert_int_eq(f.asked, 5);
        ck_assert_mem_eq(rgb, whole, sizeof *rgb * 3 * 9 * 40);
        for (size_t i = 3 * 9 * 40; i < values_of(&kit.settings); i++)
            ck_assert(rgb[i] == 0);
        free(rgb);
        pen_thread_pool_free(pool);
    }
    free(whole);
    pen_scene_free(scene);
}
END_TEST

PEN_SUITE("rounds", test_rounds__interrupted_after_each_round_it_gives_the_same_film,
          test_rounds__interrupted_after_each_tile_it_gives_the_same_film,
          test_rounds__pauses_anywhere_give_the_same_film,
          test_rounds__states_of_other_builds_and_pictures_are_refused,
          test_rounds__states_with_impossible_rounds_are_refused,
          test_rounds__states_with_impossible_times_are_refused,
          test_rounds__share_of_rays_that_are_traced,
          test_rounds__a_pause_finishes_the_tiles_that_are_begun_and_no_more)

/* SPDX-License-Identifier: MIT */
/* Generic blocks, for kinds of primitives without a block of their own. Every kind is tried in
 * them; test_same.c compares the intersections. */
#include "accel/internal/structure.h"
#include "accel/internal/test_doors.h"
#include "support/isa.h"
#include "support/suite.h"
#include "support/world.h"

static struct world world;
static struct pen_arena *arena;

static void setup(void)
{
    arena = pen_arena_new(0);
    world_clear(&world);
}

static void teardown(void)
{
    pen_arena_free(arena);
}

static const struct pen_accel *build(enum pen_accelerator kind, unsigned generic_kinds)
{
    struct pen_status st;
    const struct pen_accel *accel =
        pen_accel_build_generic(&world.prims, kind, generic_kinds, arena, &st);
    ck_assert(accel);
    return accel;
}

/* Counts the primitives in generic blocks and in others; the items of all leaves follow each
 * other. */
static void count_items(const struct pen_accel *accel, uint32_t last, uint32_t *generic,
                        uint32_t *others)
{
    uint32_t blocks = 0;
    *generic = *others = 0;
    for (uint32_t i = 0; i <= last; i++) {
        uint32_t item = accel->items[i];
        if (PEN_ITEM_KIND(item) != PEN_BLOCK_GENERIC) {
            *others += PEN_ITEM_KIND(item) != PEN_BLOCK_NOTHING;
            continue;
        }
        ck_assert_uint_eq(PEN_ITEM_INDEX(item), blocks++);
        for (int lane = 0; lane < PEN_LANES; lane++)
            *generic += accel->generic[PEN_ITEM_INDEX(item)].prim[lane] != PEN_NO_PRIM;
    }
}

/* With PEN_ACCEL_NONE: the leaf of nothing, the infinite primitives' list, and that of the
 * others. */
START_TEST(test_generic__holds_the_kinds_that_have_no_block)
{
    struct random r = random_begin(11);
    world_random(&world, &r, 80, .3);
    for (int i = 0; i < 5; i++)
        world_cone(&world, pen_vec3(i, 0, 0), pen_vec3(0, 1, 0), (const double[2]){1, 0}, 1, true);
    for (uint32_t kind = 0; kind < PEN_PRIM_KIND_COUNT; kind++) {
        uint32_t generic, others;
        /* Cones have no block of their own, so they are generic beside the kind chosen. */
        uint32_t cones = kind == PEN_PRIM_CONE ? 0 : world.prims.kind_count[PEN_PRIM_CONE];
        const struct pen_accel *accel = build(PEN_ACCEL_NONE, 1u << kind);
        uint32_t last = accel->list;
        while (!(accel->items[last] & PEN_ITEM_LAST))
            last++;
        count_items(accel, last, &generic, &others);
        ck_assert_uint_gt(world.prims.kind_count[kind], 0);
        ck_assert_uint_eq(generic, world.prims.kind_count[kind] + cones);
        ck_assert_uint_gt(others, 0);
    }
}
END_TEST

/* Builders count a generic primitive as tested alone, so no leaf holds several. */
START_TEST(test_generic__primitives_do_not_share_a_leaf)
{
    for (int i = 0; i < 64; i++)
        world_sphere(&world, pen_vec3(i % 4, i / 4 % 4, i / 16), .25);
    const struct pen_accel_stats *blocks = pen_accel_get_stats(build(PEN_ACCEL_AUTO, 0));
    const struct pen_accel_stats *generic =
        pen_accel_get_stats(build(PEN_ACCEL_AUTO, 1u << PEN_PRIM_SPHERE));
    ck_assert_uint_lt(blocks->leaves, 64);
    ck_assert_uint_eq(generic->leaves, 64);
}
END_TEST

/* The verdict of a packet on each ray, and of `shadow` on the ray alone. */
static void compare_ray(const struct pen_accel *accel, const struct pen_trace_ops *ops,
                        const struct pen_disk_packet *packet, double a, double b, int i,
                        bool blocked, bool fallback)
{
    struct pen_shadow alone = {.tmax = packet->to_point ? 1 : INFINITY,
                               .to_point = packet->to_point,
                               .see_through = packet->see_through,
                               .last_occluder = PEN_NO_PRIM};
    struct pen_shadow together = alone;
    struct pen_ray ray = world_ray(packet->o, pen_disk_packet_direction(packet, a, b));
    bool truth = ops->shadow(accel, &ray, packet->origin, &alone);
    if (!fallback) {
        ck_assert(blocked == truth);
        return;
    }
    ck_assert(ops->disk_ray(accel, packet, &ray, i, &together) == truth);
    if (truth)
        return;
    ck_assert_int_eq(together.count, alone.count);
    for (int k = 0; k < alone.count; k++)
        ck_assert(together.hit[k].t == alone.hit[k].t && together.hit[k].prim == alone.hit[k].prim);
}

/* Compares the rays of a packet, and counts those that take the scalar fallback. */
static int compare_packet(struct random *r, const struct pen_accel *accel, enum pen_isa isa,
                          struct pen_disk_packet *packet)
{
    const struct pen_trace_ops *ops = pen_trace_ops_get(isa);
    double a[PEN_DISK_RAYS], b[PEN_DISK_RAYS];
    uint64_t blocked = 0, fallback = 0;
    packet->last_occluder = PEN_NO_PRIM;
    for (int i = 0; i < PEN_DISK_RAYS; i++) {
        a[i] = random_in(r, -.7, .7);
        b[i] = random_in(r, -.7, .7);
    }
    switch (ops->disk_begin(accel, packet)) {
    case PEN_DISK_ALL_VISIBLE:
        break;
    case PEN_DISK_ALL_OCCLUDED:
        blocked = UINT64_MAX;
        break;
    case PEN_DISK_MIXED:
        blocked = ops->disk_test(packet, a, b, PEN_DISK_RAYS, &fallback);
        break;
    case PEN_DISK_NOT_POSSIBLE:
        return 0;
    }
    for (int i = 0; i < PEN_DISK_RAYS; i++)
        compare_ray(accel, ops, packet, a[i], b[i], i, blocked >> i & 1, fallback >> i & 1);
    return __builtin_popcountll(fallback);
}

START_TEST(test_generic__packets_leave_them_to_the_reference)
{
    struct random r = random_begin(64);
    static struct pen_disk_packet packet;
    static const uint8_t opaque[WORLD_MAX];
    int fallbacks[PEN_PRIM_KIND_COUNT] = {0};
    for (int i = 0; i < random_cases(600); i++) {
        uint32_t kind = (uint32_t)i % PEN_PRIM_KIND_COUNT;
        world_clear(&world);
        world_random(&world, &r, 12, .3);
        const struct pen_accel *accel = build(PEN_ACCEL_AUTO, 1u << kind);
        struct pen_vec3 c = random_vec(&r, 2),
                        across = pen_normalize(pen_cross(c, random_direction(&r)));
        packet.o = random_vec(&r, 2);
        packet.c = c;
        packet.u = pen_scale(across, .1);
        packet.v = pen_scale(pen_normalize(pen_cross(c, across)), .1);
        packet.origin = &pen_origin_none;
        packet.to_point = i & 1;
        packet.see_through = i & 2 ? opaque : NULL;
        for (int isa = 0; isa < isa_count(); isa++)
            fallbacks[kind] += compare_packet(&r, accel, (enum pen_isa)isa, &packet);
    }
    for (int kind = 0; kind < PEN_PRIM_KIND_COUNT; kind++)
        ck_assert_msg(fallbacks[kind] > 0, "kind %d is never left to the reference", kind);
}
END_TEST

/* An item's index has room for so many primitives: more are refused before anything is read. */
START_TEST(test_generic__more_primitives_than_items_can_number)
{
    struct pen_status st;
    const struct pen_prims many = {.count = PEN_ITEM_INDEX_MAX + 1};
    ck_assert(!pen_accel_build(&many, PEN_ACCEL_AUTO, arena, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.msg,
                     "67108864 primitives; an acceleration structure holds at most 67108863");
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("generic");
    TCase *tcase = tcase_create("generic");
    tcase_set_timeout(tcase, 120);
    tcase_add_checked_fixture(tcase, setup, teardown);
    tcase_add_test(tcase, test_generic__holds_the_kinds_that_have_no_block);
    tcase_add_test(tcase, test_generic__primitives_do_not_share_a_leaf);
    tcase_add_test(tcase, test_generic__packets_leave_them_to_the_reference);
    tcase_add_test(tcase, test_generic__more_primitives_than_items_can_number);
    suite_add_tcase(suite, tcase);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}

/* SPDX-License-Identifier: MIT */
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "support/suite.h"

START_TEST(test_clock__durations)
{
    int64_t start = pen_clock_ns(), cpu = pen_clock_cpu_ns();
    while (pen_clock_cpu_ns() - cpu < 5000000)
        continue;
    int64_t passed = pen_clock_ns() - start;
    ck_assert(passed >= 4000000);
    nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
    ck_assert(pen_clock_ns() - start >= passed + 20000000);
}
END_TEST

START_TEST(test_clock__wall_time_is_that_of_the_system)
{
    int64_t ms = pen_clock_wall_ms(), now = (int64_t)time(NULL) * 1000;
    ck_assert(ms > now - 5000 && ms < now + 5000);
}
END_TEST

START_TEST(test_clock__format)
{
    const struct {
        int64_t ms;
        const char *text;
    } rows[] = {{0, "1970-01-01T00:00:00.000Z"},
                {1, "1970-01-01T00:00:00.001Z"},
                {-1, "1969-12-31T23:59:59.999Z"},
                {-1000, "1969-12-31T23:59:59.000Z"},
                {951826154321, "2000-02-29T12:09:14.321Z"},
                {1769860800000, "2026-01-31T12:00:00.000Z"},
                {253402300799999, "9999-12-31T23:59:59.999Z"},
                {INT64_MAX, "9999-12-31T23:59:59.999Z"},
                {-62167219200000, "0000-01-01T00:00:00.000Z"},
                {INT64_MIN, "0000-01-01T00:00:00.000Z"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char out[25];
        pen_clock_format(rows[i].ms, out);
        ck_assert_str_eq(out, rows[i].text);
    }
}
END_TEST

START_TEST(test_clock__all_of_a_time_ends_at_its_end)
{
    const int64_t begins[] = {0, 1, 511, 513, 7654321987654};
    for (size_t i = 0; i < sizeof begins / sizeof begins[0]; i++) {
        const int64_t begun = begins[i];
        ck_assert_int_eq(pen_clock_between(begun, INT64_MAX, 1), INT64_MAX);
        ck_assert_int_eq(pen_clock_between(begun, INT64_MAX, 0), begun);
        ck_assert_int_eq(pen_clock_between(begun, begun + 1000, 0.25), begun + 250);
        ck_assert_int_eq(pen_clock_between(begun, begun, 0.5), begun);
    }
}
END_TEST

START_TEST(test_cpu__instruction_sets_can_be_forced)
{
    unsetenv("PENUMBRA_ISA");
    enum pen_isa best = pen_cpu_isa();
#ifdef __x86_64__
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
    ck_assert_int_eq(pen_cpu_runs(PEN_ISA_AVX2), avx2);
    ck_assert_int_eq(pen_cpu_runs(PEN_ISA_AVX512), avx2 && avx512);
    ck_assert_int_eq(best == PEN_ISA_AVX512,
                     avx2 && avx512 && __builtin_cpu_supports("avx512vbmi2"));
#endif
    ck_assert(pen_cpu_runs(PEN_ISA_BASE) && pen_cpu_runs(best));
    static const char *const name[] = {"base", "avx2", "avx512"};
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        ck_assert_str_eq(pen_isa_name((enum pen_isa)isa), name[isa]);
        setenv("PENUMBRA_ISA", name[isa], 1);
        int last = isa;
        while (!pen_cpu_runs((enum pen_isa)last))
            last--;
        ck_assert_int_eq(pen_cpu_isa(), last);
    }
    unsetenv("PENUMBRA_ISA");
}
END_TEST

START_TEST(test_cpu__count_follows_the_affinity)
{
    int all = pen_cpu_count();
    ck_assert_int_ge(all, 1);
    cpu_set_t set, one;
    ck_assert_int_eq(sched_getaffinity(0, sizeof set, &set), 0);
    CPU_ZERO(&one);
    for (size_t i = 0; CPU_COUNT(&one) == 0; i++) {
        if (CPU_ISSET(i, &set))
            CPU_SET(i, &one);
    }
    ck_assert_int_eq(sched_setaffinity(0, sizeof one, &one), 0);
    ck_assert_int_eq(pen_cpu_count(), 1);
}
END_TEST

START_TEST(test_cpu__model_fits)
{
    char model[256], small[5] = "zzzz", none = 'n';
    pen_cpu_model(model, sizeof model);
    ck_assert_uint_gt(strlen(model), 0);
    ck_assert_ptr_null(strchr(model, '\n'));
    pen_cpu_model(small, sizeof small);
    ck_assert(strlen(small) <= 4 && strncmp(small, model, strlen(small)) == 0);
    pen_cpu_model(&none, 0);
    ck_assert_int_eq(none, 'n');
}
END_TEST

PEN_SUITE("system", test_clock__durations, test_clock__wall_time_is_that_of_the_system,
          test_clock__format, test_clock__all_of_a_time_ends_at_its_end,
          test_cpu__instruction_sets_can_be_forced, test_cpu__count_follows_the_affinity,
          test_cpu__model_fits)

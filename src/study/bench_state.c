/* SPDX-License-Identifier: MIT */
/* A benchmark's state as JSON, so that another process goes on where this one ended: the times of
 * all runs, and how far the present pass is. The orders of passes follow from the seed. Only a
 * process of the same host and build goes on, so no report mixes the times of two. */
#include "study/internal/bench_state.h"

#include "base/clock.h"
#include "io/json_build.h"
#include "study/internal/kept_state.h"

enum { VERSION = 2, TIMES = 7 };

static const struct pen_bench_times *times_of(const struct pen_bench_state *s, int slot)
{
    const bool twin = slot == s->bench->row_count;
    return twin ? s->result->twin.runs : s->result->rows[slot].runs;
}

/* Whether a repeat is begun and not whole. */
static bool is_within_repeat(int passes, int warmup, int place)
{
    return place > 0 && passes >= warmup;
}

/* How many runs each slot has: those of whole repeats, and of the one that is begun. */
static int run_count(const struct pen_bench_state *s)
{
    return s->result->repeats + is_within_repeat(s->passes, s->bench->warmup, s->place);
}

static json_t *slot_json(const struct pen_bench_state *s, int slot)
{
    const struct pen_bench_times *runs = times_of(s, slot);
    const int count = run_count(s);
    json_t *list = json_array();
    for (int i = 0; i < count; i++) {
        const double times[TIMES] = {runs[i].build_ms, runs[i].render_ms, runs[i].cpu_ms,
                                     runs[i].used,     runs[i].steal_ms,  runs[i].spoiled,
                                     runs[i].in_a_row};
        for (int t = 0; t < TIMES; t++)
            json_array_append_new(list, json_real(times[t]));
    }
    return pen_json_all(list, (size_t)count * TIMES);
}

static json_t *runs_json(const struct pen_bench_state *s)
{
    json_t *list = json_array();
    for (int slot = 0; slot < s->slots; slot++)
        json_array_append_new(list, slot_json(s, slot));
    return pen_json_all(list, (size_t)s->slots);
}

static json_t *rows_json(const struct pen_bench_state *s)
{
    json_t *list = json_array();
    for (int row = 0; row < s->bench->row_count; row++)
        json_array_append_new(list,
                              json_pack("{s:i, s:o}", "threads", s->result->rows[row].stats.threads,
                                        "hash", pen_kept_hash(s->hash[row])));
    return pen_json_all(list, (size_t)s->bench->row_count);
}

json_t *pen_bench_state_json(const struct pen_bench_state *s)
{
    const struct pen_bench_result *result = s->result;
    return json_pack(
        "{s:i, s:O, s:i, s:I, s:i, s:i, s:i, s:i, s:i, s:f, s:I, s:f, s:i, s:o, s:o, "
        "s:o}",
        "version", VERSION, "host", s->host, "pool_threads", pen_thread_pool_size(s->bench->pool),
        "order_seed", (json_int_t)s->bench->order_seed, "warmup", s->bench->warmup, "slots",
        s->slots, "passes", s->passes, "place", s->place, "repeats", result->repeats, "elapsed_ms",
        (double)(pen_clock_ns() - s->begun_ns) * 1e-6, "began_ms", (json_int_t)result->began_ms,
        "load_before", result->load_before, "breaks", result->breaks, "calibration",
        pen_kept_numbers(result->calibration_ms, run_count(s)), "runs", runs_json(s), "rows",
        rows_json(s));
}

int pen_bench_state_done(const struct pen_bench_state *state)
{
    return state->done;
}

static bool is_same_benchmark(const struct pen_bench_state *s, const json_t *kept)
{
    const json_int_t seed = json_integer_value(json_object_get(kept, "order_seed"));
    return pen_kept_whole(kept, "version", VERSION) == VERSION &&
           pen_kept_whole(kept, "warmup", s->bench->warmup) == s->bench->warmup &&
           pen_kept_whole(kept, "slots", s->slots) == s->slots &&
           seed == (json_int_t)s->bench->order_seed;
}

/* How far a kept benchmark is. */
struct counts {
    int passes, place, repeats, runs; /* runs: of each slot */
};

/* Reads the counts. Returns false if they do not fit each other. */
static bool read_counts(const struct pen_bench_state *s, const json_t *kept, struct counts *out)
{
    const int warmup = s->bench->warmup;
    *out = (struct counts){.passes = pen_kept_whole(kept, "passes", warmup + s->repeats_max),
                           .place = pen_kept_whole(kept, "place", s->slots - 1),
                           .repeats = pen_kept_whole(kept, "repeats", s->repeats_max)};
    out->runs = out->repeats + is_within_repeat(out->passes, warmup, out->place);
    const int past = out->passes > warmup ? out->passes - warmup : 0;
    return out->passes >= 0 && out->place >= 0 && out->repeats == past &&
           out->runs <= s->repeats_max;
}

static bool has_lists(const struct pen_bench_state *s, const json_t *kept, int runs)
{
    const json_t *slots = json_object_get(kept, "runs"), *rows = json_object_get(kept, "rows");
    bool ok = json_array_size(slots) == (size_t)s->slots &&
              json_array_size(rows) == (size_t)s->bench->row_count &&
              pen_kept_is_numbers(json_object_get(kept, "calibration"), runs, false);
    for (int slot = 0; ok && slot < s->slots; slot++)
        ok = pen_kept_is_numbers(json_array_get(slots, (size_t)slot), runs * TIMES, false);
    return ok;
}

static void read_slot(struct pen_bench_state *s, int slot, const json_t *list, int count)
{
    struct pen_bench_row_result *row =
        slot == s->bench->row_count ? &s->result->twin : &s->result->rows[slot];
    for (int i = 0; i < count; i++) {
        double times[TIMES];
        for (int t = 0; t < TIMES; t++)
            times[t] = json_number_value(json_array_get(list, (size_t)(i * TIMES + t)));
        row->runs[i] = (struct pen_bench_times){
            .build_ms = times[0],
            .render_ms = times[1],
            .cpu_ms = times[2],
            .used = times[3],
            .steal_ms = times[4],
            .spoiled = times[5] != 0,
            .in_a_row = times[6] >= 1 && times[6] < 1e6 ? (int)times[6] : 1};
    }
}

static void read_rows(struct pen_bench_state *s, const json_t *rows)
{
    for (int row = 0; row < s->bench->row_count; row++) {
        const json_t *kept = json_array_get(rows, (size_t)row);
        const int threads = pen_kept_whole(kept, "threads", pen_thread_pool_size(s->bench->pool));
        pen_kept_read_hash(json_object_get(kept, "hash"), &s->hash[row]);
        s->result->rows[row].stats.threads = threads > 0 ? threads : 0;
    }
}

bool pen_bench_state_read(struct pen_bench_state *s, const json_t *kept)
{
    struct counts counts;
    struct pen_bench_result *result = s->result;
    const double elapsed_ms = json_number_value(json_object_get(kept, "elapsed_ms"));
    if (!is_same_benchmark(s, kept) || !pen_kept_is_of_host(kept, s->host, s->bench->pool) ||
        !read_counts(s, kept, &counts) || !has_lists(s, kept, counts.runs) ||
        !(elapsed_ms >= 0 && elapsed_ms < 1e12))
        return false;
    s->passes = counts.passes;
    s->place = counts.place;
    s->done = counts.passes * s->slots + counts.place;
    s->begun_ns -= (int64_t)(elapsed_ms * 1e6);
    result->repeats = counts.repeats;
    result->began_ms = json_integer_value(json_object_get(kept, "began_ms"));
    result->load_before = json_number_value(json_object_get(kept, "load_before"));
    result->breaks = pen_kept_whole(kept, "breaks", 1 << 30) + 1;
    for (int i = 0; i < counts.runs; i++)
        result->calibration_ms[i] =
            json_number_value(json_array_get(json_object_get(kept, "calibration"), (size_t)i));
    for (int slot = 0; slot < s->slots; slot++)
        read_slot(s, slot, json_array_get(json_object_get(kept, "runs"), (size_t)slot),
                  counts.runs);
    read_rows(s, json_object_get(kept, "rows"));
    return true;
}

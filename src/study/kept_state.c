/* SPDX-License-Identifier: MIT */
#include "study/internal/kept_state.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/json_build.h"

enum { RAYS = 7, HASH_DIGITS = 16 };

int pen_kept_whole(const json_t *state, const char *key, int most)
{
    const json_t *value = json_object_get(state, key);
    const json_int_t number = json_integer_value(value);
    return json_is_integer(value) && number >= 0 && number <= most ? (int)number : -1;
}

bool pen_kept_is_of_host(const json_t *state, const json_t *host,
                         const struct pen_thread_pool *pool)
{
    const int threads = pen_thread_pool_size(pool);
    return json_equal(json_object_get(state, "host"), host) &&
           pen_kept_whole(state, "pool_threads", threads) == threads;
}

json_t *pen_kept_numbers(const double *values, int count)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(list, isfinite(values[i]) ? json_real(values[i]) : json_null());
    return pen_json_all(list, (size_t)count);
}

bool pen_kept_is_numbers(const json_t *list, int count, bool null_allowed)
{
    size_t i;
    json_t *value;
    json_array_foreach(list, i, value)
    {
        if (!json_is_number(value) && !(null_allowed && json_is_null(value)))
            return false;
    }
    return json_is_array(list) && json_array_size(list) == (size_t)count;
}

double pen_kept_number(const json_t *list, int index)
{
    const json_t *value = json_array_get(list, (size_t)index);
    return json_is_number(value) ? json_number_value(value) : HUGE_VAL;
}

json_t *pen_kept_hash(uint64_t hash)
{
    return json_sprintf("%016" PRIx64, hash);
}

bool pen_kept_read_hash(const json_t *text, uint64_t *hash)
{
    const char *digits = json_string_value(text);
    char *end;
    if (!digits || strlen(digits) != HASH_DIGITS)
        return false;
    *hash = strtoull(digits, &end, 16);
    return *end == '\0';
}

json_t *pen_kept_rays(const struct pen_ray_counts *r)
{
    return json_pack("[I, I, I, I, I, I, I]", (json_int_t)r->primary, (json_int_t)r->shadow,
                     (json_int_t)r->reflection, (json_int_t)r->transmission,
                     (json_int_t)r->dropped_samples, (json_int_t)r->unmatched_exits,
                     (json_int_t)r->truncated_paths);
}

bool pen_kept_read_rays(const json_t *list, struct pen_ray_counts *r)
{
    uint64_t counts[RAYS];
    for (size_t i = 0; i < RAYS; i++) {
        const json_t *value = json_array_get(list, i);
        if (!json_is_integer(value) || json_integer_value(value) < 0)
            return false;
        counts[i] = (uint64_t)json_integer_value(value);
    }
    *r = (struct pen_ray_counts){counts[0], counts[1], counts[2], counts[3],
                                 counts[4], counts[5], counts[6]};
    return json_array_size(list) == RAYS;
}

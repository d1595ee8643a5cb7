/* SPDX-License-Identifier: MIT */
/* What the states that studies keep have in common, and how their members are read: a state may be
 * of another build, or damaged, and is then not used. */
#ifndef PEN_STUDY_INTERNAL_KEPT_STATE_H
#define PEN_STUDY_INTERNAL_KEPT_STATE_H

#include "base/thread_pool.h"
#include "shade/kernel.h"
#include "study/unfinished.h"

/* A whole number from 0 to `most`; -1 if there is none. */
int pen_kept_whole(const json_t *state, const char *key, int most);

/* Whether it was kept on this host, by this build, with as many threads: `host` is
 * pen_host_json(). */
bool pen_kept_is_of_host(const json_t *state, const json_t *host,
                         const struct pen_thread_pool *pool);

/* A list of numbers, null for one that is not finite. Fails: NULL when out of memory. */
json_t *pen_kept_numbers(const double *values, int count);

/* Whether a list has so many values, and each is a number or, where allowed, null. */
bool pen_kept_is_numbers(const json_t *list, int count, bool null_allowed);

/* A value of such a list; HUGE_VAL for null. */
double pen_kept_number(const json_t *list, int index);

/* A hash in 16 hexadecimal digits. Reading returns false if it is none. */
json_t *pen_kept_hash(uint64_t hash);
bool pen_kept_read_hash(const json_t *text, uint64_t *hash);

/* Counts of rays, as a list. Reading returns false if it is none. */
json_t *pen_kept_rays(const struct pen_ray_counts *rays);
bool pen_kept_read_rays(const json_t *list, struct pen_ray_counts *rays);

#endif

/* SPDX-License-Identifier: MIT */
/* Reading the members of a submission: words, numbers, lists of settings. All errors are collected,
 * each with its place, a JSON Pointer (RFC 6901). `members` is the object at `up`. A member that is
 * not there is no error, and leaves *out as it is. Fail: errors->count grows. */
#ifndef PEN_JOBS_INTERNAL_MEMBERS_H
#define PEN_JOBS_INTERNAL_MEMBERS_H

#include <float.h>
#include <jansson.h>
#include <stdbool.h>

#include "base/status.h"
#include "io/scene_json.h"

/* Adds an error at up/key, or at `up` if key is NULL. The key is escaped. */
void pen_request_fail(struct pen_errors *errors, enum pen_code code, const char *up,
                      const char *key, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* Parts of messages: a value that was found; "; did you mean "x"?", or nothing for NULL; "a, b, c"
 * of names, which end with NULL; and the key of entry i of a list. */
struct pen_found {
    char text[256];
};
struct pen_found pen_found(const json_t *value);
struct pen_found pen_did_you_mean(const char *name);
struct pen_found pen_names(const char *const *names);
struct pen_found pen_position(size_t i);

/* The index of a word in names[], which ends with NULL; -1: it is not there, or no word. */
int pen_name_index(const char *word, const char *const *names);

bool pen_boolean_read(const json_t *members, const char *key, bool *out, struct pen_errors *errors);

/* An integer from lo to hi; a number such as 3.0 counts as one. */
bool pen_integer_read(const json_t *members, const char *up, const char *key, int lo, int hi,
                      int *out, struct pen_errors *errors);

/* A number from `least` to `most`, which `range` tells in words. */
#define PEN_ABOVE_0 DBL_TRUE_MIN
bool pen_number_read(const json_t *members, const char *up, const char *key, double least,
                     double most, const char *range, double *out, struct pen_errors *errors);

/* The index of a value in names[]; -1 after an error, which suggests the most similar name. */
int pen_word_read(const json_t *value, const char *up, const char *key, const char *const *names,
                  struct pen_errors *errors);

/* Whether the object has no other keys than these. */
bool pen_keys_check(const json_t *object, const char *up, const char *const *names,
                    struct pen_errors *errors);

/* Checks an object of render settings, each with a list of values, such as
 * {"light_samples": [1, 4]}: the member `name` of a job. */
bool pen_setting_lists_check(const json_t *lists, const char *name, struct pen_errors *errors);

/* Whether two values are equal, numbers whatever their type; and whether a list has a value. */
bool pen_value_equal(const json_t *a, const json_t *b);
bool pen_setting_listed(const json_t *list, const json_t *value);

/* The number of combinations of the lists' values, and combination `number`, from 0 on, as an
 * object: the last key changes fastest. Owns: the caller. Fails: NULL when out of memory. */
double pen_setting_lists_product(const json_t *lists);
json_t *pen_setting_lists_combination(const json_t *lists, int number);

/* json_member.c: the text of member `key` of an object, which must be well-formed JSON: a part of a
 * document can then be stored as it was sent, without writing it again. *length becomes its length.
 * NULL if the object has no such member, or if its key is written with escapes. Owns: the result
 * points into `text`. */
const char *pen_json_member(const char *text, size_t bytes, const char *key, size_t *length);

#endif

/* SPDX-License-Identifier: MIT */
/* Reads the members of a submission: words, numbers, lists of settings. All errors are collected,
 * each with its place, a JSON Pointer (RFC 6901). `members` is the object at the pointer `up`. A
 * missing member is no error, and leaves *out as it is.
 * Fails: errors->count grows. */
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

/* Parts of messages. pen_found: a value that was found. pen_did_you_mean: "; did you mean "x"?", or
 * nothing for NULL. pen_names: "a, b, c" of names, which end with NULL. pen_position: the key of
 * entry i of a list. */
struct pen_found {
    char text[256];
};
struct pen_found pen_found(const json_t *value);
struct pen_found pen_did_you_mean(const char *name);
struct pen_found pen_names(const char *const *names);
struct pen_found pen_position(size_t i);

/* Returns the index of a word in names[], which ends with NULL; -1 if `word` is NULL or not
 * there. */
int pen_name_index(const char *word, const char *const *names);

bool pen_boolean_read(const json_t *members, const char *key, bool *out, struct pen_errors *errors);

/* Reads an integer from lo to hi; a number such as 3.0 counts as an integer. */
bool pen_integer_read(const json_t *members, const char *up, const char *key, int lo, int hi,
                      int *out, struct pen_errors *errors);

/* Reads a number from `least` to `most`; `range` is this range in words. */
#define PEN_ABOVE_0 DBL_TRUE_MIN
bool pen_number_read(const json_t *members, const char *up, const char *key, double least,
                     double most, const char *range, double *out, struct pen_errors *errors);

/* Returns the index of a value in names[]; -1 after an error, which suggests the most similar
 * name. */
int pen_word_read(const json_t *value, const char *up, const char *key, const char *const *names,
                  struct pen_errors *errors);

/* Returns true if the object has no keys but these. */
bool pen_keys_check(const json_t *object, const char *up, const char *const *names,
                    struct pen_errors *errors);

/* Checks an object of render settings, each with a list of values, such as {"light_samples": [1,
 * 4]}. It is the member `name` of a job. */
bool pen_setting_lists_check(const json_t *lists, const char *name, struct pen_errors *errors);

/* Compare values: pen_value_equal compares numbers by value, of any type; pen_setting_listed looks
 * for a value in a list. */
bool pen_value_equal(const json_t *a, const json_t *b);
bool pen_setting_listed(const json_t *list, const json_t *value);

/* Return the number of combinations of the lists' values, and combination `number`, counted from 0,
 * as an object. The last key changes fastest.
 * Owns: the caller.
 * Fails: NULL when out of memory. */
double pen_setting_lists_product(const json_t *lists);
json_t *pen_setting_lists_combination(const json_t *lists, int number);

/* json_member.c: finds the text of member `key` of an object, which must be well-formed JSON. So a
 * part of a document can be stored as it was sent, without writing it again. *length becomes its
 * length. NULL if the object has no such member, or if its key is written with escapes.
 * Owns: the result points into `text`. */
const char *pen_json_member(const char *text, size_t bytes, const char *key, size_t *length);

#endif

/* SPDX-License-Identifier: MIT */
/* The table of a job's keys: the function that reads each key, and the kinds of jobs to which the
 * key belongs. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "io/settings_json.h"
#include "jobs/internal/request.h"
#include "jobs/internal/request_errors.h"
#include "render/audit.h"
#include "render/layers.h"

/* Sets of kinds, one bit each. */
enum {
    RENDER = 1 << PEN_KIND_RENDER,
    BENCHMARK = 1 << PEN_KIND_BENCHMARK,
    ACCURACY = 1 << PEN_KIND_ACCURACY,
    EFFECTS = 1 << PEN_KIND_EFFECTS,
    EXPLAIN = 1 << PEN_KIND_EXPLAIN,
    SUBMITTED = RENDER | BENCHMARK | ACCURACY | EFFECTS /* those that a job may name */
};

enum { POSITION_BYTES = 24 };

typedef void key_fn(struct pen_request *request, const json_t *value, struct pen_errors *errors);

/* Reads an integer; a number such as 3.0 counts as one. */
static bool read_integer(const json_t *value, const char *up, const char *key, int lo, int hi,
                         int *out, struct pen_errors *errors)
{
    double number = json_number_value(value);
    if (!json_is_number(value) || number != floor(number) || number < lo || number > hi) {
        pen_request_fail(errors, PEN_INVALID, up, key, "must be an integer from %d to %d, found %s",
                         lo, hi, pen_found(value).text);
        return false;
    }
    *out = (int)number;
    return true;
}

/* Reads a word that must be one of names[], which ends with NULL. Returns that name, or NULL after
 * an error, which suggests the most similar name. */
static const char *read_word(const json_t *value, const char *up, const char *key,
                             const char *const *names, struct pen_errors *errors)
{
    const char *word = json_string_value(value);
    for (int i = 0; word && names[i]; i++) {
        if (strcmp(word, names[i]) == 0)
            return names[i];
    }
    const char *near = word ? pen_nearest_name(word, names) : NULL;
    char list[160] = "";
    for (int i = 0; names[i]; i++) {
        strcat(list, i ? ", " : "");
        strcat(list, names[i]);
    }
    pen_request_fail(errors, PEN_INVALID, up, key, "must be one of %s, found %s%s%s%s", list,
                     pen_found(value).text, near ? "; did you mean \"" : "", near ? near : "",
                     near ? "\"?" : "");
    return NULL;
}

/* The kinds of a set in words: "benchmark" or "effects". */
static void name_kinds(unsigned kinds, char *out, size_t bytes)
{
    size_t used = 0;
    for (int i = 0; i < PEN_KIND_COUNT && used < bytes; i++)
        if (kinds >> i & 1)
            used += (size_t)snprintf(out + used, bytes - used, "%s\"%s\"", used ? " or " : "",
                                     pen_job_kinds[i]);
}

/* The names of a set of kinds, with NULL at the end. */
static void list_kinds(unsigned kinds, const char *names[PEN_KIND_COUNT + 1])
{
    int count = 0;
    for (int i = 0; i < PEN_KIND_COUNT; i++)
        if (kinds >> i & 1)
            names[count++] = pen_job_kinds[i];
    names[count] = NULL;
}

static void read_kind(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    static const char *const explained[] = {"render", "explain", NULL};
    const char *submitted[PEN_KIND_COUNT + 1];
    const char *word = json_string_value(value);
    char kinds[80];
    enum pen_job_kind kind;
    list_kinds(SUBMITTED, submitted);
    name_kinds(SUBMITTED, kinds, sizeof kinds);
    if (request->explain)
        read_word(value, "", "kind", explained, errors);
    else if (word && strcmp(word, pen_job_kinds[PEN_KIND_EXPLAIN]) == 0)
        pen_request_fail(errors, PEN_INVALID, "", "kind",
                         "POST /v1/explain makes jobs of kind \"explain\"; here take %s", kinds);
    else if (pen_job_kind_of_name(read_word(value, "", "kind", submitted, errors), &kind))
        request->kind = kind;
}

static void read_analyze(struct pen_request *request, const json_t *value,
                         struct pen_errors *errors)
{
    if (!json_is_boolean(value))
        pen_request_fail(errors, PEN_INVALID, "", "analyze", "must be true or false, found %s",
                         pen_found(value).text);
    request->analyze = json_is_true(value);
}

/* The length of a string. The strings of a body hold no zero byte. */
static size_t characters(const json_t *string)
{
    return pen_utf8_count(json_string_value(string));
}

static void read_name(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    if (!json_is_string(value))
        pen_request_fail(errors, PEN_INVALID, "", "name",
                         "must be a string of at most %d characters, found %s",
                         (int)PEN_JOB_NAME_CHARACTERS, pen_found(value).text);
    else if (characters(value) > PEN_JOB_NAME_CHARACTERS)
        pen_request_fail(errors, PEN_INVALID, "", "name",
                         "must be a string of at most %d characters, found one of %zu",
                         (int)PEN_JOB_NAME_CHARACTERS, characters(value));
    request->name = value;
}

/* A list selects a label by "key:value", so a key is not empty and has no colon. */
static void read_label(const char *key, const json_t *label, struct pen_errors *errors)
{
    if (!key[0] || strchr(key, ':'))
        pen_request_fail(errors, PEN_INVALID, "/labels", key,
                         "must have a key of 1 to %d characters without a colon, which lists take "
                         "for its end, found \"%.60s\"",
                         (int)PEN_JOB_NAME_CHARACTERS, key);
    else if (!json_is_string(label))
        pen_request_fail(errors, PEN_INVALID, "/labels", key, "must be a string, found %s",
                         pen_found(label).text);
    else if (characters(label) > PEN_JOB_NAME_CHARACTERS ||
             pen_utf8_count(key) > PEN_JOB_NAME_CHARACTERS)
        pen_request_fail(errors, PEN_INVALID, "/labels", key,
                         "must have at most %d characters, and its key too; found %zu and %zu",
                         (int)PEN_JOB_NAME_CHARACTERS, characters(label), pen_utf8_count(key));
}

static void read_labels(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    if (!json_is_object(value)) {
        pen_request_fail(errors, PEN_INVALID, "", "labels",
                         "must be an object of at most %d strings, found %s", (int)PEN_JOB_LABELS,
                         pen_found(value).text);
        return;
    }
    if (json_object_size(value) > PEN_JOB_LABELS) {
        pen_request_fail(errors, PEN_INVALID, "", "labels",
                         "must be an object of at most %d strings, found one of %zu",
                         (int)PEN_JOB_LABELS, json_object_size(value));
        return;
    }
    const char *key;
    json_t *label;
    json_object_foreach((json_t *)(uintptr_t)value, key, label)
    {
        read_label(key, label, errors);
    }
    request->labels = value;
}

/* The length of a value as JSON text; 0 without one. */
static size_t text_bytes(const json_t *value)
{
    return value ? json_dumpb(value, NULL, 0, JSON_COMPACT | JSON_ENCODE_ANY) : 0;
}

/* Every reader of the job gets its texts again, and lists get those of many jobs. A name alone is
 * never too long. */
static void bound_texts(const struct pen_request *request, struct pen_errors *errors)
{
    const size_t bytes = text_bytes(request->name) + text_bytes(request->labels);
    if (bytes > PEN_JOB_TEXT_BYTES)
        pen_request_fail(errors, PEN_INVALID, "", "labels",
                         "must have at most %d bytes as JSON text, together with the job's name; "
                         "found %zu",
                         (int)PEN_JOB_TEXT_BYTES, bytes);
}

static void read_layer(const json_t *list, size_t i, struct pen_errors *errors)
{
    char position[POSITION_BYTES];
    snprintf(position, sizeof position, "%zu", i);
    const char *layer =
        read_word(json_array_get(list, i), "/layers", position, pen_layer_names, errors);
    for (size_t k = 0; layer && k < i; k++) {
        if (json_equal(json_array_get(list, k), json_array_get(list, i)))
            pen_request_fail(errors, PEN_INVALID, "/layers", position, "%s is there twice",
                             pen_found(json_array_get(list, i)).text);
    }
}

static void read_layers(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    size_t count = json_array_size(value);
    if (count < 1 || count > PEN_LAYER_COUNT)
        pen_request_fail(errors, PEN_INVALID, "", "layers",
                         "must be an array of 1 to %d names of layers, found %s",
                         (int)PEN_LAYER_COUNT, pen_found(value).text);
    for (size_t i = 0; i < count && count <= PEN_LAYER_COUNT; i++)
        read_layer(value, i, errors);
    request->layers = errors->count == 0 ? value : NULL;
}

static void read_cost(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    request->cost = read_word(value, "", "cost", pen_cost_names, errors);
}

static void read_threshold(struct pen_request *request, const json_t *value,
                           struct pen_errors *errors)
{
    const double threshold = json_number_value(value);
    if (!json_is_number(value) || !(threshold > 0) || threshold >= 1)
        pen_request_fail(errors, PEN_INVALID, "/audit", "threshold",
                         "must be a number above 0 and below 1, found %s", pen_found(value).text);
    else
        request->audit_threshold = threshold;
}

static void read_audit(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    const char *key;
    json_t *member;
    request->audit_pixels = PEN_AUDIT_PIXELS;
    request->audit_threshold = PEN_AUDIT_THRESHOLD;
    if (!json_is_object(value)) {
        pen_request_fail(errors, PEN_INVALID, "", "audit",
                         "must be an object of pixels and threshold, found %s",
                         pen_found(value).text);
        return;
    }
    json_object_foreach((json_t *)(uintptr_t)value, key, member)
    {
        if (strcmp(key, "pixels") == 0)
            read_integer(member, "/audit", key, 1, PEN_AUDIT_PIXELS_MAX, &request->audit_pixels,
                         errors);
        else if (strcmp(key, "threshold") == 0)
            read_threshold(request, member, errors);
        else
            pen_request_fail(errors, PEN_INVALID, "/audit", key,
                             "unknown key; the keys here are pixels, threshold");
    }
}

void pen_request_budget_read(struct pen_request *request, struct pen_errors *errors)
{
    const json_t *value = json_object_get(request->body, "budget_seconds");
    if (!value)
        return;
    const double seconds = json_number_value(value);
    if (!json_is_number(value) || !(seconds > 0) || seconds > PEN_BUDGET_SECONDS_MAX)
        pen_request_fail(errors, PEN_INVALID, "", "budget_seconds",
                         "must be a number above 0, at most %d, found %s",
                         (int)PEN_BUDGET_SECONDS_MAX, pen_found(value).text);
    else
        request->budget_seconds = seconds;
}

static void read_priority(struct pen_request *request, const json_t *value,
                          struct pen_errors *errors)
{
    const bool lowered = request->priority_max < 100 && json_is_number(value);
    if (lowered && json_number_value(value) > request->priority_max)
        pen_request_fail(errors, PEN_INVALID, "", "priority",
                         "must be an integer, at least -100, at most %d, which this daemon allows, "
                         "found %s",
                         request->priority_max, pen_found(value).text);
    else
        read_integer(value, "", "priority", -100, 100, &request->priority, errors);
}

static void read_max_attempts(struct pen_request *request, const json_t *value,
                              struct pen_errors *errors)
{
    read_integer(value, "", "max_attempts", 1, 10, &request->max_attempts, errors);
}

static void read_timeout(struct pen_request *request, const json_t *value,
                         struct pen_errors *errors)
{
    double seconds = json_number_value(value);
    if (!json_is_number(value) || !(seconds > 0) || seconds > request->timeout_max_s)
        pen_request_fail(errors, PEN_INVALID, "", "timeout_seconds",
                         "must be a number above 0, at most %d, which this daemon allows, found %s",
                         request->timeout_max_s, pen_found(value).text);
    else
        request->timeout_ms = (int64_t)ceil(seconds * 1000);
}

static const struct {
    const char *key;
    key_fn *read;   /* NULL: request.c or bench_spec.c reads the key */
    unsigned kinds; /* the kinds of jobs that may have the key; 0: all */
} keys[] = {
    {.key = "scene"},
    {.key = "kind", .read = read_kind},
    {.key = "render"},
    {.key = "views"},
    {.key = "priority", .read = read_priority},
    {.key = "name", .read = read_name},
    {.key = "labels", .read = read_labels},
    {.key = "layers", .read = read_layers, .kinds = RENDER | BENCHMARK | ACCURACY | EFFECTS},
    {.key = "cost", .read = read_cost, .kinds = RENDER},
    {.key = "audit", .read = read_audit, .kinds = RENDER},
    {.key = "max_attempts", .read = read_max_attempts},
    {.key = "timeout_seconds", .read = read_timeout},
    {.key = "matrix", .kinds = BENCHMARK},
    {.key = "repeats", .kinds = BENCHMARK | EFFECTS},
    {.key = "warmup", .kinds = BENCHMARK},
    {.key = "baseline", .kinds = BENCHMARK},
    {.key = "interval", .kinds = BENCHMARK},
    {.key = "least_effect", .kinds = BENCHMARK},
    {.key = "order_seed", .kinds = BENCHMARK},
    {.key = "analyze", .read = read_analyze, .kinds = EXPLAIN},
    {.key = "ladder", .kinds = ACCURACY},
    {.key = "product", .kinds = ACCURACY},
    {.key = "reference", .kinds = ACCURACY},
    {.key = "target", .kinds = ACCURACY},
    {.key = "seeds", .kinds = ACCURACY},
    {.key = "budget_seconds", .kinds = RENDER | BENCHMARK | ACCURACY},
};
enum { KEY_COUNT = (int)(sizeof keys / sizeof keys[0]) };

/* Writes "; the keys here are a, b, c": those of the job's kind. */
static void list_keys(const struct pen_request *request, char *out, size_t bytes)
{
    size_t used = (size_t)snprintf(out, bytes, "; the keys here are ");
    const char *comma = "";
    for (int i = 0; i < KEY_COUNT && used < bytes; i++) {
        if (keys[i].kinds && !(keys[i].kinds >> request->kind & 1))
            continue;
        used += (size_t)snprintf(out + used, bytes - used, "%s%s", comma, keys[i].key);
        comma = ", ";
    }
}

static void refuse_unknown_key(const struct pen_request *request, const char *key,
                               struct pen_errors *errors)
{
    const char *names[KEY_COUNT + 1] = {NULL};
    char hint[384];
    for (int i = 0; i < KEY_COUNT; i++)
        names[i] = keys[i].key;
    const char *near = pen_nearest_name(key, names);
    if (pen_settings_has(key))
        snprintf(hint, sizeof hint, "; it is a setting: write {\"render\": {\"%s\": …}}", key);
    else if (near)
        snprintf(hint, sizeof hint, "; did you mean \"%s\"?", near);
    else
        list_keys(request, hint, sizeof hint);
    pen_request_fail(errors, PEN_INVALID, "", key, "unknown key in a job%s", hint);
}

/* Refuses the keys that only another kind of job may have. */
static void refuse_keys_of_other_kinds(const struct pen_request *request, struct pen_errors *errors)
{
    for (int i = 0; i < KEY_COUNT; i++) {
        char kinds[80];
        if (!keys[i].kinds || keys[i].kinds >> request->kind & 1 ||
            !json_object_get(request->body, keys[i].key))
            continue;
        name_kinds(keys[i].kinds, kinds, sizeof kinds);
        pen_request_fail(errors, PEN_INVALID, "", keys[i].key,
                         "belongs to jobs of kind %s; this one is of kind \"%s\"", kinds,
                         pen_job_kinds[request->kind]);
    }
}

/* The index of a key's row; KEY_COUNT if there is none. */
static int find_key(const char *key)
{
    int i = 0;
    while (i < KEY_COUNT && strcmp(keys[i].key, key) != 0)
        i++;
    return i;
}

/* This comes after the job's kind, which may be its last key, is known. */
static void refuse_unknown_keys(const struct pen_request *request, struct pen_errors *errors)
{
    const char *key;
    json_t *value;
    json_object_foreach(request->body, key, value)
    {
        if (find_key(key) == KEY_COUNT)
            refuse_unknown_key(request, key, errors);
    }
}

void pen_request_keys_read(struct pen_request *request, struct pen_errors *errors)
{
    const char *key;
    json_t *value;
    json_object_foreach(request->body, key, value)
    {
        int i = find_key(key);
        if (i < KEY_COUNT && keys[i].read)
            keys[i].read(request, value, errors);
    }
    if (request->labels)
        bound_texts(request, errors);
    refuse_unknown_keys(request, errors);
    refuse_keys_of_other_kinds(request, errors);
}

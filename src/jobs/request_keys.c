/* SPDX-License-Identifier: MIT */
/* Reads a job's keys. The table of all keys has the kinds of jobs to which each key belongs. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "io/message.h"
#include "io/settings_json.h"
#include "jobs/internal/members.h"
#include "jobs/internal/request.h"
#include "render/audit.h"

/* Sets of kinds, one bit each. */
enum {
    RENDER = 1 << PEN_KIND_RENDER,
    BENCHMARK = 1 << PEN_KIND_BENCHMARK,
    ACCURACY = 1 << PEN_KIND_ACCURACY,
    EFFECTS = 1 << PEN_KIND_EFFECTS,
    EXPLAIN = 1 << PEN_KIND_EXPLAIN,
    SUBMITTED = RENDER | BENCHMARK | ACCURACY | EFFECTS /* those that a job may name */
};

/* Writes the kinds of a set in words: "benchmark" or "effects". */
static void name_kinds(unsigned kinds, char *out, size_t bytes)
{
    size_t used = 0;
    for (int i = 0; i < PEN_KIND_COUNT && used < bytes; i++)
        if (kinds >> i & 1)
            used += (size_t)snprintf(out + used, bytes - used, "%s\"%s\"", used ? " or " : "",
                                     pen_job_kinds[i]);
}

/* Lists the names of a set of kinds, with NULL at the end. */
static void list_kinds(unsigned kinds, const char *names[PEN_KIND_COUNT + 1])
{
    int count = 0;
    for (int i = 0; i < PEN_KIND_COUNT; i++)
        if (kinds >> i & 1)
            names[count++] = pen_job_kinds[i];
    names[count] = NULL;
}

static void read_kind(struct pen_request *request, struct pen_errors *errors)
{
    static const char *const explained[] = {"render", "explain", NULL};
    const json_t *value = json_object_get(request->body, "kind");
    const char *submitted[PEN_KIND_COUNT + 1];
    const char *word = json_string_value(value);
    char kinds[80];
    list_kinds(SUBMITTED, submitted);
    name_kinds(SUBMITTED, kinds, sizeof kinds);
    if (!value)
        return;
    if (request->explain)
        pen_word_read(value, "", "kind", explained, errors);
    else if (word && strcmp(word, pen_job_kinds[PEN_KIND_EXPLAIN]) == 0)
        pen_request_fail(errors, PEN_INVALID, "", "kind",
                         "POST /v1/explain makes jobs of kind \"explain\"; here take %s", kinds);
    else if (pen_word_read(value, "", "kind", submitted, errors) >= 0)
        pen_job_kind_of_name(word, &request->kind);
}

/* Returns the length of a string. The strings of a body contain no zero byte. */
static size_t characters(const json_t *string)
{
    return pen_utf8_count(json_string_value(string));
}

static void read_name(struct pen_request *request, struct pen_errors *errors)
{
    request->name = json_object_get(request->body, "name");
    if (request->name && !json_is_string(request->name))
        pen_request_fail(errors, PEN_INVALID, "", "name",
                         "must be a string of at most %d characters, found %s",
                         (int)PEN_JOB_NAME_CHARACTERS, pen_found(request->name).text);
    else if (request->name && characters(request->name) > PEN_JOB_NAME_CHARACTERS)
        pen_request_fail(errors, PEN_INVALID, "", "name",
                         "must be a string of at most %d characters, found one of %zu",
                         (int)PEN_JOB_NAME_CHARACTERS, characters(request->name));
}

/* Lists select a label by "key:value", so a key must not be empty or contain a colon. */
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

/* Returns the length of a value as JSON text; 0 without a value. */
static size_t text_bytes(const json_t *value)
{
    return value ? json_dumpb(value, NULL, 0, JSON_COMPACT | JSON_ENCODE_ANY) : 0;
}

/* Every reader of the job gets its texts, and lists have the texts of many jobs. A name alone is
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

static void read_labels(struct pen_request *request, struct pen_errors *errors)
{
    const json_t *value = json_object_get(request->body, "labels");
    if (!value)
        return;
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
    bound_texts(request, errors);
}

static void read_layers(struct pen_request *request, struct pen_errors *errors)
{
    const json_t *list = json_object_get(request->body, "layers");
    const size_t count = json_array_size(list);
    if (list && (count < 1 || count > PEN_LAYER_COUNT))
        pen_request_fail(errors, PEN_INVALID, "", "layers",
                         "must be an array of 1 to %d names of layers, found %s",
                         (int)PEN_LAYER_COUNT, pen_found(list).text);
    for (size_t i = 0; i < count && count <= PEN_LAYER_COUNT; i++) {
        const json_t *name = json_array_get(list, i);
        const struct pen_found at = pen_position(i);
        const int layer = pen_word_read(name, "/layers", at.text, pen_layer_names, errors);
        request->cost_layer |= layer == PEN_LAYER_COST;
        for (size_t k = 0; layer >= 0 && k < i; k++)
            if (json_equal(json_array_get(list, k), name))
                pen_request_fail(errors, PEN_INVALID, "/layers", at.text, "%s is there twice",
                                 pen_found(name).text);
    }
    request->layers = errors->count == 0 ? list : NULL;
}

static void read_cost(struct pen_request *request, struct pen_errors *errors)
{
    const json_t *value = json_object_get(request->body, "cost");
    const int cost = value ? pen_word_read(value, "", "cost", pen_cost_names, errors) : -1;
    request->cost = cost >= 0 ? (enum pen_cost)cost : PEN_COST_TIME;
}

static void read_audit(struct pen_request *request, struct pen_errors *errors)
{
    static const char *const names[] = {"pixels", "threshold", NULL};
    const json_t *audit = json_object_get(request->body, "audit");
    if (!audit)
        return;
    if (!json_is_object(audit)) {
        pen_request_fail(errors, PEN_INVALID, "", "audit",
                         "must be an object of pixels and threshold, found %s",
                         pen_found(audit).text);
        return;
    }
    request->audit_pixels = PEN_AUDIT_PIXELS;
    request->audit_threshold = PEN_AUDIT_THRESHOLD;
    pen_integer_read(audit, "/audit", "pixels", 1, PEN_AUDIT_PIXELS_MAX, &request->audit_pixels,
                     errors);
    pen_number_read(audit, "/audit", "threshold", PEN_ABOVE_0, nextafter(1, 0),
                    "above 0 and below 1", &request->audit_threshold, errors);
    pen_keys_check(audit, "/audit", names, errors);
}

static void read_priority(struct pen_request *request, struct pen_errors *errors)
{
    const json_t *value = json_object_get(request->body, "priority");
    const bool lowered = request->priority_max < 100 && json_is_number(value);
    if (lowered && json_number_value(value) > request->priority_max)
        pen_request_fail(errors, PEN_INVALID, "", "priority",
                         "must be an integer, at least -100, at most %d, which this daemon allows, "
                         "found %s",
                         request->priority_max, pen_found(value).text);
    else
        pen_integer_read(request->body, "", "priority", -100, 100, &request->priority, errors);
}

static void read_times(struct pen_request *request, struct pen_errors *errors)
{
    char range[80];
    double seconds = (double)request->timeout_ms / 1000;
    snprintf(range, sizeof range, "above 0, at most %d, which this daemon allows",
             request->timeout_max_s);
    pen_number_read(request->body, "", "timeout_seconds", PEN_ABOVE_0, request->timeout_max_s,
                    range, &seconds, errors);
    request->timeout_ms = (int64_t)ceil(seconds * 1000);
    snprintf(range, sizeof range, "above 0, at most %d", (int)PEN_BUDGET_SECONDS_MAX);
    if (request->kind == PEN_KIND_RENDER) /* the budget of a study belongs to its spec */
        pen_number_read(request->body, "", "budget_seconds", PEN_ABOVE_0, PEN_BUDGET_SECONDS_MAX,
                        range, &request->budget_seconds, errors);
}

static const struct {
    const char *key;
    unsigned kinds; /* the kinds of jobs that may have the key; 0: all */
} keys[] = {
    {.key = "scene"},
    {.key = "kind"},
    {.key = "render"},
    {.key = "views"},
    {.key = "priority"},
    {.key = "name"},
    {.key = "labels"},
    {.key = "layers", .kinds = RENDER | BENCHMARK | ACCURACY | EFFECTS},
    {.key = "cost", .kinds = RENDER},
    {.key = "audit", .kinds = RENDER},
    {.key = "max_attempts"},
    {.key = "timeout_seconds"},
    {.key = "matrix", .kinds = BENCHMARK},
    {.key = "repeats", .kinds = BENCHMARK | EFFECTS},
    {.key = "warmup", .kinds = BENCHMARK},
    {.key = "baseline", .kinds = BENCHMARK},
    {.key = "interval", .kinds = BENCHMARK},
    {.key = "least_effect", .kinds = BENCHMARK},
    {.key = "order_seed", .kinds = BENCHMARK},
    {.key = "analyze", .kinds = EXPLAIN},
    {.key = "ladder", .kinds = ACCURACY},
    {.key = "product", .kinds = ACCURACY},
    {.key = "reference", .kinds = ACCURACY},
    {.key = "target", .kinds = ACCURACY},
    {.key = "seeds", .kinds = ACCURACY},
    {.key = "budget_seconds", .kinds = RENDER | BENCHMARK | ACCURACY},
};
enum { KEY_COUNT = (int)(sizeof keys / sizeof keys[0]) };

/* Writes "; the keys here are a, b, c" with the keys of the job's kind. */
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
                               const char *const *names, struct pen_errors *errors)
{
    char hint[384];
    const char *near = pen_nearest_name(key, names);
    if (pen_settings_has(key))
        snprintf(hint, sizeof hint, "; it is a setting: write {\"render\": {\"%s\": …}}", key);
    else if (near)
        snprintf(hint, sizeof hint, "%s", pen_did_you_mean(near).text);
    else
        list_keys(request, hint, sizeof hint);
    pen_request_fail(errors, PEN_INVALID, "", key, "unknown key in a job%s", hint);
}

/* Refuses keys that only another kind of job may have. */
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

static void refuse_unknown_keys(const struct pen_request *request, struct pen_errors *errors)
{
    const char *names[KEY_COUNT + 1] = {NULL};
    const char *key;
    json_t *value;
    for (int i = 0; i < KEY_COUNT; i++)
        names[i] = keys[i].key;
    json_object_foreach(request->body, key, value)
    {
        if (pen_name_index(key, names) < 0)
            refuse_unknown_key(request, key, names, errors);
    }
}

void pen_request_keys_read(struct pen_request *request, struct pen_errors *errors)
{
    read_kind(request, errors);
    read_priority(request, errors);
    read_name(request, errors);
    read_labels(request, errors);
    read_layers(request, errors);
    read_cost(request, errors);
    read_audit(request, errors);
    read_times(request, errors);
    pen_integer_read(request->body, "", "max_attempts", 1, 10, &request->max_attempts, errors);
    pen_boolean_read(request->body, "analyze", &request->analyze, errors);
    refuse_unknown_keys(request, errors);
    refuse_keys_of_other_kinds(request, errors);
}

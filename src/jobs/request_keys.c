/* SPDX-License-Identifier: MIT */
/* The table of a job's keys: the function that reads each key, and the kind of job to which the key
 * belongs. Keys of kinds that are not supported yet are refused, and the error names the kind. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "jobs/internal/request.h"
#include "jobs/internal/request_errors.h"

static const char benchmark[] = "benchmark";

const char *const pen_job_kinds[] = {"render", benchmark, "accuracy", "effects", NULL};
const char *const pen_job_layers[] = {"beauty", "cost", "samples", "depth", "normal", NULL};
enum { LAYER_COUNT = (int)(sizeof pen_job_layers / sizeof pen_job_layers[0]) - 1 };

enum { POSITION_BYTES = 24 };

typedef void key_fn(struct pen_request *request, const json_t *value, struct pen_errors *errors);

/* Reads an integer; a number such as 3.0 counts as one. */
static bool read_integer(const json_t *value, const char *key, int lo, int hi, int *out,
                         struct pen_errors *errors)
{
    double number = json_number_value(value);
    if (!json_is_number(value) || number != floor(number) || number < lo || number > hi) {
        pen_request_fail(errors, PEN_INVALID, "", key, "must be an integer from %d to %d, found %s",
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

static void read_kind(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    const char *kind = read_word(value, "", "kind", pen_job_kinds, errors);
    if (kind && strcmp(kind, "render") != 0 && strcmp(kind, benchmark) != 0)
        pen_request_fail(errors, PEN_UNSUPPORTED, "", "kind",
                         "jobs of kind \"%s\" are known, not supported yet; \"render\" and "
                         "\"benchmark\" are",
                         kind);
    else if (kind)
        request->kind = kind;
    request->benchmark = kind && strcmp(kind, benchmark) == 0;
}

static void read_name(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    if (!json_is_string(value))
        pen_request_fail(errors, PEN_INVALID, "", "name",
                         "must be a string of at most %d bytes, found %s", (int)PEN_JOB_NAME_BYTES,
                         pen_found(value).text);
    else if (json_string_length(value) > PEN_JOB_NAME_BYTES)
        pen_request_fail(errors, PEN_INVALID, "", "name",
                         "must be a string of at most %d bytes, found one of %zu",
                         (int)PEN_JOB_NAME_BYTES, json_string_length(value));
    request->name = value;
}

static void read_label(const char *key, const json_t *label, struct pen_errors *errors)
{
    if (!json_is_string(label))
        pen_request_fail(errors, PEN_INVALID, "/labels", key, "must be a string, found %s",
                         pen_found(label).text);
    else if (json_string_length(label) > PEN_JOB_NAME_BYTES || strlen(key) > PEN_JOB_NAME_BYTES)
        pen_request_fail(errors, PEN_INVALID, "/labels", key,
                         "must be at most %d bytes long, and its key too; found %zu and %zu",
                         (int)PEN_JOB_NAME_BYTES, json_string_length(label), strlen(key));
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

static void read_layer(const json_t *list, size_t i, struct pen_errors *errors)
{
    char position[POSITION_BYTES];
    snprintf(position, sizeof position, "%zu", i);
    const char *layer =
        read_word(json_array_get(list, i), "/layers", position, pen_job_layers, errors);
    if (layer && strcmp(layer, pen_job_layers[0]) != 0)
        pen_request_fail(errors, PEN_UNSUPPORTED, "/layers", position,
                         "the layer \"%s\" is known, not supported yet; only \"beauty\" is", layer);
    for (size_t k = 0; layer && k < i; k++) {
        if (json_equal(json_array_get(list, k), json_array_get(list, i)))
            pen_request_fail(errors, PEN_INVALID, "/layers", position, "%s is there twice",
                             pen_found(json_array_get(list, i)).text);
    }
}

static void read_layers(struct pen_request *request, const json_t *value, struct pen_errors *errors)
{
    (void)request;
    size_t count = json_array_size(value);
    if (count < 1 || count > LAYER_COUNT)
        pen_request_fail(errors, PEN_INVALID, "", "layers",
                         "must be an array of 1 to %d names of layers, found %s", (int)LAYER_COUNT,
                         pen_found(value).text);
    for (size_t i = 0; i < count && count <= LAYER_COUNT; i++)
        read_layer(value, i, errors);
}

static void read_priority(struct pen_request *request, const json_t *value,
                          struct pen_errors *errors)
{
    read_integer(value, "priority", -100, 100, &request->priority, errors);
}

static void read_max_attempts(struct pen_request *request, const json_t *value,
                              struct pen_errors *errors)
{
    read_integer(value, "max_attempts", 1, 10, &request->max_attempts, errors);
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
    key_fn *read;                 /* NULL: request.c or bench_spec.c reads the key */
    const char *kind;             /* the only kind of job that may have the key; NULL: all kinds */
    const char *unsupported_kind; /* the kind of job, not supported yet, that will have the key */
} keys[] = {
    {.key = "scene"},
    {.key = "kind", .read = read_kind},
    {.key = "render"},
    {.key = "views"},
    {.key = "priority", .read = read_priority},
    {.key = "name", .read = read_name},
    {.key = "labels", .read = read_labels},
    {.key = "layers", .read = read_layers},
    {.key = "max_attempts", .read = read_max_attempts},
    {.key = "timeout_seconds", .read = read_timeout},
    {.key = "matrix", .kind = benchmark},
    {.key = "repeats", .kind = benchmark},
    {.key = "warmup", .kind = benchmark},
    {.key = "baseline", .kind = benchmark},
    {.key = "ladder", .unsupported_kind = "accuracy"},
    {.key = "reference", .unsupported_kind = "accuracy"},
    {.key = "target", .unsupported_kind = "accuracy"},
    {.key = "seeds", .unsupported_kind = "accuracy"},
    {.key = "budget_seconds", .unsupported_kind = "accuracy"},
};
enum { KEY_COUNT = (int)(sizeof keys / sizeof keys[0]) };

static void refuse_unknown_key(const char *key, struct pen_errors *errors)
{
    const char *names[KEY_COUNT + 1] = {NULL};
    int count = 0;
    for (int i = 0; i < KEY_COUNT; i++) {
        if (!keys[i].unsupported_kind)
            names[count++] = keys[i].key;
    }
    const char *near = pen_nearest_name(key, names);
    pen_request_fail(errors, PEN_INVALID, "", key, "unknown key in a job%s%s%s",
                     near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
}

/* Refuses the keys that only another kind of job may have. */
static void refuse_keys_of_other_kinds(const struct pen_request *request, struct pen_errors *errors)
{
    for (int i = 0; i < KEY_COUNT; i++) {
        if (keys[i].kind && strcmp(keys[i].kind, request->kind) != 0 &&
            json_object_get(request->body, keys[i].key))
            pen_request_fail(errors, PEN_INVALID, "", keys[i].key,
                             "belongs to jobs of kind \"%s\"; this one is of kind \"%s\"",
                             keys[i].kind, request->kind);
    }
}

void pen_request_keys_read(struct pen_request *request, struct pen_errors *errors)
{
    const char *key;
    json_t *value;
    json_object_foreach(request->body, key, value)
    {
        int i = 0;
        while (i < KEY_COUNT && strcmp(keys[i].key, key) != 0)
            i++;
        if (i == KEY_COUNT)
            refuse_unknown_key(key, errors);
        else if (keys[i].unsupported_kind)
            pen_request_fail(errors, PEN_UNSUPPORTED, "", key,
                             "jobs of kind \"%s\" are known, not supported yet",
                             keys[i].unsupported_kind);
        else if (keys[i].read)
            keys[i].read(request, value, errors);
    }
    refuse_keys_of_other_kinds(request, errors);
}

/* SPDX-License-Identifier: MIT */
/* The route table, and the functions that find a request's route and check its parameters. */
#include "http/internal/routes.h"

#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "http/internal/request.h"
#include "http/server.h"
#include "io/scene_json.h"
#include "render/layers.h"

static const char *const states[PEN_JOB_STATE_COUNT + 1] = {
    [PEN_JOB_QUEUED] = "queued",       [PEN_JOB_RUNNING] = "running",
    [PEN_JOB_SUCCEEDED] = "succeeded", [PEN_JOB_FAILED] = "failed",
    [PEN_JOB_CANCELLED] = "cancelled",
};
_Static_assert(PEN_JOB_STATE_COUNT == 5, "each state of a job has its name here");

static const struct param_rule list_params[] = {{.name = "state", .allowed = states},
                                                {.name = "kind", .allowed = pen_job_kinds},
                                                {.name = "name", .longest = 200},
                                                {.name = "label", .longest = 401},
                                                {.name = "limit", .low = 1, .high = 500},
                                                {.name = "cursor", .longest = 200},
                                                {0}};
static const struct param_rule job_params[] = {{.name = "wait", .low = 0, .high = 60}, {0}};
static const struct param_rule image_params[] = {{.name = "view", .longest = 200},
                                                 {.name = "layer", .allowed = pen_layer_names},
                                                 {.name = "format", .allowed = pen_image_formats},
                                                 {.name = "max_edge", .low = 64, .high = 512},
                                                 {0}};
static const char *const compare_formats[] = {"json", "png", NULL};
static const struct param_rule compare_params[] = {{.name = "with", .is_job = true},
                                                   {.name = "view", .longest = 200},
                                                   {.name = "format", .allowed = compare_formats},
                                                   {0}};
static const char *const booleans[] = {"false", "true", NULL};
static const struct param_rule delete_params[] = {{.name = "stats", .allowed = booleans}, {0}};
static const struct param_rule stats_params[] = {{.name = "so_far", .allowed = booleans}, {0}};
static const struct param_rule preview_params[] = {{.name = "view", .longest = 200}, {0}};

/* Defines a route. Without a scope it does not compile. */
#define ROUTE(METHOD, PATH, SCOPE, HANDLE, ...)                                                    \
    {                                                                                              \
        .method = METHOD, .path = PATH, .scope = PEN_SCOPE_##SCOPE,                                \
        .handle = pen_http_handle_##HANDLE, __VA_ARGS__                                            \
    }

static const struct route table[] = {
    ROUTE("POST", "/v1/jobs", SUBMIT, submit, .queue = QUEUE_CHANGES, .takes_body = true,
          .submits = true),
    ROUTE("GET", "/v1/jobs", READ, list, .queue = QUEUE_STORE, .params = list_params),
    ROUTE("GET", "/v1/jobs/{id}", READ, job, .quick = pen_http_quick_job, .queue = QUEUE_STORE,
          .params = job_params),
    ROUTE("DELETE", "/v1/jobs/{id}", SUBMIT, delete, .queue = QUEUE_CHANGES,
          .params = delete_params),
    ROUTE("GET", "/v1/jobs/{id}/events", READ, events, .queue = QUEUE_STORE),
    ROUTE("GET", "/v1/jobs/{id}/image", READ, image, .queue = QUEUE_COMPUTE,
          .params = image_params),
    ROUTE("GET", "/v1/jobs/{id}/compare", READ, compare, .queue = QUEUE_COMPUTE,
          .params = compare_params),
    ROUTE("GET", "/v1/jobs/{id}/preview", READ, preview, .queue = QUEUE_COMPUTE,
          .params = preview_params),
    ROUTE("GET", "/v1/jobs/{id}/stats", READ, stats, .queue = QUEUE_COMPUTE,
          .params = stats_params),
    ROUTE("GET", "/v1/jobs/{id}/report", READ, report, .queue = QUEUE_COMPUTE),
    ROUTE("GET", "/v1/jobs/{id}/scene", READ, scene, .queue = QUEUE_COMPUTE),
    ROUTE("POST", "/v1/jobs/{id}/cancel", SUBMIT, cancel, .queue = QUEUE_CHANGES),
    ROUTE("POST", "/v1/validate", READ, validate, .queue = QUEUE_COMPUTE, .takes_body = true),
    ROUTE("POST", "/v1/explain", SUBMIT, explain, .queue = QUEUE_CHANGES, .takes_body = true,
          .submits = true, .handle_again = true),
    ROUTE("GET", "/v1/scenes", READ, file, .queue = QUEUE_NONE),
    ROUTE("GET", "/v1/scenes/{name}", READ, file, .queue = QUEUE_NONE),
    ROUTE("GET", "/v1/workers", READ, workers, .queue = QUEUE_STORE),
    ROUTE("GET", "/", NONE, file, .queue = QUEUE_NONE),
    ROUTE("GET", "/page/{name}", NONE, file, .queue = QUEUE_NONE),
    ROUTE("GET", "/healthz", NONE, healthz, .queue = QUEUE_NONE),
    ROUTE("GET", "/readyz", NONE, readyz, .queue = QUEUE_CHANGES),
    ROUTE("GET", "/metrics", READ, metrics, .queue = QUEUE_STORE),
    ROUTE("GET", "/openapi.yaml", NONE, file, .queue = QUEUE_NONE),
    ROUTE("GET", "/scene.schema.json", NONE, file, .queue = QUEUE_NONE),
};

enum { LARGE_BODY = 64 << 10 }; /* bytes; larger bodies take some milliseconds to parse */
enum { ROUTES = sizeof table / sizeof table[0] };

/* Paths of resources that are not supported yet. They get a 404 that says so. */
static const char *const unsupported[] = {"/v1/plan", "/v1/assets/{sha256}"};

bool pen_http_route(int i, const char **method, const char **path, int *scope)
{
    if (i < 0 || i >= ROUTES)
        return false;
    *method = table[i].method;
    *path = table[i].path;
    *scope = (int)table[i].scope;
    return true;
}

/* Appends a method to the list of allowed methods; HEAD follows GET. */
static void allow_method(char allow[ALLOW_BYTES], const char *method)
{
    size_t used = strlen(allow);
    snprintf(allow + used, ALLOW_BYTES - used, "%s%s", used ? ", " : "", method);
    if (strcmp(method, "GET") == 0)
        allow_method(allow, "HEAD");
}

static bool fail_unknown(const struct pen_target *target, struct pen_status *st)
{
    const char *arg;
    for (size_t i = 0; i < sizeof unsupported / sizeof unsupported[0]; i++) {
        if (pen_target_matches(target, unsupported[i], &arg))
            return pen_fail(st, PEN_NOT_FOUND, "%s is known, but not supported yet",
                            unsupported[i]);
    }
    return pen_fail(st, PEN_NOT_FOUND,
                    "there is nothing at this path; GET /openapi.yaml lists all paths");
}

const struct route *pen_http_route_find(const char *method, const struct pen_target *target,
                                        const char **arg, char allow[ALLOW_BYTES],
                                        struct pen_status *st)
{
    const char *wanted = strcmp(method, "HEAD") == 0 ? "GET" : method;
    allow[0] = '\0';
    for (size_t i = 0; i < ROUTES; i++) {
        if (!pen_target_matches(target, table[i].path, arg))
            continue;
        if (strcmp(table[i].method, wanted) == 0) {
            allow[0] = '\0';
            return &table[i];
        }
        allow_method(allow, table[i].method);
    }
    if (allow[0])
        pen_fail(st, PEN_METHOD, "the method %.40s is not allowed here; %s are", method, allow);
    else
        fail_unknown(target, st);
    return NULL;
}

/* Joins names as "a, b, c". */
static void join_names(char *out, size_t bytes, const char *const *names)
{
    out[0] = '\0';
    for (size_t used = 0; *names && used < bytes; names++)
        used += (size_t)snprintf(out + used, bytes - used, "%s%s", used ? ", " : "", *names);
}

static bool fail_unknown_param(const struct route *route, const char *name, struct pen_status *st)
{
    enum { NAMES = 8 };
    const char *names[NAMES + 1] = {0};
    if (!route->params)
        return pen_fail(st, PEN_USAGE, "unknown query parameter \"%.100s\"; none is allowed here",
                        name);
    for (int i = 0; i < NAMES && route->params[i].name; i++)
        names[i] = route->params[i].name;
    char list[200];
    join_names(list, sizeof list, names);
    const char *near = pen_nearest_name(name, names);
    return pen_fail(st, PEN_USAGE, "unknown query parameter \"%.100s\"; %s%s%s are %s", name,
                    near ? "did you mean \"" : "", near ? near : "",
                    near ? "\"? Allowed" : "allowed", list);
}

static bool check_value(const struct param_rule *rule, const char *value, struct pen_status *st)
{
    if (rule->allowed) {
        for (const char *const *name = rule->allowed; *name; name++) {
            if (strcmp(*name, value) == 0)
                return true;
        }
        char list[200];
        join_names(list, sizeof list, rule->allowed);
        const char *near = pen_nearest_name(value, rule->allowed);
        return pen_fail(st, PEN_USAGE, "query parameter %s is \"%.100s\"; %s%s%s are %s",
                        rule->name, value, near ? "did you mean \"" : "", near ? near : "",
                        near ? "\"? Allowed" : "allowed", list);
    }
    if (rule->high > 0) {
        long number;
        return pen_number_parse(value, rule->low, rule->high, &number) ||
               pen_fail(st, PEN_USAGE,
                        "query parameter %s is \"%.100s\"; a whole number from %ld to %ld is "
                        "allowed",
                        rule->name, value, rule->low, rule->high);
    }
    if (rule->is_job) {
        char id[PEN_UUID_BYTES];
        return pen_uuid_parse(value, id) ||
               pen_fail(st, PEN_USAGE,
                        "query parameter %s is \"%.80s\"; the id of a job is allowed", rule->name,
                        value);
    }
    size_t length = pen_utf8_count(value);
    return (length > 0 && length <= rule->longest) ||
           pen_fail(st, PEN_USAGE, "query parameter %s has %zu characters; 1 to %zu are allowed",
                    rule->name, length, rule->longest);
}

static bool check_param(const struct route *route, const struct pen_param *param,
                        struct pen_status *st)
{
    for (const struct param_rule *rule = route->params; rule && rule->name; rule++) {
        if (strcmp(rule->name, param->name) == 0)
            return check_value(rule, param->value, st);
    }
    return fail_unknown_param(route, param->name, st);
}

bool pen_http_route_check_params(const struct route *route, const struct pen_target *target,
                                 struct pen_status *st)
{
    for (int i = 0; i < target->param_count; i++) {
        const struct pen_param *param = &target->param[i];
        if (!check_param(route, param, st))
            return false;
        if (pen_target_param(target, param->name) != param->value)
            return pen_fail(st, PEN_USAGE, "query parameter %s is given twice", param->name);
    }
    for (const struct param_rule *rule = route->params; rule && rule->name; rule++) {
        if (rule->is_job && !pen_target_param(target, rule->name))
            return pen_fail(st, PEN_USAGE, "query parameter %s is missing: the id of another job",
                            rule->name);
    }
    return true;
}

enum queue_id pen_http_route_queue(const struct route *route, const struct request *request)
{
    const struct pen_target *target = &request->target;
    if (request->body.bytes > LARGE_BODY ||
        (request->body.bytes > 0 && request->fields.content_encoding))
        return QUEUE_COMPUTE;
    if (route->handle != pen_http_handle_image)
        return route->queue;
    const char *view = pen_target_param(target, "view");
    const char *layer = pen_target_param(target, "layer");
    const char *format = pen_target_param(target, "format");
    const bool stored =
        (!view || strcmp(view, "all") != 0) && (!layer || strcmp(layer, "beauty") == 0) &&
        (!format || strcmp(format, "png") == 0) && !pen_target_param(target, "max_edge");
    return stored ? QUEUE_STORE : QUEUE_COMPUTE;
}

/* SPDX-License-Identifier: MIT */
/* The route table and api/openapi.yaml agree: every route is documented, and every documented
 * operation is a route. The embedded text of the definition is read by its indentation. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "access/token_file.h"
#include "base/embed.h"
#include "http/server.h"
#include "support/suite.h"

enum { OPERATIONS_MAX = 100 };

struct operation {
    char method[8], path[64];
};

static const char *definition(void)
{
    for (const struct pen_embedded_file *file = pen_api_files; file->name; file++) {
        if (strcmp(file->name, "openapi.yaml") == 0)
            return (const char *)file->data;
    }
    ck_abort_msg("openapi.yaml is not carried");
    return NULL;
}

static bool is_method(const char *word)
{
    static const char *const methods[] = {"get",     "put",  "post",  "delete",
                                          "options", "head", "patch", "trace"};
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++) {
        if (strcmp(methods[i], word) == 0)
            return true;
    }
    return false;
}

/* Under `paths:`, two spaces and a slash begin a path, four spaces and a method an operation. */
static int read_definition(struct operation *operations)
{
    int count = 0;
    char path[64] = "", word[16];
    const char *line = strstr(definition(), "\npaths:\n");
    ck_assert_ptr_nonnull(line);
    line += strlen("\npaths:\n");
    for (; *line && (*line == ' ' || *line == '\n'); line = strchr(line, '\n') + 1) {
        if (strncmp(line, "  /", 3) == 0)
            ck_assert_int_eq(sscanf(line, "  %63[^:]:", path), 1);
        if (sscanf(line, "    %15[a-z]:", word) == 1 && strncmp(line, "    ", 4) == 0 &&
            isalpha((unsigned char)line[4]) && is_method(word)) {
            ck_assert_int_lt(count, OPERATIONS_MAX);
            struct operation *operation = &operations[count++];
            snprintf(operation->path, sizeof operation->path, "%s", path);
            for (size_t i = 0; i <= strlen(word) && i < sizeof operation->method; i++)
                operation->method[i] = (char)toupper((unsigned char)word[i]);
        }
    }
    return count;
}

START_TEST(test_routes__every_route_is_documented)
{
    struct operation operations[OPERATIONS_MAX];
    int count = read_definition(operations);
    const char *method, *path;
    int scope;
    for (int i = 0; pen_http_route(i, &method, &path, &scope); i++) {
        bool found = false;
        for (int k = 0; k < count; k++)
            found = found || (strcmp(operations[k].method, method) == 0 &&
                              strcmp(operations[k].path, path) == 0);
        ck_assert_msg(found, "%s %s is not in openapi.yaml", method, path);
    }
}
END_TEST

START_TEST(test_routes__everything_documented_is_a_route)
{
    struct operation operations[OPERATIONS_MAX];
    int count = read_definition(operations);
    ck_assert_int_gt(count, 10);
    for (int k = 0; k < count; k++) {
        bool found = false;
        const char *method, *path;
        int scope;
        for (int i = 0; pen_http_route(i, &method, &path, &scope); i++)
            found = found || (strcmp(operations[k].method, method) == 0 &&
                              strcmp(operations[k].path, path) == 0);
        ck_assert_msg(found, "%s %s is in openapi.yaml only", operations[k].method,
                      operations[k].path);
    }
}
END_TEST

START_TEST(test_routes__no_route_twice)
{
    const char *method, *path, *other_method, *other_path;
    int scope;
    int count = 0;
    while (pen_http_route(count, &method, &path, &scope))
        count++;
    ck_assert(!pen_http_route(-1, &method, &path, &scope));
    for (int i = 0; i < count; i++) {
        pen_http_route(i, &method, &path, &scope);
        for (int k = 0; k < i; k++) {
            pen_http_route(k, &other_method, &other_path, &scope);
            ck_assert_msg(strcmp(method, other_method) != 0 || strcmp(path, other_path) != 0,
                          "%s %s", method, path);
        }
    }
}
END_TEST

/* All but six paths need a token, and everything that changes something one of scope submit. */
START_TEST(test_routes__have_scopes)
{
    static const char *const open[] = {"/",       "/page/{name}",  "/healthz",
                                       "/readyz", "/openapi.yaml", "/scene.schema.json"};
    const char *method, *path;
    int scope;
    for (int i = 0; pen_http_route(i, &method, &path, &scope); i++) {
        bool is_open = false;
        for (size_t k = 0; k < sizeof open / sizeof open[0]; k++)
            is_open = is_open || strcmp(path, open[k]) == 0;
        const bool reads = strcmp(method, "GET") == 0 || strcmp(path, "/v1/validate") == 0;
        const int expected = is_open ? PEN_SCOPE_NONE : reads ? PEN_SCOPE_READ : PEN_SCOPE_SUBMIT;
        ck_assert_msg(scope == expected, "%s %s: %d", method, path, scope);
    }
}
END_TEST

PEN_SUITE("routes", test_routes__have_scopes, test_routes__every_route_is_documented,
          test_routes__everything_documented_is_a_route, test_routes__no_route_twice)

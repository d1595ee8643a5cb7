/* SPDX-License-Identifier: MIT */
/* Rights: every route of the table, with every method, and with tokens of every scope. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "access/token_file.h"
#include "support/server.h"
#include "support/suite.h"

/* The senders of requests. */
enum { NOBODY, STRANGER, READER, SUBMITTER, OTHER, ADMIN, SENDERS };
static const enum pen_scope scope_of[SENDERS] = {
    [READER] = PEN_SCOPE_READ,
    [SUBMITTER] = PEN_SCOPE_SUBMIT,
    [OTHER] = PEN_SCOPE_SUBMIT,
    [ADMIN] = PEN_SCOPE_ADMIN,
};
static char token[SENDERS][PEN_TOKEN_BYTES], path[] = "/tmp/penumbra-tokens-XXXXXX";

/* Writes a token file with a token of each sender except the stranger. The token of sender
 * `without` is left out. */
static void write_tokens(int without)
{
    static struct pen_token made[SENDERS];
    struct pen_token_list list = {0};
    struct pen_buf text = {0};
    struct pen_status st;
    char name[20];
    for (int i = STRANGER; i < SENDERS; i++) {
        snprintf(name, sizeof name, "sender-%d", i);
        if (!token[i][0])
            ck_assert(pen_token_make(&made[i], name, i == STRANGER ? PEN_SCOPE_ADMIN : scope_of[i],
                                     token[i], &st));
        if (i != STRANGER && i != without)
            ck_assert(pen_token_list_add(&list, &made[i], &st));
    }
    pen_token_list_print(&list, &text);
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(text.data, 1, text.bytes, file), text.bytes);
    ck_assert_int_eq(fclose(file), 0);
    pen_buf_release(&text);
    pen_token_list_release(&list);
}

static void start(struct server *server)
{
    const int fd = mkstemp(path);
    ck_assert_int_ge(fd, 0);
    close(fd);
    write_tokens(-1);
    server_start(server, &(struct server_options){.tokens = path, .cors = "https://a.example"});
}

static void stop(struct server *server)
{
    server_stop(server);
    unlink(path);
}

static void ask(const struct server *server, int sender, const char *line, const char *body,
                struct answer *answer)
{
    char head[400];
    if (sender == NOBODY)
        snprintf(head, sizeof head, "%s HTTP/1.1", line);
    else
        snprintf(head, sizeof head, "%s HTTP/1.1\r\nAuthorization: Bearer %s", line, token[sender]);
    server_ask(server, head, body, answer);
}

static int status_of(const struct server *server, int sender, const char *line, const char *body)
{
    struct answer answer;
    ask(server, sender, line, body, &answer);
    const int status = answer.status;
    answer_release(&answer);
    return status;
}

static void submit(const struct server *server, int sender, char job[80])
{
    struct answer answer;
    ask(server, sender, "POST /v1/jobs", "{\"scene\": \"builtin:spheres\"}", &answer);
    ck_assert_int_eq(answer.status, 202);
    answer_field(&answer, "Location", job, 80);
    answer_release(&answer);
}

/* Replaces the braces of a path template. */
static void fill(const char *template, const char *id, char out[160])
{
    const char *brace = strchr(template, '{'), *rest = brace ? strchr(brace, '}') + 1 : "";
    snprintf(out, 160, "%.*s%s%s", brace ? (int)(brace - template) : (int)strlen(template),
             template, brace ? id : "", rest);
}

/* The scope that a method of a path needs; -1: the table has no such route. */
static int needed(const char *method, const char *template)
{
    const char *other_method, *other_path;
    int scope;
    if (strcmp(method, "HEAD") == 0)
        method = "GET";
    for (int i = 0; pen_http_route(i, &other_method, &other_path, &scope); i++) {
        if (strcmp(method, other_method) == 0 && strcmp(template, other_path) == 0)
            return scope;
    }
    return -1;
}

static void check_answer(const struct server *server, int sender, const char *method,
                         const char *template, const char *job)
{
    struct answer answer;
    char target[160], line[200], field[80];
    const int scope = needed(method, template);
    fill(template, strncmp(template, "/v1/jobs/", 9) == 0 ? job : "room", target);
    snprintf(line, sizeof line, "%s %s", method, target);
    ask(server, sender, line, strcmp(method, "POST") == 0 ? "{" : NULL, &answer);
    const bool known = scope_of[sender] != PEN_SCOPE_NONE;
    if (scope != PEN_SCOPE_NONE && !known) {
        ck_assert_msg(answer.status == 401, "%d: %s: %d", sender, line, answer.status);
        ck_assert_str_ne(answer_field(&answer, "WWW-Authenticate", field, sizeof field), "");
    } else if (scope < 0) {
        ck_assert_msg(answer.status == 405, "%d: %s: %d", sender, line, answer.status);
    } else if ((int)scope_of[sender] < scope) {
        ck_assert_msg(answer.status == 403, "%d: %s: %d", sender, line, answer.status);
        ck_assert(strcmp(method, "HEAD") == 0 || strstr(answer.body, "a token of scope submit"));
    } else {
        ck_assert_msg(answer.status != 401 && answer.status != 403 && answer.status != 405 &&
                          answer.status != 0,
                      "%d: %s: %d", sender, line, answer.status);
    }
    answer_release(&answer);
}

/* The requests name a job that does not exist, and no body is a job, so nothing is changed. */
START_TEST(test_scopes__of_every_route_and_method)
{
    static const char *const methods[] = {"GET", "HEAD", "POST", "DELETE", "PUT", "PATCH"};
    struct server server;
    const char *method, *template;
    int scope;
    start(&server);
    for (int i = 0; pen_http_route(i, &method, &template, &scope); i++) {
        for (int sender = NOBODY; sender < SENDERS; sender++) {
            for (size_t k = 0; k < sizeof methods / sizeof methods[0]; k++)
                check_answer(&server, sender, methods[k], template,
                             "01890a5d-ac96-774b-bcce-b302099a8057");
        }
    }
    ck_assert_int_eq(status_of(&server, NOBODY, "GET /nowhere", NULL), 401);
    ck_assert_int_eq(status_of(&server, STRANGER, "POST /nowhere", "{}"), 401);
    ck_assert_int_eq(status_of(&server, READER, "GET /nowhere", NULL), 404);
    stop(&server);
}
END_TEST

/* Requests without the right change nothing. A client changes only its own jobs; an administrator
 * changes all. */
START_TEST(test_scopes__guard_jobs)
{
    static const int strangers[] = {NOBODY, STRANGER, READER, OTHER};
    struct server server;
    struct answer answer;
    char job[80], cancel[160], delete[160], get[160];
    start(&server);
    submit(&server, SUBMITTER, job);
    snprintf(cancel, sizeof cancel, "POST %s/cancel", job);
    snprintf(delete, sizeof delete, "DELETE %s", job);
    snprintf(get, sizeof get, "GET %s", job);
    for (size_t i = 0; i < sizeof strangers / sizeof strangers[0]; i++) {
        const int status = strangers[i] < READER ? 401 : 403;
        ck_assert_int_eq(status_of(&server, strangers[i], cancel, NULL), status);
        ck_assert_int_eq(status_of(&server, strangers[i], delete, NULL), status);
        if (strangers[i] != OTHER)
            ck_assert_int_eq(
                status_of(&server, strangers[i], "POST /v1/jobs", "{\"scene\": \"builtin:room\"}"),
                status);
    }
    /* The refusal does not wait for the body. */
    const int fd = server_connect(&server);
    client_send(fd, "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n");
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 401);
    answer_release(&answer);
    close(fd);
    ask(&server, READER, get, NULL, &answer);
    ck_assert_ptr_nonnull(strstr(answer.body, "\"queued\""));
    answer_release(&answer);
    ask(&server, READER, "GET /v1/jobs", NULL, &answer);
    ck_assert_ptr_nonnull(strstr(answer.body, job + 9));
    ck_assert_ptr_null(strstr(strstr(answer.body, "\"id\"") + 1, "\"id\""));
    answer_release(&answer);
    ck_assert_int_eq(status_of(&server, SUBMITTER, cancel, NULL), 202);
    ck_assert_int_eq(status_of(&server, OTHER, delete, NULL), 403);
    ck_assert_int_eq(status_of(&server, ADMIN, delete, NULL), 204);
    stop(&server);
}
END_TEST

/* A key refers to a job of its client. */
START_TEST(test_scopes__keys_are_per_client)
{
    static const char line[] = "POST /v1/jobs HTTP/1.1\r\nIdempotency-Key: one\r\n"
                               "Authorization: Bearer %s";
    struct server server;
    struct answer answer[3];
    char head[300], job[3][80];
    start(&server);
    for (int i = 0; i < 3; i++) {
        snprintf(head, sizeof head, line, token[i == 2 ? OTHER : SUBMITTER]);
        server_ask(&server, head, "{\"scene\": \"builtin:spheres\"}", &answer[i]);
        ck_assert_int_eq(answer[i].status, 202);
        answer_field(&answer[i], "Location", job[i], sizeof job[i]);
        answer_release(&answer[i]);
    }
    ck_assert_str_eq(job[0], job[1]);
    ck_assert_str_ne(job[0], job[2]);
    stop(&server);
}
END_TEST

/* A stream ends when its token is removed, and the token is refused. */
START_TEST(test_scopes__removed_tokens_end_their_streams)
{
    struct server server;
    struct answer answer;
    char job[80], text[300];
    int fd[2];
    start(&server);
    submit(&server, SUBMITTER, job);
    for (int i = 0; i < 2; i++) {
        snprintf(text, sizeof text,
                 "GET %s/events HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                 "Authorization: Bearer %s\r\n\r\n",
                 job, token[i ? ADMIN : READER]);
        fd[i] = server_connect(&server);
        client_send(fd[i], text);
        client_first_answered(&fd[i], 1);
    }
    write_tokens(READER);
    ck_assert(client_sees_end(fd[0]));
    ck_assert(!client_has_seen_end(fd[1]));
    ck_assert_int_eq(status_of(&server, READER, "GET /v1/jobs", NULL), 401);
    /* A file that cannot be used leaves the tokens as they are. */
    ck_assert_int_eq(chmod(path, 0644), 0);
    int status = 200;
    for (int i = 0; i < 600 && status == 200; i++) {
        client_pause(50);
        status = status_of(&server, ADMIN, "GET /readyz", NULL);
    }
    ck_assert_int_eq(status, 503);
    ask(&server, NOBODY, "GET /readyz", NULL, &answer);
    ck_assert_ptr_null(strstr(answer.body, path));
    answer_release(&answer);
    ck_assert_int_eq(status_of(&server, ADMIN, "GET /v1/jobs", NULL), 200);
    for (int i = 0; i < 2; i++)
        close(fd[i]);
    stop(&server);
}
END_TEST

START_TEST(test_scopes__of_other_origins)
{
    static const char ask_options[] =
        "OPTIONS /v1/jobs HTTP/1.1\r\nOrigin: %s\r\nAccess-Control-Request-Method: POST";
    struct server server;
    struct answer answer;
    char head[400], field[200];
    start(&server);
    snprintf(head, sizeof head, ask_options, "https://a.example");
    server_ask(&server, head, NULL, &answer);
    ck_assert_int_eq(answer.status, 204);
    ck_assert_str_eq(answer_field(&answer, "Access-Control-Allow-Origin", field, sizeof field),
                     "https://a.example");
    ck_assert_str_eq(answer_field(&answer, "Vary", field, sizeof field), "Origin");
    ck_assert_str_eq(answer_field(&answer, "Access-Control-Allow-Credentials", field, sizeof field),
                     "");
    answer_release(&answer);
    snprintf(head, sizeof head, ask_options, "https://b.example");
    ck_assert_int_eq(server_status(&server, head, NULL), 403);
    snprintf(head, sizeof head, "GET /v1/jobs HTTP/1.1\r\nOrigin: %s\r\nAuthorization: Bearer %s",
             "https://a.example", token[READER]);
    server_ask(&server, head, NULL, &answer);
    ck_assert_int_eq(answer.status, 200);
    ck_assert_str_eq(answer_field(&answer, "Access-Control-Allow-Origin", field, sizeof field),
                     "https://a.example");
    answer_release(&answer);
    snprintf(head, sizeof head, "GET /v1/jobs HTTP/1.1\r\nOrigin: null\r\nAuthorization: Bearer %s",
             token[ADMIN]);
    ck_assert_int_eq(server_status(&server, head, NULL), 403);
    stop(&server);
}
END_TEST

/* A client without a token does not get the reason why the server is not ready, even before the
 * store is open. */
START_TEST(test_scopes__hide_why_the_store_is_not_open)
{
    struct server server;
    struct pen_status st;
    struct answer answer;
    start(&server);
    pen_http_stop(server.http);
    const struct pen_http_options options = {.listen_fd = server.listen_fd,
                                             .store_url = "/dev/null/nowhere.db",
                                             .limits = pen_limits_default(),
                                             .tokens = path};
    server.http = pen_http_start(&options, &st);
    ck_assert_msg(server.http != NULL, "%s", st.msg);
    ck_assert(!pen_http_open(server.http, &options, &st));
    for (int sender = NOBODY; sender < SENDERS; sender++) {
        ask(&server, sender, "GET /readyz", NULL, &answer);
        ck_assert_int_eq(answer.status, 503);
        ck_assert(!strstr(answer.body, "nowhere.db") == (sender <= STRANGER));
        answer_release(&answer);
    }
    stop(&server);
}
END_TEST

PEN_SUITE("scopes", test_scopes__hide_why_the_store_is_not_open,
          test_scopes__of_every_route_and_method, test_scopes__guard_jobs,
          test_scopes__keys_are_per_client, test_scopes__removed_tokens_end_their_streams,
          test_scopes__of_other_origins)

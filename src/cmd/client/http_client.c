/* SPDX-License-Identifier: MIT */
#include "cmd/client/http_client.h"

#include <arpa/inet.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "cmd/client/curl_library.h"
#include "cmd/client/token.h"
#include "cmd/client/transport.h"
#include "cmd/report.h"

/* Larger than any answer of a daemon: a PFM of 64 Mpixel is 768 MiB. */
static const size_t answer_max_bytes = (size_t)1 << 30;

struct pen_client {
    struct pen_curl lib;
    CURL *curl;
    char *base; /* without a slash at its end */
    struct pen_client_token token;
    struct pen_transport transport;
    int64_t retry_ns;
    pen_client_pause_fn *on_pause;
    void *pause_user;
    char error[CURL_ERROR_SIZE];
};

static bool is_loopback(const char *host)
{
    struct in_addr address;
    return strcmp(host, "localhost") == 0 || strcmp(host, "[::1]") == 0 ||
           (inet_pton(AF_INET, host, &address) == 1 && ntohl(address.s_addr) >> 24 == 127);
}

/* Checks the URL. *direct: it names this machine, so a proxy in the environment is ignored. */
static bool check_url(const struct pen_curl *lib, const char *url, bool *direct, bool *tls,
                      struct pen_status *st)
{
    char *host = NULL, *scheme = NULL;
    CURLU *parts = lib->url();
    bool ok = parts && lib->url_set(parts, CURLUPART_URL, url, 0) == CURLUE_OK &&
              lib->url_get(parts, CURLUPART_SCHEME, &scheme, 0) == CURLUE_OK &&
              (strcmp(scheme, "http") == 0 || strcmp(scheme, "https") == 0) &&
              lib->url_get(parts, CURLUPART_HOST, &host, 0) == CURLUE_OK;
    *direct = ok && is_loopback(host);
    *tls = ok && strcmp(scheme, "https") == 0;
    lib->free(host);
    lib->free(scheme);
    lib->url_cleanup(parts);
    return ok || pen_fail(st, PEN_USAGE,
                          "--server: found \"%s\", allowed is http://HOST:PORT or https://…", url);
}

/* Sets the options that all requests share. */
static void set_options(const struct pen_client *client, bool direct)
{
    const struct pen_curl *lib = &client->lib;
    lib->easy_setopt(client->curl, CURLOPT_NOSIGNAL, 1L);
    lib->easy_setopt(client->curl, CURLOPT_ERRORBUFFER, client->error);
    lib->easy_setopt(client->curl, CURLOPT_USERAGENT, "penumbra/" PEN_VERSION);
    lib->easy_setopt(client->curl, CURLOPT_CONNECTTIMEOUT_MS, 5000L);
    lib->easy_setopt(client->curl, CURLOPT_PROTOCOLS_STR, "http,https");
    lib->easy_setopt(client->curl, CURLOPT_FOLLOWLOCATION, 0L);
    lib->easy_setopt(client->curl, CURLOPT_SSL_VERIFYPEER, 1L);
    lib->easy_setopt(client->curl, CURLOPT_SSL_VERIFYHOST, 2L);
    if (client->transport.ca) {
        lib->easy_setopt(client->curl, CURLOPT_CAINFO, client->transport.ca);
        lib->easy_setopt(client->curl, CURLOPT_CAPATH, NULL);
    }
    if (direct)
        lib->easy_setopt(client->curl, CURLOPT_NOPROXY, "*");
}

static bool check_ca(const char *ca, struct pen_status *st)
{
    return !ca || access(ca, R_OK) == 0 ||
           pen_fail(st, PEN_USAGE, "--ca or PENUMBRA_CA: cannot read \"%s\": %s", ca,
                    strerror(errno));
}

/* Fills a new client. */
static bool set_up(struct pen_client *client, const struct pen_remote *remote,
                   struct pen_status *st)
{
    bool direct;
    if (!check_url(&client->lib, remote->server, &direct, &client->transport.tls, st) ||
        !check_ca(remote->ca, st) || !pen_client_token_find(&client->token, remote->token, st))
        return false;
    client->curl = client->lib.easy_init();
    client->base = strdup(remote->server);
    if (!client->curl || !client->base)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    size_t length = strlen(client->base);
    while (length > 0 && client->base[length - 1] == '/')
        client->base[--length] = '\0';
    client->transport.server = client->base;
    client->transport.ca = remote->ca;
    client->retry_ns = (int64_t)(remote->retry_seconds * 1e9);
    set_options(client, direct);
    if (client->token.text.bytes > 0 && !direct && !client->transport.tls && !remote->quiet)
        pen_report_say(stderr,
                       "penumbra: warning: the token is sent unencrypted to %s; https "
                       "keeps it secret",
                       client->base);
    return true;
}

struct pen_client *pen_client_open(const struct pen_remote *remote, struct pen_status *st)
{
    struct pen_curl lib;
    if (!pen_curl_load(&lib, st))
        return NULL;
    struct pen_client *client = calloc(1, sizeof *client);
    if (!client) {
        pen_fail(st, PEN_NO_MEMORY, "out of memory");
        return NULL;
    }
    client->lib = lib;
    if (set_up(client, remote, st))
        return client;
    pen_client_close(client);
    return NULL;
}

void pen_client_close(struct pen_client *client)
{
    if (!client)
        return;
    client->lib.easy_cleanup(client->curl);
    client->lib.global_cleanup();
    free(client->base);
    pen_client_token_release(&client->token);
    free(client);
}

void pen_client_on_pause(struct pen_client *client, pen_client_pause_fn *fn, void *user)
{
    client->on_pause = fn;
    client->pause_user = user;
}

bool pen_client_escape(struct pen_client *client, struct pen_buf *url, const char *text)
{
    char *escaped = client->lib.easy_escape(client->curl, text, 0);
    bool ok = escaped && pen_buf_puts(url, escaped);
    client->lib.free(escaped);
    return ok;
}

void pen_reply_release(struct pen_reply *reply)
{
    pen_buf_release(&reply->body);
}

static size_t on_body(char *data, size_t size, size_t count, void *user)
{
    struct pen_reply *reply = user;
    size_t bytes = size * count;
    if (bytes > answer_max_bytes - reply->body.bytes || !pen_buf_add(&reply->body, data, bytes))
        return 0;
    return bytes;
}

/* Copies the value of a header line if the line has this name. */
static bool header_value(const char *line, size_t bytes, const char *name, char *out,
                         size_t out_bytes)
{
    size_t length = strlen(name);
    if (bytes <= length || strncasecmp(line, name, length) != 0 || line[length] != ':')
        return false;
    const char *from = line + length + 1, *end = line + bytes;
    while (from < end && (*from == ' ' || *from == '\t'))
        from++;
    while (end > from && strchr(" \t\r\n", end[-1]))
        end--;
    size_t value = (size_t)(end - from) < out_bytes ? (size_t)(end - from) : 0;
    memcpy(out, from, value);
    out[value] = '\0';
    return true;
}

static size_t on_header(char *line, size_t size, size_t count, void *user)
{
    struct pen_reply *reply = user;
    size_t bytes = size * count;
    char seconds[16];
    if (header_value(line, bytes, "Retry-After", seconds, sizeof seconds))
        reply->retry_after_s = atoi(seconds);
    else if (!header_value(line, bytes, "ETag", reply->etag, sizeof reply->etag))
        header_value(line, bytes, "Location", reply->location, sizeof reply->location);
    return bytes;
}

static bool add_header(const struct pen_client *client, struct curl_slist **list,
                       const char *format, const char *value)
{
    char *line;
    if (asprintf(&line, format, value) < 0)
        return false;
    struct curl_slist *longer = client->lib.slist_append(*list, line);
    free(line);
    if (longer)
        *list = longer;
    return longer != NULL;
}

static bool make_headers(const struct pen_client *client, const struct pen_request *request,
                         struct curl_slist **list)
{
    bool ok = add_header(client, list, "%s",
                         "Expect:"); /* none: without it the daemon can answer 413 early */
    if (request->body)
        ok = ok && add_header(client, list, "Content-Type: %s", request->type);
    if (request->idempotency_key)
        ok = ok && add_header(client, list, "Idempotency-Key: %s", request->idempotency_key);
    if (request->accept)
        ok = ok && add_header(client, list, "Accept: %s", request->accept);
    if (request->if_none_match)
        ok = ok && add_header(client, list, "If-None-Match: %s", request->if_none_match);
    if (client->token.text.bytes > 0)
        ok = ok && add_header(client, list, "Authorization: Bearer %s",
                              (const char *)client->token.text.data);
    return ok;
}

static void set_request(struct pen_client *client, const struct pen_request *request,
                        struct pen_reply *reply)
{
    const struct pen_curl *lib = &client->lib;
    CURL *curl = client->curl;
    bool get = strcmp(request->method, "GET") == 0;
    bool post = strcmp(request->method, "POST") == 0;
    lib->easy_setopt(curl, CURLOPT_CUSTOMREQUEST, NULL);
    if (get)
        lib->easy_setopt(curl, CURLOPT_HTTPGET, 1L);
    if (post) {
        lib->easy_setopt(curl, CURLOPT_POST, 1L);
        lib->easy_setopt(curl, CURLOPT_POSTFIELDS, request->body ? request->body : "");
        lib->easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)request->body_bytes);
    }
    if (!get && !post) {
        lib->easy_setopt(curl, CURLOPT_HTTPGET, 1L);
        lib->easy_setopt(curl, CURLOPT_CUSTOMREQUEST, request->method);
    }
    /* Gives up after timeout_s without a byte. A long poll is silent while it waits. */
    lib->easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    lib->easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, (long)request->timeout_s);
    lib->easy_setopt(curl, CURLOPT_WRITEFUNCTION, on_body);
    lib->easy_setopt(curl, CURLOPT_WRITEDATA, reply);
    lib->easy_setopt(curl, CURLOPT_HEADERFUNCTION, on_header);
    lib->easy_setopt(curl, CURLOPT_HEADERDATA, reply);
}

/* Makes one attempt. CURLE_OK: *reply has an answer, with any status. */
static CURLcode attempt(struct pen_client *client, const struct pen_request *request,
                        struct pen_reply *reply)
{
    struct curl_slist *headers = NULL;
    char *url = NULL;
    pen_reply_release(reply);
    *reply = (struct pen_reply){0};
    client->error[0] = '\0';
    CURLcode code = CURLE_OUT_OF_MEMORY;
    if (asprintf(&url, "%s%s", client->base, request->path) >= 0 &&
        make_headers(client, request, &headers)) {
        set_request(client, request, reply);
        client->lib.easy_setopt(client->curl, CURLOPT_URL, url);
        client->lib.easy_setopt(client->curl, CURLOPT_HTTPHEADER, headers);
        code = client->lib.easy_perform(client->curl);
        client->lib.easy_getinfo(client->curl, CURLINFO_RESPONSE_CODE, &reply->status);
        client->transport.answered |= code == CURLE_OK;
        client->lib.easy_setopt(client->curl, CURLOPT_HTTPHEADER, NULL);
    }
    client->lib.slist_free_all(headers);
    free(url);
    return code;
}

/* Returns true if another attempt may succeed and does no harm. */
static bool worth_repeating(const struct pen_client *client, CURLcode code,
                            const struct pen_request *request, const struct pen_reply *reply)
{
    if (code == CURLE_OK)
        return reply->status == 503 || reply->status == 429;
    if (code == CURLE_COULDNT_CONNECT || code == CURLE_COULDNT_RESOLVE_HOST)
        return true;
    return request->repeatable && pen_transport_may_pass(&client->transport, code);
}

static void sleep_ns(int64_t ns)
{
    struct timespec pause = {.tv_sec = (time_t)(ns / 1000000000), .tv_nsec = ns % 1000000000};
    while (nanosleep(&pause, &pause) != 0)
        ;
}

static CURLcode attempt_until(struct pen_client *client, const struct pen_request *request,
                              struct pen_reply *reply)
{
    const int64_t second = 1000000000;
    int64_t give_up = pen_clock_ns() + client->retry_ns, pause = second / 20;
    for (;;) {
        CURLcode code = attempt(client, request, reply);
        if (!worth_repeating(client, code, request, reply))
            return code;
        int64_t wait =
            code == CURLE_OK && reply->retry_after_s > 0 ? reply->retry_after_s * second : pause;
        if (pen_clock_ns() + wait > give_up)
            return code;
        if (client->on_pause)
            client->on_pause(client->pause_user, code == CURLE_OK ? "the daemon is not ready"
                                                                  : "the daemon does not answer");
        sleep_ns(wait);
        pause = pause * 2 < 2 * second ? pause * 2 : 2 * second;
    }
}

/* The user data of on_stream. */
struct stream {
    const struct pen_client *client;
    struct pen_sse *sse;
};

/* Passes the bytes to the reader of events. Returning less than size * count makes libcurl stop.
 * This ends every answer that is no stream of events. */
static size_t on_stream(char *data, size_t size, size_t count, void *user)
{
    struct stream *stream = user;
    const struct pen_client *client = stream->client;
    const char *type = NULL;
    long status = 0;
    client->lib.easy_getinfo(client->curl, CURLINFO_RESPONSE_CODE, &status);
    client->lib.easy_getinfo(client->curl, CURLINFO_CONTENT_TYPE, &type);
    if (status != 200 || !type || strncmp(type, "text/event-stream", 17) != 0)
        return 0;
    return pen_sse_feed(stream->sse, data, size * count) ? size * count : 0;
}

bool pen_client_events(struct pen_client *client, const char *path, struct pen_sse *sse,
                       int silence_s)
{
    struct pen_request request = {.method = "GET", .path = path, .timeout_s = silence_s};
    struct pen_reply reply = {0};
    struct stream stream = {.client = client, .sse = sse};
    struct curl_slist *headers = NULL;
    char *url = NULL;
    CURLcode code = CURLE_OUT_OF_MEMORY;
    if (asprintf(&url, "%s%s", client->base, path) >= 0 &&
        make_headers(client, &request, &headers) &&
        (!sse->last_id[0] || add_header(client, &headers, "Last-Event-ID: %s", sse->last_id))) {
        set_request(client, &request, &reply);
        client->lib.easy_setopt(client->curl, CURLOPT_WRITEFUNCTION, on_stream);
        client->lib.easy_setopt(client->curl, CURLOPT_WRITEDATA, &stream);
        client->lib.easy_setopt(client->curl, CURLOPT_URL, url);
        client->lib.easy_setopt(client->curl, CURLOPT_HTTPHEADER, headers);
        code = client->lib.easy_perform(client->curl);
        client->lib.easy_setopt(client->curl, CURLOPT_HTTPHEADER, NULL);
    }
    client->lib.slist_free_all(headers);
    free(url);
    return code == CURLE_OK;
}

static void add_error(struct pen_errors *errors, enum pen_code code, const json_t *item,
                      const char *detail)
{
    struct pen_status st;
    const json_t *line = json_object_get(item, "line");
    const char *pointer = json_string_value(json_object_get(item, "pointer"));
    if (line)
        pen_fail_line(&st, code, (int)json_integer_value(line),
                      (int)json_integer_value(json_object_get(item, "column")), "%s", detail);
    else
        pen_fail_at(&st, code, pointer ? pointer : "", "%s", detail);
    pen_errors_add(errors, &st);
}

/* Returns the error code of an HTTP status, for answers whose body has none. */
static enum pen_code code_of_http(long status)
{
    for (int code = PEN_USAGE; code < PEN_CODE_COUNT; code++) {
        if (pen_code_http((enum pen_code)code) == status && code != PEN_SYNTAX)
            return (enum pen_code)code;
    }
    return PEN_NETWORK;
}

enum pen_code pen_problem_code(const json_t *problem, long status)
{
    const char *type = json_string_value(json_object_get(problem, "type"));
    const char *name = type && strrchr(type, '/') ? strrchr(type, '/') + 1 : type;
    const char *colon = name ? strrchr(name, ':') : NULL;
    name = colon ? colon + 1 : name;
    enum pen_code code = name ? pen_code_of_name(name) : PEN_INTERNAL;
    if (code == PEN_INTERNAL && status != 500)
        return code_of_http(status);
    return code;
}

static void read_problem(const struct pen_reply *reply, struct pen_errors *errors)
{
    json_t *problem = json_loadb((const char *)reply->body.data, reply->body.bytes, 0, NULL);
    enum pen_code code = pen_problem_code(problem, reply->status);
    const json_t *list = json_object_get(problem, "errors"), *item;
    const char *title = json_string_value(json_object_get(problem, "title"));
    const char *detail = json_string_value(json_object_get(problem, "detail"));
    size_t i;
    json_array_foreach(list, i, item)
    {
        const char *each = json_string_value(json_object_get(item, "detail"));
        add_error(errors, code, item, each ? each : "");
    }
    struct pen_status st;
    if (errors->count == 0) {
        if (detail)
            pen_fail(&st, code, "%s", detail);
        else
            pen_fail(&st, code, "the daemon answered %ld%s%s", reply->status, title ? ": " : "",
                     title ? title : "");
        pen_errors_add(errors, &st);
    }
    json_decref(problem);
}

/* Makes *errors from an answer that is no success. */
static void read_refusal(const struct pen_client *client, const struct pen_reply *reply,
                         struct pen_errors *errors)
{
    struct pen_status st;
    if (reply->status >= 400) {
        read_problem(reply, errors);
        return;
    }
    pen_fail(&st, PEN_NETWORK,
             "%s: the server redirects to \"%s\"; if the daemon is there, give that as --server",
             client->base, reply->location);
    pen_errors_add(errors, &st);
}

bool pen_client_send(struct pen_client *client, const struct pen_request *request,
                     struct pen_reply *reply, struct pen_errors *errors)
{
    struct pen_status st;
    *errors = (struct pen_errors){0};
    CURLcode code = attempt_until(client, request, reply);
    if (code == CURLE_OK && (reply->status == 304 || reply->status / 100 == 2))
        return true;
    if (code == CURLE_OK) {
        read_refusal(client, reply, errors);
        if (reply->status == 401 || reply->status == 403)
            pen_client_token_explain(&client->token, &errors->item[0]);
        return false;
    }
    pen_transport_fail(&client->transport, code,
                       client->error[0] ? client->error : client->lib.easy_strerror(code), &st);
    pen_errors_add(errors, &st);
    return false;
}

bool pen_client_json(struct pen_client *client, const struct pen_request *request,
                     struct pen_reply *reply, json_t **json, struct pen_errors *errors)
{
    *json = NULL;
    if (!pen_client_send(client, request, reply, errors))
        return false;
    if (reply->status == 304 || reply->status == 204)
        return true;
    json_error_t error;
    *json = json_loadb((const char *)reply->body.data, reply->body.bytes, 0, &error);
    if (*json)
        return true;
    struct pen_status st;
    pen_fail(&st, PEN_NETWORK, "%s%s: the answer is not JSON (%s): is that a Penumbra daemon?",
             client->base, request->path, error.text);
    pen_errors_add(errors, &st);
    return false;
}

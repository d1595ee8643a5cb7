/* SPDX-License-Identifier: MIT */
#include "load/requests.h"

#include <string.h>

#include "http/server.h"
#include "load/cases.h"

#define BODY_JOB "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 32, \"height\": 24}}"
/* The same, compressed. */
#define BODY_GZIP                                                                                  \
    "\x1f\x8b\x08\x00\x00\x00\x00\x00\x02\x03\xab\x56\x2a\x4e\x4e\xcd\x4b\x55\xb2\x52\x50\x4a"     \
    "\x2a\xcd\xcc\x29\xc9\xcc\xb3\x2a\x2e\xc8\x48\x2d\x4a\x2d\x56\xd2\x51\x50\x2a\x4a\xcd\x4b"     \
    "\x49\x2d\x02\x4a\x56\x2b\x95\x67\xa6\x94\x64\x00\x59\xc6\x46\x40\xf1\x8c\xd4\xcc\xf4\x8c"     \
    "\x12\x20\xcf\xc8\xa4\xb6\x16\x00\xa3\x18\x5c\x94\x43\x00\x00\x00"
#define PAIR(text)                                                                                 \
    {                                                                                              \
        text, sizeof text - 1                                                                      \
    }
struct piece {
    const char *text;
    size_t bytes;
};

static const struct piece bodies[] = {
    PAIR("\r\n"),
    PAIR("Content-Length: 67\r\nContent-Type: application/json\r\n\r\n" BODY_JOB),
    PAIR("Content-Length: 82\r\nContent-Encoding: gzip\r\n\r\n" BODY_GZIP),
    PAIR("Transfer-Encoding: chunked\r\n\r\n43\r\n" BODY_JOB "\r\n0\r\n\r\n"),
    PAIR("Content-Length: 71\r\nContent-Type: application/xml\r\nExpect: 100-continue\r\n\r\n"
         "<scene version=\"2.1.0\"><shape type=\"sphere\"/><sensor type=\"x\"/></scene>"),
};
static const char *const queries[] = {"?wait=1",
                                      "?limit=5",
                                      "?view=a",
                                      "?format=pfm&layer=depth",
                                      "?label=a:b",
                                      "?name=%41",
                                      "?state=succeeded&cursor=AAAA"};
static const char *const fields[] = {"Accept-Encoding: gzip, br;q=0.5\r\n",
                                     "If-None-Match: \"a\", W/\"b\", *\r\n",
                                     "Range: bytes=0-99\r\n",
                                     "Range: bytes=-5, 7-\r\nIf-Range: \"a\"\r\n",
                                     "Last-Event-ID: 7\r\n",
                                     "Origin: http://localhost\r\nReferer: /\r\n",
                                     "Idempotency-Key: a-key\r\n",
                                     "X-Forwarded-For: 10.0.0.1, 10.0.0.2\r\n",
                                     "Accept: image/png;q=0.1, */*\r\n",
                                     "Connection: keep-alive, close\r\n",
                                     "Authorization: Basic YTpi\r\n"};
static const struct piece words[] = {PAIR("\r\n"),
                                     PAIR("\n"),
                                     PAIR("\r"),
                                     PAIR("\0"),
                                     PAIR(":"),
                                     PAIR(" "),
                                     PAIR("\t"),
                                     PAIR(";"),
                                     PAIR("%00"),
                                     PAIR("%"),
                                     PAIR("?"),
                                     PAIR("&"),
                                     PAIR("="),
                                     PAIR("0"),
                                     PAIR("ffffffffffffffff"),
                                     PAIR("HTTP/1.1"),
                                     PAIR("\xff"),
                                     PAIR("Bearer "),
                                     PAIR("pen_"),
                                     PAIR("{\"a\":["),
                                     PAIR("Content-Length: "),
                                     PAIR("Transfer-Encoding: chunked\r\n"),
                                     PAIR("Expect: 100-continue\r\n"),
                                     PAIR("Cookie: a=\"b\"; c"),
                                     PAIR("/v1/jobs/x/events"),
                                     PAIR("Connection: close\r\n")};
#define COUNT(list) ((uint32_t)(sizeof list / sizeof list[0]))

static void add(struct load_text *text, const char *bytes, size_t count)
{
    size_t room = LOAD_TEXT_BYTES - text->bytes;
    count = count < room ? count : room;
    memcpy(text->data + text->bytes, bytes, count);
    text->bytes += count;
}

static void add_string(struct load_text *text, const char *string)
{
    add(text, string, strlen(string));
}

/* A right request for a route of the table. */
static void add_route(struct load_text *text, const struct load_names *names, struct random *random)
{
    const char *method, *path;
    int count = 0, scope;
    while (pen_http_route(count, &method, &path, &scope))
        count++;
    pen_http_route((int)random_below(random, (uint32_t)count), &method, &path, &scope);
    const char *name = strchr(path, '{'), *end = strchr(path, '}');
    const struct piece *body = &bodies[*method == 'P' ? random_below(random, COUNT(bodies)) : 0];
    add_string(text, method);
    add_string(text, " ");
    add(text, path, name ? (size_t)(name - path) : strlen(path));
    add_string(text, !name                                             ? ""
                     : strncmp(name, "{id}", 4) == 0 && *method != 'D' ? names->job
                                                                       : "spheres");
    add_string(text, end ? end + 1 : "");
    if (random_below(random, 3) == 0)
        add_string(text, queries[random_below(random, COUNT(queries))]);
    add_string(text, " HTTP/1.1\r\nHost: localhost\r\n");
    if (random_below(random, 4)) {
        add_string(text, "Authorization: Bearer ");
        add_string(text, names->token);
        add_string(text, "\r\n");
    }
    for (uint32_t i = random_below(random, 3); i > 0; i--)
        add_string(text, fields[random_below(random, COUNT(fields))]);
    add(text, body->text, body->bytes);
}

/* Puts bytes into the text. */
static void insert(struct load_text *text, size_t at, const char *bytes, size_t count)
{
    if (text->bytes + count > LOAD_TEXT_BYTES)
        return;
    memmove(text->data + at + count, text->data + at, text->bytes - at);
    memcpy(text->data + at, bytes, count);
    text->bytes += count;
}

/* Changes the text in up to six places, often in none: another byte, a word more, some bytes less,
 * a part twice. */
static void change(struct load_text *text, struct random *random)
{
    char part[LOAD_TEXT_BYTES];
    for (uint32_t i = random_below(random, 1 + random_below(random, 7)); i > 0 && text->bytes > 0;
         i--) {
        size_t at = random_below(random, (uint32_t)text->bytes), left = text->bytes - at;
        const struct piece *word = &words[random_below(random, COUNT(words))];
        size_t some = 1 + random_below(random, 20);
        switch (random_below(random, 4)) {
        case 0:
            text->data[at] = (char)random_below(random, 256);
            break;
        case 1:
            insert(text, at, word->text, word->bytes);
            break;
        case 2:
            some = some < left ? some : left;
            memmove(text->data + at, text->data + at + some, left - some);
            text->bytes -= some;
            break;
        default:
            some = random_below(random, (uint32_t)left);
            memcpy(part, text->data + at, some);
            insert(text, at, part, some);
        }
    }
}

void load_mutate(struct load_text *all, const struct load_names *names, struct random *random)
{
    static _Thread_local struct load_text text;
    all->bytes = 0;
    for (uint32_t i = 1 + random_below(random, 4); i > 0; i--) {
        const struct load_case *item = &load_cases[random_below(random, (uint32_t)load_case_count)];
        text.bytes = 0;
        if (random_below(random, 3) || item->filler)
            add_route(&text, names, random);
        else
            add(&text, item->text, item->bytes);
        change(&text, random);
        add(all, text.data, text.bytes);
    }
}

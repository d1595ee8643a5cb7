/* SPDX-License-Identifier: MIT */
/* Reading the head of a request, and the trailer of a body in chunks. */
#include <string.h>
#include <strings.h>

#include "http/wire.h"

enum pen_head_found pen_head_find(const char *text, size_t bytes, struct pen_head_scan *scan,
                                  size_t *head_bytes)
{
    while (scan->at < bytes) {
        const char *end = memchr(text + scan->at, '\n', bytes - scan->at);
        if (!end) {
            scan->at = bytes;
            break;
        }
        size_t at = (size_t)(end - text);
        if (at == scan->line || text[at - 1] != '\r')
            return PEN_HEAD_BAD;
        bool empty = at == scan->line + 1;
        scan->line = scan->at = at + 1;
        if (empty && scan->begun) {
            *head_bytes = at + 1;
            return PEN_HEAD_WHOLE;
        }
        scan->begun = scan->begun || !empty;
    }
    return PEN_HEAD_PART;
}

bool pen_head_announces_body(const char *text, size_t bytes)
{
    static const char *const framing[] = {"Content-Length", "Transfer-Encoding"};
    const char *end = text + bytes;
    for (const char *line = text; line < end;
         line = (const char *)memchr(line, '\n', (size_t)(end - line)) + 1) {
        for (int i = 0; i < 2; i++) {
            const size_t length = strlen(framing[i]);
            if ((size_t)(end - line) > length && strncasecmp(line, framing[i], length) == 0)
                return true;
        }
    }
    return false;
}

/* Whether a byte may be in a method or in the name of a field. */
static bool is_token(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (c && strchr("!#$%&'*+-.^_`|~", c));
}

static size_t token_length(const char *text)
{
    size_t length = 0;
    while (is_token(text[length]))
        length++;
    return length;
}

/* The next line of a head, without its line end, as a string; its length is *bytes. */
static char *next_line(char **at, const char *end, size_t *bytes)
{
    char *line = *at;
    char *newline = memchr(line, '\n', (size_t)(end - line));
    *bytes = (size_t)(newline - line) - 1;
    line[*bytes] = '\0';
    *at = newline + 1;
    return line;
}

/* Finds a control character other than a tab, a zero byte included. */
static bool has_control(const char *text, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) {
        unsigned char c = (unsigned char)text[i];
        if ((c < ' ' && c != '\t') || c == 127)
            return true;
    }
    return false;
}

static int refuse(struct pen_status *st, const char *why)
{
    pen_fail(st, PEN_SYNTAX, "malformed HTTP: %s", why);
    return 400;
}

static int parse_version(const char *text, struct pen_head *head, struct pen_status *st)
{
    if (strncmp(text, "HTTP/", 5) != 0 || text[5] < '0' || text[5] > '9' || text[6] != '.' ||
        text[7] < '0' || text[7] > '9' || text[8] != '\0')
        return refuse(st, "the request line does not end in a version such as HTTP/1.1");
    head->minor = text[7] > '0';
    if (text[5] == '1')
        return 0;
    pen_fail(st, PEN_SYNTAX, "the version is %s; HTTP/1.1 and HTTP/1.0 are supported", text);
    return 505;
}

static int parse_request_line(char *line, struct pen_head *head, struct pen_status *st)
{
    size_t method = token_length(line);
    if (method == 0 || line[method] != ' ')
        return refuse(st, "the request line does not begin with a method and one space");
    line[method] = '\0';
    char *target = line + method + 1;
    size_t length = strcspn(target, " \t");
    if (length == 0 || target[length] != ' ')
        return refuse(st, "the request line is not a method, a target and a version, with one "
                          "space between them");
    target[length] = '\0';
    head->method = line;
    head->target = target;
    return parse_version(target + length + 1, head, st);
}

static int parse_field(char *line, size_t bytes, struct pen_head *head, struct pen_status *st)
{
    if (*line == ' ' || *line == '\t')
        return refuse(st, "a header field is folded into a second line");
    size_t name = token_length(line);
    if (name == 0 || line[name] != ':')
        return refuse(st, line[name] == ' ' || line[name] == '\t'
                              ? "there is a space between a field's name and its colon"
                              : "a header line is not a name, a colon and a value");
    if (head->field_count == PEN_HEAD_FIELDS) {
        pen_fail(st, PEN_TOO_LARGE, "there are more than %d header fields", PEN_HEAD_FIELDS);
        return 431;
    }
    char *value = line + name + 1;
    value += strspn(value, " \t");
    for (char *end = line + bytes; end > value && (end[-1] == ' ' || end[-1] == '\t'); end--)
        end[-1] = '\0';
    line[name] = '\0';
    head->field[head->field_count++] = (struct pen_head_field){.name = line, .value = value};
    return 0;
}

/* Reads the fields of a head or trailer, up to the empty line at its end. */
static int parse_fields(char *text, const char *end, struct pen_head *head, struct pen_status *st)
{
    size_t length;
    int status = 0;
    while (status == 0) {
        char *line = next_line(&text, end, &length);
        if (length == 0)
            break;
        if (has_control(line, length))
            return refuse(st, "a header field has a control character");
        status = parse_field(line, length, head, st);
    }
    return status;
}

int pen_head_parse(char *text, size_t bytes, struct pen_head *head, struct pen_status *st)
{
    const char *end = text + bytes;
    size_t length;
    char *line;
    head->field_count = 0;
    do
        line = next_line(&text, end, &length);
    while (length == 0);
    if (has_control(line, length))
        return refuse(st, "the request line has a control character");
    int status = parse_request_line(line, head, st);
    return status ? status : parse_fields(text, end, head, st);
}

int pen_trailer_check(const char *text, size_t bytes, struct pen_status *st)
{
    static const char *const framing[] = {"Content-Length", "Transfer-Encoding"};
    char copy[PEN_TRAILER_BYTES];
    struct pen_head head = {.field_count = 0};
    memcpy(copy, text, bytes);
    int status = parse_fields(copy, copy + bytes, &head, st);
    for (int i = 0; status == 0 && i < 2 * head.field_count; i++) {
        if (strcasecmp(head.field[i / 2].name, framing[i % 2]) == 0)
            status = refuse(st, "a field after the body says how long the body is");
    }
    return status;
}

bool pen_list_has_token(const char *list, const char *token)
{
    size_t length = strlen(token);
    for (const char *at = list; *at;) {
        at += strspn(at, ", \t");
        size_t item = strcspn(at, ", \t");
        if (item == length && strncasecmp(at, token, length) == 0)
            return true;
        at += strcspn(at, ",");
    }
    return false;
}

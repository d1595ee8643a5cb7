/* SPDX-License-Identifier: MIT */
/* A parser for RFC 8259, without extensions. A leading byte-order mark is skipped, as its section
 * 8.1 allows. The values are jansson's. Its parser is not used because jansson 2.14
 *  - ends the process by an assertion if its token buffer cannot grow;
 *  - reports an error where the token ends, not where it begins;
 *  - reads either all integers as reals or none, so not only those that exceed 64 bits.
 * This parser makes one pass and recurses once per level of nesting. */
#include <string.h>

#include "base/buf.h"
#include "base/utf8.h"
#include "io/error/place.h"
#include "io/error/text.h"
#include "io/json/memory.h"
#include "io/json/number.h"
#include "io/json/syntax_error.h"
#include "io/json/token.h"
#include "io/scene_json.h"

/* The most levels for any limits, because each takes part of the thread's stack. */
enum { NESTING_MAX = 1000 };

enum { STRINGS = 64 };

struct parser {
    struct pen_json_text json;
    size_t at;
    int depth, nesting;
    size_t bytes_left;      /* memory that further values may take */
    size_t limit;           /* memory that all values together may take */
    struct pen_buf scratch; /* the string being read */
    struct pen_json_numbers numbers;
    json_t *strings[STRINGS]; /* of recently made values, by a hash; NULL: none yet */
    struct pen_status *st;
};

static json_t *parse_value(struct parser *p, const struct pen_place *place);

static bool no_memory(struct parser *p)
{
    return pen_fail(p->st, PEN_NO_MEMORY, "the document does not fit into memory");
}

/* Reserves the memory of a value before it is made. Fails if that exceeds the limit. */
static bool reserve(struct parser *p, size_t bytes)
{
    if (bytes > p->bytes_left)
        return pen_fail(p->st, PEN_TOO_LARGE,
                        "the document's values take more than %zu bytes of memory, which is what "
                        "is allowed",
                        p->limit);
    p->bytes_left -= bytes;
    return true;
}

/* Returns the value; reports NULL as out of memory. */
static json_t *check_memory(struct parser *p, json_t *value)
{
    if (!value)
        no_memory(p);
    return value;
}

/* Moves `at` to the next character that is not white space and returns it; '\0' at the end. */
static char skip_space(struct parser *p)
{
    for (; p->at < p->json.bytes; p->at++) {
        char c = p->json.text[p->at];
        if (c != ' ' && c != '\t' && c != '\n' && c != '\r')
            return c;
    }
    return '\0';
}

/* The value of the four hexadecimal digits after the "\u" at `offset`, or -1. */
static int hex4(const struct parser *p, size_t offset)
{
    int code = 0;
    for (size_t i = offset + 2; i < offset + 6; i++) {
        char c = i < p->json.bytes ? p->json.text[i] : '\0';
        int digit = c >= '0' && c <= '9'   ? c - '0'
                    : c >= 'a' && c <= 'f' ? c - 'a' + 10
                    : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                           : -1;
        if (digit < 0)
            return -1;
        code = code * 16 + digit;
    }
    return code;
}

static void add_character(struct parser *p, int code)
{
    char utf8[4];
    pen_buf_add(&p->scratch, utf8, pen_utf8_encode((unsigned)code, utf8));
}

/* Reads "\uXXXX" at `at`, or two of them that are the surrogates of one character. */
static bool read_unicode(struct parser *p)
{
    size_t start = p->at;
    int code = hex4(p, start);
    p->at += 6;
    if (code < 0)
        return pen_json_error(&p->json, start, p->st, "\\u must be followed by 4 hex digits");
    if (code == 0)
        return pen_json_error(&p->json, start, p->st,
                              "a string must not hold the character U+0000");
    if (code >= 0xD800 && code < 0xDC00) {
        bool escape = p->at + 1 < p->json.bytes && p->json.text[p->at] == '\\' &&
                      p->json.text[p->at + 1] == 'u';
        int low = escape ? hex4(p, p->at) : -1;
        if (low < 0xDC00 || low > 0xDFFF)
            return pen_json_error(&p->json, start, p->st,
                                  "half a character: surrogates come in pairs");
        code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
        p->at += 6;
    } else if (code >= 0xDC00 && code < 0xE000) {
        return pen_json_error(&p->json, start, p->st, "half a character: surrogates come in pairs");
    }
    add_character(p, code);
    return true;
}

static bool read_escape(struct parser *p)
{
    static const char names[] = "\"\\/bfnrt", values[] = "\"\\/\b\f\n\r\t";
    char c = p->at + 1 < p->json.bytes ? p->json.text[p->at + 1] : '\0';
    const char *name = c ? strchr(names, c) : NULL;
    if (c == 'u')
        return read_unicode(p);
    if (!name)
        return pen_json_error(&p->json, p->at, p->st,
                              "a backslash must be followed by one of \" \\ / b f n r t u");
    pen_buf_add(&p->scratch, &values[name - names], 1);
    p->at += 2;
    return true;
}

/* Reads one character, escaped or not, of a string. */
static bool read_character(struct parser *p)
{
    const char *s = p->json.text + p->at;
    size_t length = pen_utf8_char(s, p->json.bytes - p->at);
    if (*s == '\\')
        return read_escape(p);
    if (length == 0)
        return pen_json_error(&p->json, p->at, p->st, "byte 0x%02x is not UTF-8",
                              (unsigned char)*s);
    if (*s == '\n')
        return pen_json_error(&p->json, p->at, p->st,
                              "a string must end on the line where it begins");
    if ((unsigned char)*s < 0x20)
        return pen_json_error(&p->json, p->at, p->st,
                              "a string must not hold a control character: write \\t, \\n or "
                              "\\u00XX");
    pen_buf_add(&p->scratch, s, length);
    p->at += length;
    return true;
}

/* Reads the characters from `at` on that need no decoding and take one byte each. */
static void read_plain(struct parser *p)
{
    size_t start = p->at;
    while (p->at < p->json.bytes) {
        const unsigned char c = (unsigned char)p->json.text[p->at];
        if (c < 0x20 || c >= 0x80 || c == '"' || c == '\\')
            break;
        p->at++;
    }
    pen_buf_add(&p->scratch, p->json.text + start, p->at - start);
}

/* Reads the string that opens at `at` into the scratch buffer. */
static bool read_string(struct parser *p)
{
    size_t start = p->at++;
    p->scratch.bytes = 0;
    read_plain(p);
    while (p->at < p->json.bytes && p->json.text[p->at] != '"') {
        if (!read_character(p))
            return false;
        read_plain(p);
    }
    if (p->at >= p->json.bytes)
        return pen_json_error(&p->json, start, p->st, "the string that begins here does not end");
    p->at++;
    if (p->scratch.failed)
        no_memory(p);
    return !p->scratch.failed;
}

static json_t *parse_number(struct parser *p, size_t end, const struct pen_json_decimal *decimal)
{
    size_t start = p->at;
    json_t *number;
    p->at = end;
    if (!reserve(p, PEN_JSON_NUMBER_BYTES))
        return NULL;
    if (pen_json_number(&p->numbers, p->json.text + start, end - start, decimal, &number))
        return check_memory(p, number);
    pen_json_error_token(&p->json, start, p->st,
                         "is too large for a number: they reach to about 1.8e308");
    return NULL;
}

static json_t *parse_word(struct parser *p)
{
    const char *word = p->json.text + p->at;
    struct pen_json_decimal decimal;
    size_t end = pen_json_scan_number(p->json.text, p->at, p->json.bytes, &decimal);
    if (end > p->at && (end == p->json.bytes || pen_json_is_delimiter(p->json.text[end])))
        return parse_number(p, end, &decimal);
    end = pen_json_word_end(&p->json, p->at);
    size_t bytes = end - p->at;
    json_t *literal = bytes == 4 && memcmp(word, "true", 4) == 0    ? json_true()
                      : bytes == 5 && memcmp(word, "false", 5) == 0 ? json_false()
                      : bytes == 4 && memcmp(word, "null", 4) == 0  ? json_null()
                                                                    : NULL;
    if (literal)
        p->at = end;
    else
        pen_json_error_expected(&p->json, p->at, p->st, "a value must stand here");
    return literal;
}

/* Reads the comma or the closing bracket after an element. Returns true after a comma: then the
 * next element follows. *closed is set after the bracket. */
static bool next_element(struct parser *p, char closing, const char *expected, bool *closed)
{
    char c = skip_space(p);
    size_t comma = p->at;
    *closed = c == closing && p->at < p->json.bytes;
    if (*closed) {
        p->at++;
        return false;
    }
    if (c != ',')
        return pen_json_error_expected(&p->json, p->at, p->st, expected);
    p->at++;
    c = skip_space(p);
    if (c == ']' || c == '}')
        return pen_json_error(&p->json, comma, p->st,
                              "a comma must be followed by something, found a closing bracket");
    return true;
}

static bool parse_element(struct parser *p, const struct pen_place *place, json_t *array)
{
    struct pen_place at = pen_place_index(place, json_array_size(array));
    json_t *value = reserve(p, PEN_JSON_ELEMENT_BYTES) ? parse_value(p, &at) : NULL;
    if (!value)
        return false;
    return json_array_append_new(array, value) == 0 || no_memory(p);
}

static bool parse_elements(struct parser *p, const struct pen_place *place, json_t *array)
{
    bool closed = false;
    if (skip_space(p) == ']') {
        p->at++;
        return true;
    }
    do {
        if (!parse_element(p, place, array))
            return false;
    } while (next_element(p, ']', "a comma or ] must follow an element of an array", &closed));
    return closed;
}

/* Reads a key and the colon after it. Adds the member with the value null, to be replaced, so that
 * the object keeps the key while the value is read. Returns jansson's iterator at the member, or
 * NULL. */
static void *parse_key(struct parser *p, json_t *object)
{
    if (skip_space(p) != '"') {
        pen_json_error_expected(&p->json, p->at, p->st, "a key in double quotes must stand here");
        return NULL;
    }
    size_t start = p->at, members = json_object_size(object);
    if (!read_string(p) || !reserve(p, PEN_JSON_MEMBER_BYTES + p->scratch.bytes))
        return NULL;
    const char *key = (const char *)p->scratch.data;
    if (json_object_set_new_nocheck(object, key, json_null()) != 0) {
        no_memory(p);
        return NULL;
    }
    if (json_object_size(object) == members) {
        pen_json_error(&p->json, start, p->st, "duplicate key %s: this object has it already",
                       pen_text_quote(key).text);
        return NULL;
    }
    if (skip_space(p) != ':') {
        pen_json_error_expected(&p->json, p->at, p->st, "a colon must follow a key");
        return NULL;
    }
    p->at++;
    return json_object_iter_at(object, key);
}

static bool parse_member(struct parser *p, const struct pen_place *place, json_t *object)
{
    void *member = parse_key(p, object);
    if (!member)
        return false;
    struct pen_place at = pen_place_key(place, json_object_iter_key(member));
    json_t *value = parse_value(p, &at);
    return value && json_object_iter_set_new(object, member, value) == 0;
}

static bool parse_members(struct parser *p, const struct pen_place *place, json_t *object)
{
    bool closed = false;
    if (skip_space(p) == '}') {
        p->at++;
        return true;
    }
    do {
        if (!parse_member(p, place, object))
            return false;
    } while (next_element(p, '}', "a comma or } must follow a member of an object", &closed));
    return closed;
}

static json_t *parse_container(struct parser *p, const struct pen_place *place, bool object)
{
    if (p->depth >= p->nesting) {
        char at[2 * PEN_AT_BYTES];
        pen_place_pointer(place, "", at, sizeof at);
        pen_fail_at(p->st, PEN_INVALID, at, "nested deeper than the %d levels allowed", p->nesting);
        return NULL;
    }
    if (!reserve(p, object ? PEN_JSON_OBJECT_BYTES : PEN_JSON_ARRAY_BYTES))
        return NULL;
    json_t *value = check_memory(p, object ? json_object() : json_array());
    if (!value)
        return NULL;
    p->at++;
    p->depth++;
    if (object ? parse_members(p, place, value) : parse_elements(p, place, value)) {
        p->depth--;
        return value;
    }
    json_decref(value);
    return NULL;
}

/* The value of the string that has been read. As with numbers, a repeated string is one value:
 * among thousands of objects, few differ in type and material. */
static json_t *make_string(struct parser *p)
{
    const char *text = (const char *)p->scratch.data;
    size_t bytes = p->scratch.bytes, hash = bytes;
    for (size_t i = 0; i < bytes; i++)
        hash = hash * 31 + (unsigned char)text[i];
    json_t **recent = &p->strings[hash % STRINGS];
    if (*recent && json_string_length(*recent) == bytes &&
        memcmp(json_string_value(*recent), text, bytes) == 0)
        return json_incref(*recent);
    json_t *made = check_memory(p, json_stringn_nocheck(text, bytes));
    if (made) {
        json_decref(*recent);
        *recent = json_incref(made);
    }
    return made;
}

static json_t *parse_value(struct parser *p, const struct pen_place *place)
{
    char c = skip_space(p);
    if (c == '{' || c == '[')
        return parse_container(p, place, c == '{');
    if (c != '"')
        return parse_word(p);
    if (!read_string(p) || !reserve(p, PEN_JSON_STRING_BYTES + p->scratch.bytes))
        return NULL;
    return make_string(p);
}

static json_t *parse_document(struct parser *p)
{
    const struct pen_place root = {0};
    if (p->json.bytes >= 3 && memcmp(p->json.text, "\xEF\xBB\xBF", 3) == 0)
        p->at = 3; /* a byte-order mark, which editors write at the start */
    skip_space(p);
    if (p->at == p->json.bytes) {
        pen_json_error(&p->json, 0, p->st, "the document is empty");
        return NULL;
    }
    json_t *document = parse_value(p, &root);
    skip_space(p);
    if (!document || p->at == p->json.bytes)
        return document;
    pen_json_error_expected(&p->json, p->at, p->st, "nothing may follow the end of the document");
    json_decref(document);
    return NULL;
}

/* Whether the number of open brackets exceeds the nesting allowed somewhere, even if the text is
 * otherwise malformed. */
static bool is_too_deep(const struct parser *p)
{
    int depth = 0;
    for (size_t i = 0; i < p->json.bytes; i++) {
        char c = p->json.text[i];
        if (c == '"')
            i = pen_json_string_end(&p->json, i) - 1;
        else if (c == '[' || c == '{')
            depth++;
        else if ((c == ']' || c == '}') && depth > 0)
            depth--;
        if (depth > p->nesting)
            return true;
    }
    return false;
}

json_t *pen_json_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                       struct pen_status *st)
{
    int nesting = limits->nesting < NESTING_MAX ? limits->nesting : NESTING_MAX;
    struct parser p = {.json = {text, bytes},
                       .nesting = nesting,
                       .bytes_left = limits->parsed_bytes,
                       .limit = limits->parsed_bytes,
                       .st = st};
    if (bytes > limits->body_bytes) {
        pen_fail(st, PEN_TOO_LARGE, "the document has %zu bytes, at most %zu are allowed", bytes,
                 limits->body_bytes);
        return NULL;
    }
    json_t *document = parse_document(&p);
    /* A malformed text has no JSON Pointer for the place. */
    if (!document && st->code == PEN_SYNTAX && is_too_deep(&p))
        pen_fail(st, PEN_INVALID, "nested deeper than the %d levels allowed", nesting);
    pen_buf_release(&p.scratch);
    pen_json_numbers_release(&p.numbers);
    for (size_t i = 0; i < STRINGS; i++)
        json_decref(p.strings[i]);
    return document;
}

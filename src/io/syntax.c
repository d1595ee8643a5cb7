/* SPDX-License-Identifier: MIT */
/* jansson says how far it read and, roughly, why it stopped. From the start of the text up to
 * there it was JSON, so a few lines of lexing find the last two pieces, and those and the kind
 * of error make a sentence. A column counts characters from the piece's first one: jansson's own
 * column is that of its last one. */
#include "syntax.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "pen/base/utf8.h"
#include "reader.h"

/* A string with its quotes, a bracket, comma or colon, or a run of other characters. */
struct piece {
    size_t start, end;
};

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

static bool is_mark(char c)
{
    return c != '\0' && strchr("[]{},:\"", c) != NULL;
}

/* The end of the string that opens at `start`: after its closing quote, or at the text's end. */
static size_t string_end(const char *text, size_t bytes, size_t start)
{
    size_t i = start + 1;
    while (i < bytes && text[i] != '"')
        i += text[i] == '\\' ? 2 : 1;
    return i < bytes ? i + 1 : bytes;
}

/* The first piece at or after `from`; an empty one at the end if there is none. */
static struct piece next_piece(const char *text, size_t bytes, size_t from)
{
    size_t start = from;
    while (start < bytes && is_space(text[start]))
        start++;
    size_t end = start;
    if (start < bytes && text[start] == '"')
        end = string_end(text, bytes, start);
    else if (start < bytes && is_mark(text[start]))
        end = start + 1;
    else
        while (end < bytes && !is_space(text[end]) && !is_mark(text[end]))
            end++;
    return (struct piece){start, end};
}

size_t pen_syntax_too_deep(const char *text, size_t bytes, int nesting)
{
    int depth = 0;
    for (size_t i = 0; i < bytes; i++) {
        if (text[i] == '"')
            i = string_end(text, bytes, i) - 1;
        else if (text[i] == '[' || text[i] == '{') {
            if (++depth > nesting)
                return i;
        } else if ((text[i] == ']' || text[i] == '}') && depth > 0)
            depth--;
    }
    return SIZE_MAX;
}

/* One open container on the way to a place. */
struct level {
    bool object;
    size_t index;
    struct piece key;
};

static size_t add_step(const char *text, const struct level *level, char *out, size_t used)
{
    char step[PEN_AT_BYTES];
    if (!level->object) {
        snprintf(step, sizeof step, "/%zu", level->index);
    } else {
        struct piece key = level->key;
        size_t n = 0;
        step[n++] = '/';
        for (size_t i = key.start + 1; i + 1 < key.end && n + 3 < sizeof step; i++) {
            bool escape = text[i] == '~' || text[i] == '/';
            step[n++] = escape ? '~' : text[i];
            if (escape)
                step[n++] = text[i] == '~' ? '0' : '1';
        }
        step[n] = '\0';
    }
    size_t length = strlen(step), room = 2 * PEN_AT_BYTES - 1 - used;
    memcpy(out + used, step, length < room ? length : room);
    return used + (length < room ? length : room);
}

void pen_syntax_fail_deep(const char *text, size_t offset, int nesting, struct pen_status *st)
{
    enum { LEVELS = PEN_AT_BYTES / 2 }; /* no more steps fit into a pointer */
    struct level levels[LEVELS] = {{0}};
    char at[2 * PEN_AT_BYTES];
    int depth = 0;
    for (struct piece p = next_piece(text, offset, 0); p.start < offset;
         p = next_piece(text, offset, p.end)) {
        struct level *here = depth > 0 && depth <= LEVELS ? &levels[depth - 1] : NULL;
        char c = text[p.start];
        if (c == '[' || c == '{') {
            if (depth++ < LEVELS)
                levels[depth - 1] = (struct level){.object = c == '{'};
        } else if (c == ']' || c == '}') {
            depth -= depth > 0;
        } else if (c == ',' && here) {
            here->index++;
            here->key = (struct piece){0, 0};
        } else if (c == '"' && here && here->object && here->key.end == 0) {
            here->key = p;
        }
    }
    size_t used = 0;
    for (int i = 0; i < depth && i < LEVELS; i++)
        used = add_step(text, &levels[i], at, used);
    at[used] = '\0';
    pen_fail_at(st, PEN_INVALID, at, "nested deeper than the %d levels allowed", nesting);
}

static bool fail_here(const char *text, size_t offset, struct pen_status *st, const char *message)
{
    int line = 1, column = 1;
    for (size_t i = 0; i < offset; i++) {
        if (text[i] == '\n') {
            line++;
            column = 1;
        } else if (((unsigned char)text[i] & 0xC0) != 0x80) {
            column++;
        }
    }
    return pen_fail_line(st, PEN_SYNTAX, line, column, "%s", message);
}

/* The piece as people should see it. */
static struct pen_text shown(const char *text, struct piece p)
{
    enum { SHOWN = 48 };
    struct pen_text out = {"the end of the document"};
    char raw[SHOWN + 1];
    size_t bytes = p.end - p.start, length = bytes < SHOWN ? bytes : SHOWN;
    if (bytes == 0)
        return out;
    memcpy(raw, text + p.start, length);
    raw[length] = '\0';
    if (raw[0] != '"')
        return pen_text_quote(raw);
    /* A string is shown as it is written: it is whole, so it holds no control characters. */
    pen_utf8_copy(out.text, sizeof out.text, raw);
    if (length < bytes)
        strcat(out.text, "\xE2\x80\xA6\"");
    return out;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static const char *skip_digits(const char *s, const char *end)
{
    while (s < end && is_digit(*s))
        s++;
    return s;
}

/* Whether a word is a number by the grammar of RFC 8259, section 6. */
static bool is_number(const char *s, const char *end)
{
    s += s < end && *s == '-';
    const char *digits = s;
    s = skip_digits(s, end);
    if (s == digits || (*digits == '0' && s - digits > 1))
        return false;
    if (s < end && *s == '.') {
        const char *fraction = ++s;
        s = skip_digits(s, end);
        if (s == fraction)
            return false;
    }
    if (s < end && (*s == 'e' || *s == 'E')) {
        s++;
        s += s < end && (*s == '-' || *s == '+');
        const char *exponent = s;
        s = skip_digits(s, end);
        if (s == exponent)
            return false;
    }
    return s == end;
}

static bool same_word(const char *text, struct piece p, const char *word)
{
    size_t length = strlen(word);
    if (p.end - p.start != length)
        return false;
    for (size_t i = 0; i < length; i++) {
        char c = text[p.start + i];
        if ((c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) != word[i])
            return false;
    }
    return true;
}

/* What is wrong with a word that is no JSON at all; NULL if it is some. */
static const char *foreign(const char *text, struct piece p)
{
    static const char *const not_finite[] = {"nan", "inf", "infinity", NULL};
    static const char *const literals[] = {"true", "false", "null", NULL};
    const char *word = text + p.start;
    char c = *word;
    if (is_mark(c) || is_number(word, text + p.end))
        return NULL;
    struct piece unsigned_word = {p.start + (c == '-' || c == '+'), p.end};
    for (const char *const *name = not_finite; *name; name++) {
        if (same_word(text, unsigned_word, *name))
            return "is not a number that JSON has: numbers are finite";
    }
    for (const char *const *name = literals; *name; name++) {
        if (same_word(text, p, *name))
            return memcmp(word, *name, p.end - p.start) == 0
                       ? NULL
                       : "is not JSON: true, false and null are written in small letters";
    }
    if (c == '/' || c == '#')
        return "is not JSON, which has no comments";
    if (c == '-' || c == '+' || c == '.' || is_digit(c))
        return "is not a number as JSON writes them";
    if (p.end - p.start >= 3 && memcmp(word, "\xEF\xBB\xBF", 3) == 0)
        return "is a byte order mark: save the document without it";
    return "is not JSON: strings and keys are written in double quotes";
}

/* What jansson expected, by the beginning of its text, and what that means. */
static const struct {
    const char *jansson, *meaning;
} expectations[] = {
    {"':' expected", "a colon must follow a key"},
    {"'}' expected", "a comma or } must follow a member of an object"},
    {"']' expected", "a comma or ] must follow an element of an array"},
    {"string or '}' expected", "a key in double quotes must stand here"},
    {"unexpected token", "a value must stand here"},
    {"end of file expected", "nothing may follow the end of the document"},
};

enum fault_place { AT_STOP, AT_BACKSLASH, AT_START };

static const struct {
    const char *jansson;
    enum fault_place at;
    const char *meaning;
} string_faults[] = {
    {"unexpected newline", AT_STOP, "a string must end on the line where it begins"},
    {"control character", AT_STOP,
     "a string must not hold a control character: write \\t, \\n or \\u00XX"},
    {"invalid escape", AT_BACKSLASH,
     "a backslash must be followed by one of \" \\ / b f n r t, or by u and 4 hex digits"},
    {"invalid Unicode", AT_START,
     "this string holds a \\u escape that is no character: surrogates come in pairs"},
};

static bool starts_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

/* A fault inside the string `here`, which jansson read up to `stop`. */
static bool fail_string(const char *text, struct piece here, size_t stop, const json_error_t *error,
                        struct pen_status *st)
{
    for (size_t i = 0; i < sizeof string_faults / sizeof string_faults[0]; i++) {
        if (!starts_with(error->text, string_faults[i].jansson))
            continue;
        size_t offset = string_faults[i].at == AT_STOP ? stop : here.start;
        if (string_faults[i].at == AT_BACKSLASH)
            for (offset = stop; offset > here.start && text[offset] != '\\';)
                offset--;
        return fail_here(text, offset, st, string_faults[i].meaning);
    }
    return true;
}

static bool fail_token(const char *text, struct piece before, struct piece here,
                       const json_error_t *error, struct pen_status *st)
{
    char message[PEN_MSG_BYTES];
    struct pen_text found = shown(text, here);
    const char *fault = foreign(text, here);
    bool closing = text[here.start] == ']' || text[here.start] == '}';
    if (fault) {
        snprintf(message, sizeof message, "%s %s", found.text, fault);
        return fail_here(text, here.start, st, message);
    }
    if (closing && before.end > before.start && text[before.start] == ',')
        return fail_here(text, before.start, st,
                         "a comma must be followed by something, found a closing bracket");
    for (size_t i = 0; i < sizeof expectations / sizeof expectations[0]; i++) {
        if (!starts_with(error->text, expectations[i].jansson))
            continue;
        snprintf(message, sizeof message, "%s, found %s", expectations[i].meaning, found.text);
        return fail_here(text, here.start, st, message);
    }
    snprintf(message, sizeof message, "malformed JSON at %s", found.text);
    return fail_here(text, here.start, st, message);
}

static bool fail_end(const char *text, size_t bytes, struct piece here, struct pen_status *st)
{
    if (here.end == here.start)
        return fail_here(text, 0, st, "the document is empty");
    if (text[here.start] == '"' && here.end == bytes)
        return fail_here(text, here.start, st, "the string that begins here does not end");
    return fail_here(text, bytes, st, "the document ends before everything in it is closed");
}

static bool fail_value(const char *text, struct piece here, enum json_error_code code,
                       struct pen_status *st)
{
    char message[PEN_MSG_BYTES];
    struct pen_text found = shown(text, here);
    snprintf(message, sizeof message,
             code == json_error_duplicate_key ? "duplicate key %s: this object has it already"
             : code == json_error_numeric_overflow
                 ? "%s is too large for a number: they reach to about 1.8e308"
                 : "%s holds the character U+0000, which no string may",
             found.text);
    return fail_here(text, here.start, st, message);
}

/* The last two pieces that begin before `stop`. */
static void find_pieces(const char *text, size_t bytes, size_t stop, struct piece *before,
                        struct piece *here)
{
    *before = *here = (struct piece){0, 0};
    for (struct piece p = next_piece(text, bytes, 0); p.start < stop && p.end > p.start;
         p = next_piece(text, bytes, p.end)) {
        *before = *here;
        *here = p;
    }
}

void pen_syntax_fail(const char *text, size_t bytes, const json_error_t *error,
                     struct pen_status *st)
{
    size_t stop = error->position > 0 ? (size_t)error->position : 0;
    struct piece before, here;
    char message[64];
    stop = stop < bytes ? stop : bytes;
    find_pieces(text, bytes, stop, &before, &here);
    const char *zero = memchr(text + here.start, '\0', stop - here.start);
    enum json_error_code code = json_error_code(error);
    switch (code) {
    case json_error_out_of_memory:
        pen_fail(st, PEN_NO_MEMORY, "the document does not fit into memory");
        return;
    case json_error_stack_overflow:
        pen_fail(st, PEN_INVALID, "nested too deeply");
        return;
    case json_error_invalid_utf8:
        snprintf(message, sizeof message, "byte 0x%02x is not UTF-8", (unsigned char)text[stop]);
        fail_here(text, stop, st, message);
        return;
    case json_error_duplicate_key:
    case json_error_numeric_overflow:
    case json_error_null_character:
    case json_error_null_byte_in_key:
        fail_value(text, here, code, st);
        return;
    default:
        break;
    }
    if (zero)
        fail_here(text, (size_t)(zero - text), st, "a zero byte is not JSON");
    else if (code == json_error_premature_end_of_input || here.end == here.start)
        fail_end(text, bytes, here, st);
    else if (text[here.start] != '"' || fail_string(text, here, stop, error, st))
        fail_token(text, before, here, error, st);
}

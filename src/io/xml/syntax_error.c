/* SPDX-License-Identifier: MIT */
/* Error messages for text that is not well-formed XML, with positions. If expat's position is not
 * where the error begins, the functions here search backwards from it. */
#include <expat.h>
#include <string.h>

#include "base/utf8.h"
#include "io/xml/parse.h"

static bool syntax_error(const char *text, size_t offset, struct pen_status *st, const char *format,
                         ...) __attribute__((format(printf, 4, 5)));

static bool syntax_error(const char *text, size_t offset, struct pen_status *st, const char *format,
                         ...)
{
    va_list args;
    va_start(args, format);
    bool ok = pen_text_fail(st, PEN_SYNTAX, text, offset, format, args);
    va_end(args);
    return ok;
}

static bool is_name_end(char c)
{
    return c == '\0' || strchr(" \t\r\n/>=<&;\"'", c) != NULL;
}

struct pen_text pen_xml_tag_name(const char *text, size_t bytes, size_t tag)
{
    enum { SHOWN = 60 };
    struct pen_text out;
    char raw[SHOWN + 1];
    size_t start = tag + 1 < bytes && text[tag + 1] == '/' ? tag + 2 : tag + 1, n = 0;
    for (; start + n < bytes && n < SHOWN && !is_name_end(text[start + n]); n++)
        raw[n] = text[start + n];
    raw[n] = '\0';
    pen_utf8_copy(out.text, sizeof out.text, raw);
    return out;
}

/* Reports bytes that XML does not allow anywhere. */
static bool check_bytes(const char *text, size_t bytes, struct pen_status *st)
{
    for (size_t i = 0, length; i < bytes; i += length) {
        unsigned char c = (unsigned char)text[i];
        length = pen_utf8_char(text + i, bytes - i);
        if (length == 0)
            return syntax_error(text, i, st, "byte 0x%02x is not UTF-8, the only encoding allowed",
                                c);
        if (c == 0)
            return syntax_error(text, i, st, "a zero byte is not XML");
        if (c < 0x20 && c != '\t' && c != '\n' && c != '\r')
            return syntax_error(text, i, st, "the control character 0x%02x is not XML", c);
        if (length == 3 &&
            (memcmp(text + i, "\xEF\xBF\xBE", 3) == 0 || memcmp(text + i, "\xEF\xBF\xBF", 3) == 0))
            return syntax_error(text, i, st, "U+FFFE and U+FFFF are no characters of XML");
    }
    return true;
}

/* The offset after the next `end` from offset i on. */
static size_t skip_to(const char *text, size_t bytes, size_t i, const char *end)
{
    const char *found = memmem(text + i, bytes - i, end, strlen(end));
    return found ? (size_t)(found - text) + strlen(end) : bytes;
}

/* Counts the attributes of the tag at *at; *at becomes the offset of its end. */
static int count_attributes(const char *text, size_t bytes, size_t *at)
{
    int count = 0;
    size_t i = *at + 1;
    while (i < bytes && text[i] != '>') {
        const char *close = NULL;
        count += text[i] == '=';
        if (text[i] == '"' || text[i] == '\'')
            close = memchr(text + i + 1, text[i], bytes - i - 1);
        i = close ? (size_t)(close - text) + 1 : i + 1;
    }
    *at = i;
    return count;
}

static bool check_tags(const char *text, size_t bytes, struct pen_status *st)
{
    for (size_t i = 0; i < bytes;) {
        const char *next = memchr(text + i, '<', bytes - i);
        if (!next)
            return true;
        i = (size_t)(next - text);
        size_t tag = i;
        if (bytes - i >= 4 && memcmp(next, "<!--", 4) == 0)
            i = skip_to(text, bytes, i + 4, "-->");
        else if (bytes - i >= 9 && memcmp(next, "<![CDATA[", 9) == 0)
            i = skip_to(text, bytes, i + 9, "]]>");
        else if (bytes - i >= 2 && next[1] == '?')
            i = skip_to(text, bytes, i + 2, "?>");
        else if (bytes - i >= 2 && next[1] == '!')
            return true; /* a document type: the parser refuses it and reads nothing after it */
        else if (count_attributes(text, bytes, &i) > PEN_XML_ATTRIBUTES_MAX)
            return syntax_error(text, tag, st, "<%s> has more than the %d attributes allowed",
                                pen_xml_tag_name(text, bytes, tag).text,
                                (int)PEN_XML_ATTRIBUTES_MAX);
    }
    return true;
}

bool pen_xml_check_text(const char *text, size_t bytes, struct pen_status *st)
{
    if (bytes >= 2 && (memcmp(text, "<\0", 2) == 0 || memcmp(text, "\0<", 2) == 0))
        return syntax_error(text, 0, st,
                            "the document is in UTF-16 without a byte-order mark: save it with "
                            "one, or in UTF-8");
    return check_bytes(text, bytes, st) && check_tags(text, bytes, st);
}

/* The character or word at `offset`, quoted for a message. */
static struct pen_text show_word(const char *text, size_t bytes, size_t offset)
{
    enum { SHOWN = 48 };
    char raw[SHOWN + 1];
    size_t n = offset < bytes ? pen_utf8_char(text + offset, bytes - offset) : 0;
    if (n == 0)
        return (struct pen_text){"the end of the document"};
    bool word = !is_name_end(text[offset]);
    while (word && offset + n < bytes && n < SHOWN - 4 && !is_name_end(text[offset + n]))
        n++;
    memcpy(raw, text + offset, n);
    raw[n] = '\0';
    return pen_text_quote(raw);
}

static bool unclosed_error(const char *text, size_t bytes, const struct pen_xml_open *open,
                           struct pen_status *st)
{
    int line, column;
    if (open->count == 0)
        return syntax_error(text, bytes, st,
                            "the document has no element: a scene is <scene>…</scene>");
    size_t tag = open->tag[open->count - 1];
    pen_text_position(text, tag, &line, &column);
    return syntax_error(text, bytes, st,
                        "the document ends before <%s>, which opens on line %d, is closed",
                        pen_xml_tag_name(text, bytes, tag).text, line);
}

/* A start tag and an end tag that do not match. expat's offset is that of the name in the end tag.
 */
static bool mismatch_error(const char *text, size_t bytes, size_t offset,
                           const struct pen_xml_open *open, struct pen_status *st)
{
    int line, column;
    size_t tag = open->count ? open->tag[open->count - 1] : 0;
    size_t at = offset >= 2 && text[offset - 1] == '/' ? offset - 2 : offset;
    pen_text_position(text, tag, &line, &column);
    return syntax_error(
        text, at, st, "the end tag </%s> does not close <%s>, which opens on line %d",
        pen_xml_tag_name(text, bytes, at).text, pen_xml_tag_name(text, bytes, tag).text, line);
}

/* An undefined entity. In an attribute, expat's offset is that of the tag. */
static bool entity_error(const char *text, size_t bytes, size_t offset, struct pen_status *st)
{
    const char *amp = offset < bytes ? memchr(text + offset, '&', bytes - offset) : NULL;
    size_t at = amp ? (size_t)(amp - text) : offset;
    return syntax_error(text, at, st,
                        "the entity &%s; is not defined: only &lt; &gt; &amp; &quot; &apos; and "
                        "characters by number, such as &#32;, are allowed",
                        pen_xml_tag_name(text, bytes, at).text);
}

/* Whether the text at `offset` is inside a tag, in quotes or not. */
static bool in_tag(const char *text, size_t offset)
{
    while (offset > 0 && text[offset - 1] != '<' && text[offset - 1] != '>')
        offset--;
    return offset > 0 && text[offset - 1] == '<';
}

static bool token_error(const char *text, size_t bytes, size_t offset,
                        const struct pen_xml_open *open, struct pen_status *st)
{
    char c = offset < bytes ? text[offset] : '\0', before = offset > 0 ? text[offset - 1] : '\0';
    if (before == '&')
        return syntax_error(text, offset - 1, st,
                            "& is written &amp; where it begins no reference");
    if (before == '<')
        return syntax_error(text, offset - 1, st, "< is written &lt; where it opens no tag");
    return syntax_error(
        text, offset, st, "not well-formed: found %s%s", show_word(text, bytes, offset).text,
        open->count == 0 && !in_tag(text, offset) ? ": a scene in XML begins with <scene>"
        : c == '<' ? ", which is written &lt; in a value; is a quote before it not closed?"
        : in_tag(text, offset) ? ", in a tag stand NAME=\"VALUE\" and nothing else"
                               : "");
}

/* An unfinished CDATA section. expat's offset is the end of the text. */
static bool cdata_error(const char *text, size_t offset, struct pen_status *st)
{
    static const char begin[] = "<![CDATA[";
    size_t at = offset;
    while (at > 0 &&
           (offset - at < sizeof begin - 1 || memcmp(text + at, begin, sizeof begin - 1) != 0))
        at--;
    return syntax_error(text, at, st, "the CDATA section that begins here does not end");
}

bool pen_xml_syntax_error(const char *text, size_t bytes, size_t offset, int code,
                          const struct pen_xml_open *open, struct pen_status *st)
{
    switch (code) {
    case XML_ERROR_NO_MEMORY:
        return pen_fail(st, PEN_NO_MEMORY, "the document does not fit into memory");
    case XML_ERROR_NO_ELEMENTS:
        return unclosed_error(text, bytes, open, st);
    case XML_ERROR_INVALID_TOKEN:
        return token_error(text, bytes, offset, open, st);
    case XML_ERROR_UNCLOSED_TOKEN:
        return syntax_error(text, offset, st,
                            "the document ends inside the tag or comment that begins here");
    case XML_ERROR_UNCLOSED_CDATA_SECTION:
        return cdata_error(text, offset, st);
    case XML_ERROR_TAG_MISMATCH:
        return mismatch_error(text, bytes, offset, open, st);
    case XML_ERROR_DUPLICATE_ATTRIBUTE:
        return syntax_error(text, offset, st, "duplicate attribute %s: this element has it already",
                            show_word(text, bytes, offset).text);
    case XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
        return syntax_error(text, offset, st,
                            "nothing may follow the end of the document's one element");
    case XML_ERROR_UNDEFINED_ENTITY:
        return entity_error(text, bytes, offset, st);
    case XML_ERROR_MISPLACED_XML_PI:
        return syntax_error(text, offset, st,
                            "the XML declaration must stand at the very beginning of the document");
    default:
        return syntax_error(text, offset, st, "not well-formed: %s",
                            XML_ErrorString((enum XML_Error)code));
    }
}

/* SPDX-License-Identifier: MIT */
#include "io/xml/spellings.h"

#include <stdio.h>
#include <string.h>

const struct pen_xml_spelling pen_xml_spellings[] = {
    {PEN_XML_OTHER_ELEMENT, "directional", {"directional-light"}},
    {PEN_XML_OTHER_ELEMENT, "point", {"point-light"}},
    {PEN_XML_OTHER_ELEMENT, "spot", {"spot-light"}},
    {PEN_XML_OTHER_ATTRIBUTE, "color", {"intensity"}},
    {PEN_XML_PARTS, "attenuation", {"kc", "kl", "kq"}},
    {PEN_XML_OTHER_ATTRIBUTE, "beam-exponent", {"narrow-beam"}},
    {PEN_XML_OTHER_ATTRIBUTE, "k", {"ka"}},
    {PEN_XML_OTHER_ATTRIBUTE, "shininess", {"n-shininess"}},
    {PEN_XML_OTHER_ATTRIBUTE, "point", {"p0"}},
    {PEN_XML_PARTS, "points", {"p0", "p1", "p2", "…"}},
    {PEN_XML_OTHER_ATTRIBUTE,
     "origin",
     {"axis-origin", "axis-point", "axis-head", "axis-p0", "p0"}},
    {PEN_XML_OTHER_ATTRIBUTE, "direction", {"axis-direction", "axis-dir", "vector"}},
    {0}};

/* The next significant letter, in lower case; 0 at the end. */
static char next_letter(const char **name)
{
    while (**name == '-' || **name == '_')
        ++*name;
    char c = **name;
    *name += c != '\0';
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

bool pen_xml_same_name(const char *a, const char *b)
{
    char x, y;
    do {
        x = next_letter(&a);
        y = next_letter(&b);
    } while (x == y && x);
    return x == y;
}

/* Whether the name is that of a part from `first` on, numbered like the names before "…". */
static bool is_numbered(const struct pen_xml_spelling *row, const char *name, size_t first,
                        size_t *index)
{
    const int stem = (int)strlen(row->other[0]) - 1; /* without its 0 */
    for (*index = first; *index < PEN_XML_PARTS_MAX; ++*index) {
        char numbered[32];
        snprintf(numbered, sizeof numbered, "%.*s%zu", stem, row->other[0], *index);
        if (pen_xml_same_name(numbered, name))
            return true;
    }
    return false;
}

bool pen_xml_spelling_has(const struct pen_xml_spelling *row, const char *name, size_t *index)
{
    for (*index = 0; *index < PEN_XML_OTHER_NAMES && row->other[*index]; ++*index) {
        if (strcmp(row->other[*index], "…") == 0)
            return is_numbered(row, name, *index, index);
        if (pen_xml_same_name(row->other[*index], name))
            return true;
    }
    return false;
}

bool pen_xml_is_about_xml(const char *name)
{
    return strcmp(name, "xmlns") == 0 || strncmp(name, "xmlns:", 6) == 0 ||
           strncmp(name, "xsi:", 4) == 0;
}

/* SPDX-License-Identifier: MIT */
/* The tables of elements and attributes. A list of the JSON format is an element that holds its
 * members. An object inside an object is an element inside an element. Every other key is an
 * attribute. */
#include <stdio.h>
#include <string.h>

#include "io/scene/tables.h"
#include "io/xml/elements.h"
#include "io/xml/spellings.h"

static const struct pen_xml_attribute scene_own[] = {
    {"background-color", PEN_XML_COLOUR, "background"},
    {"", PEN_XML_HIDDEN, "ambient"},
    {"", PEN_XML_HIDDEN, "$schema"},
    {0}};
static const struct pen_xml_attribute sky_own[] = {{"zenith", PEN_XML_COLOUR, "sky/zenith"},
                                                   {"horizon", PEN_XML_COLOUR, "sky/horizon"},
                                                   {"nadir", PEN_XML_COLOUR, "sky/nadir"},
                                                   {"up", PEN_XML_TRIPLE, "sky/up"},
                                                   {0}};
static const struct pen_xml_attribute ambient_own[] = {
    {"color", PEN_XML_COLOUR, ""}, {"k", PEN_XML_FACTOR, "@factor"}, {0}};
static const struct pen_xml_attribute by_own[] = {{"by", PEN_XML_TRIPLE, ""}, {0}};
static const struct pen_xml_attribute axis_own[] = {{"axis", PEN_XML_AXIS, "axis"}, {0}};
static const struct pen_xml_attribute name_own[] = {{"name", PEN_XML_TEXT, "@name"}, {0}};
static const struct pen_xml_attribute view_camera_own[] = {
    {"distance", PEN_XML_NUMBER, "view_plane/distance"},
    {"width", PEN_XML_NUMBER, "view_plane/width"},
    {"height", PEN_XML_NUMBER, "view_plane/height"},
    {0}};
static const struct pen_xml_attribute camera_own[] = {
    {"distance", PEN_XML_NUMBER, "view_plane/distance"},
    {"width", PEN_XML_NUMBER, "view_plane/width"},
    {"height", PEN_XML_NUMBER, "view_plane/height"},
    {"image", PEN_XML_PAIR, "@image"},
    {0}};
static const struct pen_xml_attribute light_own[] = {{"color", PEN_XML_COLOUR, "intensity"}, {0}};
static const struct pen_xml_attribute sphere_own[] = {{"material", PEN_XML_TEXT, "material"}, {0}};
static const struct pen_xml_attribute plane_own[] = {{"material", PEN_XML_TEXT, "material"},
                                                     {"p1", PEN_XML_TRIPLE, "corners/1"},
                                                     {"p2", PEN_XML_TRIPLE, "corners/2"},
                                                     {0}};
static const struct pen_xml_attribute triangle_own[] = {{"material", PEN_XML_TEXT, "material"},
                                                        {"p0", PEN_XML_TRIPLE, "vertices/0"},
                                                        {"p1", PEN_XML_TRIPLE, "vertices/1"},
                                                        {"p2", PEN_XML_TRIPLE, "vertices/2"},
                                                        {0}};
static const struct pen_xml_attribute mesh_own[] = {{"material", PEN_XML_TEXT, "material"},
                                                    {"positions", PEN_XML_POINTS, "positions"},
                                                    {"normals", PEN_XML_POINTS, "normals"},
                                                    {"faces", PEN_XML_POINTS, "faces"},
                                                    {0}};
static const struct pen_xml_attribute polygon_own[] = {
    {"material", PEN_XML_TEXT, "material"}, {"points", PEN_XML_POINTS, "vertices"}, {0}};
static const struct pen_xml_attribute tube_own[] = {
    {"material", PEN_XML_TEXT, "material"}, {"direction", PEN_XML_TRIPLE, "axis"}, {0}};
/* Also for cones. */
static const struct pen_xml_attribute cylinder_own[] = {{"material", PEN_XML_TEXT, "material"},
                                                        {"origin", PEN_XML_TRIPLE, "base"},
                                                        {"direction", PEN_XML_TRIPLE, "axis"},
                                                        {0}};
static const struct pen_xml_attribute matrix_own[] = {{"matrix", PEN_XML_MATRIX, "matrix"}, {0}};

/* Moves of a camera. */
static const struct pen_xml_element translate = {"translate", PEN_XML_ITEM_VALUE, "translate",
                                                 .own = by_own};
static const struct pen_xml_element rotate = {"rotate", PEN_XML_ITEM_MEMBER, "rotate",
                                              .own = axis_own, .fields = pen_camera_rotate_fields};
static const struct pen_xml_element orbit = {"orbit", PEN_XML_ITEM_MEMBER, "orbit",
                                             .fields = pen_camera_orbit_fields};
static const struct pen_xml_element *const moves[] = {&translate, &rotate, &orbit, NULL};
static const struct pen_xml_element transforms = {"transforms", PEN_XML_MEMBER_LIST, "transforms",
                                                  .children = moves};
static const struct pen_xml_element *const camera_children[] = {&transforms, NULL};

static const struct pen_xml_element view_camera = {"camera",
                                                   PEN_XML_MEMBER_OBJECT,
                                                   "camera",
                                                   .own = view_camera_own,
                                                   .fields = pen_camera_fields,
                                                   .children = camera_children};
static const struct pen_xml_element *const view_children[] = {&view_camera, NULL};
static const struct pen_xml_element view = {"view", PEN_XML_ITEM, NULL, .fields = pen_view_fields,
                                            .children = view_children};
static const struct pen_xml_element *const views_children[] = {&view, NULL};

/* Patterns in place of a colour: of a material, and of a primitive's own material. */
#define PATTERN(key, table)                                                                        \
    static const struct pen_xml_element key##_pattern = {#key, PEN_XML_MEMBER_OBJECT, #key,        \
                                                         .fields = table};                         \
    static const struct pen_xml_element own_##key##_pattern = {#key, PEN_XML_MEMBER_OBJECT,        \
                                                               "material/" #key, .fields = table};
PATTERN(emission, pen_colour_pattern_fields)
PATTERN(ka, pen_factor_pattern_fields)
PATTERN(kd, pen_factor_pattern_fields)
PATTERN(ks, pen_factor_pattern_fields)
PATTERN(kt, pen_factor_pattern_fields)
PATTERN(kr, pen_factor_pattern_fields)
static const struct pen_xml_element *const patterns[] = {
    &emission_pattern, &ka_pattern, &kd_pattern, &ks_pattern, &kt_pattern, &kr_pattern, NULL};
static const struct pen_xml_element material = {
    "material",          PEN_XML_NAMED, NULL, .own = name_own, .fields = pen_material_fields,
    .children = patterns};
static const struct pen_xml_element *const materials_children[] = {&material, NULL};
/* The material of a primitive. */
static const struct pen_xml_element own_material = {"material", PEN_XML_MEMBER_MORE, "material",
                                                    .fields = pen_material_fields,
                                                    .children = patterns};
static const struct pen_xml_element *const object_children[] = {
    &own_emission_pattern, &own_ka_pattern, &own_kd_pattern, &own_ks_pattern,
    &own_kt_pattern,       &own_kr_pattern, &own_material,   NULL};

#define LIGHT_ELEMENT(kind)                                                                        \
    static const struct pen_xml_element kind = {#kind,                                             \
                                                PEN_XML_ITEM,                                      \
                                                #kind,                                             \
                                                .own = light_own,                                  \
                                                .fields = pen_##kind##_fields,                     \
                                                .finish = PEN_XML_LIGHT,                           \
                                                .list = "lights"};
LIGHT_ELEMENT(directional)
LIGHT_ELEMENT(point)
LIGHT_ELEMENT(spot)
static const struct pen_xml_element *const lights_children[] = {&spot, &point, &directional, NULL};

static const struct pen_xml_element transform_rotate = {"rotate", PEN_XML_MEMBER_OBJECT, "rotate",
                                                        .fields = pen_transform_rotate_fields};
static const struct pen_xml_element *const transform_children[] = {&transform_rotate, NULL};
static const struct pen_xml_element transform = {
    "transform",       PEN_XML_MEMBER_OBJECT,          "transform",
    .own = matrix_own, .fields = pen_transform_fields, .children = transform_children};

#define OBJECT_ELEMENT(kind, own_rows, own_fields, last_step)                                      \
    static const struct pen_xml_element kind = {#kind,                                             \
                                                PEN_XML_ITEM,                                      \
                                                #kind,                                             \
                                                .own = own_rows,                                   \
                                                .fields = own_fields,                              \
                                                .material = pen_material_fields,                   \
                                                .children = object_children,                       \
                                                .finish = last_step};
OBJECT_ELEMENT(sphere, sphere_own, pen_sphere_fields, PEN_XML_FINISH_NONE)
OBJECT_ELEMENT(triangle, triangle_own, pen_polygon_fields, PEN_XML_TRIANGLE)
OBJECT_ELEMENT(polygon, polygon_own, pen_polygon_fields, PEN_XML_POLYGON)
OBJECT_ELEMENT(plane, plane_own, pen_plane_fields, PEN_XML_PLANE)
OBJECT_ELEMENT(tube, tube_own, pen_infinite_cylinder_fields, PEN_XML_FINISH_NONE)
OBJECT_ELEMENT(cylinder, cylinder_own, pen_cylinder_fields, PEN_XML_FINISH_NONE)
OBJECT_ELEMENT(cone, cylinder_own, pen_cone_fields, PEN_XML_FINISH_NONE)
OBJECT_ELEMENT(mesh, mesh_own, pen_mesh_fields, PEN_XML_FINISH_NONE)
static const struct pen_xml_element instance = {
    .name = "instance", .build = PEN_XML_UNSUPPORTED, .key = "the object type \"instance\""};
static const struct pen_xml_element group;
static const struct pen_xml_element *const objects[] = {
    &sphere, &triangle, &plane, &polygon, &tube, &cylinder, &cone, &group, &mesh, &instance, NULL};
static const struct pen_xml_element *const group_children[] = {
    &sphere, &triangle, &plane, &polygon,  &tube,      &cylinder,
    &cone,   &group,    &mesh,  &instance, &transform, NULL};
static const struct pen_xml_element group = {"group",
                                             PEN_XML_ITEM,
                                             "group",
                                             .fields = pen_group_fields,
                                             .children = group_children,
                                             .finish = PEN_XML_GROUP};

/* Parts of a scene. */
static const struct pen_xml_element ambient_light = {"ambient-light", PEN_XML_MEMBER_VALUE,
                                                     "ambient", .own = ambient_own};
static const struct pen_xml_element sky = {"sky", PEN_XML_MEMBER_OBJECT, "background",
                                           .own = sky_own};
static const struct pen_xml_element camera = {
    "camera",          PEN_XML_MEMBER_OBJECT,       "camera",
    .own = camera_own, .fields = pen_camera_fields, .children = camera_children};
static const struct pen_xml_element views = {"views", PEN_XML_MEMBER_LIST, "views",
                                             .children = views_children};
static const struct pen_xml_element materials = {"materials", PEN_XML_MEMBER_OBJECT, "materials",
                                                 .children = materials_children};
static const struct pen_xml_element lights = {"lights", PEN_XML_MEMBER_LIST, "lights",
                                              .children = lights_children};
static const struct pen_xml_element geometries = {"geometries", PEN_XML_MEMBER_LIST, "objects",
                                                  .children = objects};
static const struct pen_xml_element definitions = {.name = "definitions",
                                                   .build = PEN_XML_UNSUPPORTED,
                                                   .key = "definitions of groups for instances"};
static const struct pen_xml_element render = {"render", PEN_XML_MEMBER_OBJECT, "render",
                                              .fields = pen_settings_fields};
static const struct pen_xml_element *const scene_children[] = {
    &ambient_light, &sky,         &camera, &views, &materials,   &lights, &geometries,
    &render,        &definitions, &spot,   &point, &directional, NULL};
const struct pen_xml_element pen_xml_scene = {"scene",
                                              PEN_XML_ROOT,
                                              NULL,
                                              .own = scene_own,
                                              .fields = pen_scene_fields,
                                              .children = scene_children};

static enum pen_xml_shape shape_of(enum pen_field_type type)
{
    switch (type) {
    case PEN_FIELD_OTHER:
        return PEN_XML_HIDDEN;
    case PEN_FIELD_NUMBER:
    case PEN_FIELD_INTEGER:
    case PEN_FIELD_SEED:
        return PEN_XML_NUMBER;
    case PEN_FIELD_BOOL:
        return PEN_XML_BOOL;
    case PEN_FIELD_WORD:
    case PEN_FIELD_STRING:
    case PEN_FIELD_NOTE:
        return PEN_XML_TEXT;
    case PEN_FIELD_COLOUR:
    case PEN_FIELD_COLOUR_OR_PATTERN:
        return PEN_XML_COLOUR;
    case PEN_FIELD_FACTOR:
    case PEN_FIELD_FACTOR_OR_PATTERN:
        return PEN_XML_FACTOR;
    case PEN_FIELD_POINT:
    case PEN_FIELD_DIRECTION:
    case PEN_FIELD_COEFFICIENTS:
        return PEN_XML_TRIPLE;
    }
    return PEN_XML_HIDDEN;
}

static bool is_own(const struct pen_xml_element *element, const char *key)
{
    const struct pen_xml_attribute *a = element->own;
    while (a && a->name && strcmp(a->path, key) != 0)
        a++;
    return a && a->name;
}

static void make_row(const char *name, enum pen_xml_shape shape, const char *prefix,
                     const char *path, struct pen_xml_row *row)
{
    row->shape = shape;
    snprintf(row->path, sizeof row->path, "%s%.40s", prefix, path);
    snprintf(row->name, sizeof row->name, "%.30s", name);
    for (char *c = row->name; *c; c++)
        *c = *c == '_' ? '-' : *c;
}

/* Makes rows of the fields that are attributes, at most `capacity`. If `name` is not NULL, only of
 * the attribute with that name. Returns their number. */
static size_t rows_of_fields(const struct pen_xml_element *element, const struct pen_field *fields,
                             const char *prefix, const char *name, struct pen_xml_row *rows,
                             size_t capacity)
{
    size_t count = 0;
    for (const struct pen_field *f = fields; f && f->key && count < capacity; f++) {
        enum pen_xml_shape shape = shape_of(f->type);
        bool wanted = shape != PEN_XML_HIDDEN && (!name || pen_xml_same_name(f->key, name));
        if (wanted && (*prefix || !is_own(element, f->key)))
            make_row(f->key, shape, prefix, f->key, &rows[count++]);
    }
    return count;
}

/* Whether the element becomes an object with keys of the format, which may have a comment. */
static bool may_have_comment(const struct pen_xml_element *element)
{
    switch (element->build) {
    case PEN_XML_ROOT:
    case PEN_XML_MEMBER_OBJECT:
    case PEN_XML_MEMBER_MORE:
    case PEN_XML_ITEM:
    case PEN_XML_ITEM_MEMBER:
    case PEN_XML_NAMED:
        return element->own || element->fields; /* materials are objects with names as keys */
    case PEN_XML_MEMBER_LIST:
    case PEN_XML_MEMBER_VALUE:
    case PEN_XML_ITEM_VALUE:
    case PEN_XML_UNSUPPORTED:
        break;
    }
    return false;
}

/* All attributes; if `name` is not NULL, only the one with that name. Returns their number. */
static size_t find_rows(const struct pen_xml_element *element, const char *name,
                        struct pen_xml_row *rows, size_t capacity)
{
    size_t count = 0;
    for (const struct pen_xml_attribute *a = element->own; a && a->name && count < capacity; a++) {
        if (a->shape != PEN_XML_HIDDEN && (!name || pen_xml_same_name(a->name, name)))
            make_row(a->name, a->shape, "", a->path, &rows[count++]);
    }
    count += rows_of_fields(element, element->fields, "", name, rows + count, capacity - count);
    count += rows_of_fields(element, element->material, "material/", name, rows + count,
                            capacity - count);
    if (may_have_comment(element) && count < capacity &&
        (!name || pen_xml_same_name(name, PEN_COMMENT_KEY)))
        make_row(PEN_COMMENT_KEY, PEN_XML_TEXT, "", PEN_COMMENT_KEY, &rows[count++]);
    return count;
}

size_t pen_xml_rows(const struct pen_xml_element *element,
                    struct pen_xml_row rows[PEN_XML_NAMES_MAX])
{
    return find_rows(element, NULL, rows, PEN_XML_NAMES_MAX);
}

/* Makes the row of part `index` from the row of the whole: a point of points, a number of a triple.
 */
static void make_part(size_t index, struct pen_xml_row *row)
{
    size_t used = strlen(row->path);
    snprintf(row->path + used, sizeof row->path - used, "/%zu", index);
    row->shape = row->shape == PEN_XML_POINTS ? PEN_XML_TRIPLE : PEN_XML_NUMBER;
}

bool pen_xml_row_find(const struct pen_xml_element *element, const char *name,
                      struct pen_xml_row *row)
{
    size_t index;
    if (find_rows(element, name, row, 1) == 1)
        return true;
    for (const struct pen_xml_spelling *s = pen_xml_spellings; s->ours; s++) {
        if (s->kind == PEN_XML_OTHER_ELEMENT || !pen_xml_spelling_has(s, name, &index) ||
            find_rows(element, s->ours, row, 1) == 0)
            continue;
        if (s->kind == PEN_XML_PARTS)
            make_part(index, row);
        return true;
    }
    return false;
}

static const struct pen_xml_element *child_of(const struct pen_xml_element *element,
                                              const char *name)
{
    for (const struct pen_xml_element *const *c = element->children; c && *c; c++) {
        if (pen_xml_same_name((*c)->name, name))
            return *c;
    }
    return NULL;
}

const struct pen_xml_element *pen_xml_child_find(const struct pen_xml_element *element,
                                                 const char *name)
{
    const struct pen_xml_element *child = child_of(element, name);
    size_t index;
    for (const struct pen_xml_spelling *s = pen_xml_spellings; s->ours && !child; s++) {
        if (s->kind == PEN_XML_OTHER_ELEMENT && pen_xml_spelling_has(s, name, &index))
            child = child_of(element, s->ours);
    }
    return child;
}

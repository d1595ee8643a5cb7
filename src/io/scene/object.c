/* SPDX-License-Identifier: MIT */
/* Objects: primitives and groups. */
#include "io/scene/object.h"
#include "io/scene/tables.h"

#include <math.h>
#include <stdio.h>

#include "math/exact.h"
#include "math/exact_sum.h"

/* Kinds of the format that this version does not support. */
enum { KIND_UNSUPPORTED = -1 };

static const struct pen_word kinds[] = {
    {"sphere", PEN_OBJECT_SPHERE, NULL},
    {"plane", PEN_OBJECT_PLANE, NULL},
    {"triangle", PEN_OBJECT_TRIANGLE, NULL},
    {"polygon", PEN_OBJECT_POLYGON, NULL},
    {"tube", PEN_OBJECT_INFINITE_CYLINDER, NULL},
    {"cylinder", PEN_OBJECT_CYLINDER, NULL},
    {"cone", PEN_OBJECT_CONE, NULL},
    {"group", PEN_OBJECT_GROUP, NULL},
    {"mesh", PEN_OBJECT_MESH, NULL},
    {"instance", KIND_UNSUPPORTED, "the object type \"instance\""},
    {0}};

#define MEMBER(path) offsetof(struct pen_object_desc, path)

/* The keys of every primitive. */
#define PRIMITIVE_FIELDS                                                                           \
    {"type", .type = PEN_FIELD_OTHER}, {"name", PEN_FIELD_STRING, .offset = MEMBER(name)},         \
    {                                                                                              \
        "material", .type = PEN_FIELD_OTHER                                                        \
    }

const struct pen_field pen_sphere_fields[] = {
    PRIMITIVE_FIELDS,
    {"center", PEN_FIELD_POINT, .required = true, .offset = MEMBER(u.sphere.center)},
    {"radius", PEN_FIELD_NUMBER, .required = true, .offset = MEMBER(u.sphere.radius),
     .range = &pen_range_positive},
    {0}};

const struct pen_field pen_plane_fields[] = {
    PRIMITIVE_FIELDS,
    {"point", PEN_FIELD_POINT, .required = true, .offset = MEMBER(u.plane.point)},
    {"normal", PEN_FIELD_DIRECTION, .required = true, .offset = MEMBER(u.plane.normal)},
    {0}};

const struct pen_field pen_polygon_fields[] = {
    PRIMITIVE_FIELDS, {"vertices", PEN_FIELD_OTHER, .required = true}, {0}};

const struct pen_field pen_infinite_cylinder_fields[] = {
    PRIMITIVE_FIELDS,
    {"origin", PEN_FIELD_POINT, .required = true, .offset = MEMBER(u.infinite_cylinder.origin)},
    {"axis", PEN_FIELD_DIRECTION, .required = true, .offset = MEMBER(u.infinite_cylinder.axis)},
    {"radius", PEN_FIELD_NUMBER, .required = true, .offset = MEMBER(u.infinite_cylinder.radius),
     .range = &pen_range_positive},
    {0}};

const struct pen_field pen_cylinder_fields[] = {
    PRIMITIVE_FIELDS,
    {"base", PEN_FIELD_POINT, .required = true, .offset = MEMBER(u.cylinder.base)},
    {"axis", PEN_FIELD_DIRECTION, .required = true, .offset = MEMBER(u.cylinder.axis)},
    {"radius", PEN_FIELD_NUMBER, .required = true, .offset = MEMBER(u.cylinder.radius),
     .range = &pen_range_positive},
    {"height", PEN_FIELD_NUMBER, .required = true, .offset = MEMBER(u.cylinder.height),
     .range = &pen_range_positive},
    {"caps", PEN_FIELD_BOOL, .offset = MEMBER(u.cylinder.caps)},
    {0}};

const struct pen_field pen_cone_fields[] = {
    PRIMITIVE_FIELDS,
    {"base", PEN_FIELD_POINT, .required = true, .offset = MEMBER(u.cone.base)},
    {"axis", PEN_FIELD_DIRECTION, .required = true, .offset = MEMBER(u.cone.axis)},
    {"radius", PEN_FIELD_NUMBER, .required = true, .offset = MEMBER(u.cone.radius),
     .range = &pen_range_positive},
    {"top_radius", PEN_FIELD_NUMBER, .offset = MEMBER(u.cone.top_radius),
     .range = &pen_range_not_negative},
    {"height", PEN_FIELD_NUMBER, .required = true, .offset = MEMBER(u.cone.height),
     .range = &pen_range_positive},
    {"caps", PEN_FIELD_BOOL, .offset = MEMBER(u.cone.caps)},
    {0}};

const struct pen_field pen_group_fields[] = {{"type", .type = PEN_FIELD_OTHER},
                                             {"name", PEN_FIELD_STRING, .offset = MEMBER(name)},
                                             {"objects", PEN_FIELD_OTHER, .required = true},
                                             {"transform", .type = PEN_FIELD_OTHER},
                                             {0}};

static const struct pen_field *fields_of(enum pen_object_kind kind)
{
    switch (kind) {
    case PEN_OBJECT_SPHERE:
        return pen_sphere_fields;
    case PEN_OBJECT_PLANE:
        return pen_plane_fields;
    case PEN_OBJECT_TRIANGLE:
    case PEN_OBJECT_POLYGON:
        return pen_polygon_fields;
    case PEN_OBJECT_INFINITE_CYLINDER:
        return pen_infinite_cylinder_fields;
    case PEN_OBJECT_CYLINDER:
        return pen_cylinder_fields;
    case PEN_OBJECT_CONE:
        return pen_cone_fields;
    case PEN_OBJECT_GROUP:
        return pen_group_fields;
    case PEN_OBJECT_MESH:
        break;
    }
    return NULL;
}

static double largest(struct pen_vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    double most = x > y ? x : y;
    return most > z ? most : z;
}

/* The two sides at v[0] are scaled first, so that products neither over- nor underflow. If the sine
 * of the angle between them is below `least`, their rounding might hide that they are parallel.
 * Then the area is decided exactly. */
bool pen_points_have_area(const struct pen_vec3 v[3])
{
    const double least = 0x1p-40;
    struct pen_vec3 a = pen_sub(v[1], v[0]), b = pen_sub(v[2], v[0]);
    double la = largest(a), lb = largest(b);
    if (la == 0 || lb == 0)
        return false;
    a = pen_vec3(a.x / la, a.y / la, a.z / la);
    b = pen_vec3(b.x / lb, b.y / lb, b.z / lb);
    return pen_length(pen_cross(a, b)) > least * pen_length(a) * pen_length(b) ||
           largest(pen_exact_normal(v, 3)) > 0;
}

static bool same_point(struct pen_vec3 a, struct pen_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Whether the vertices are not all on one line. */
static bool has_area(const struct pen_vec3 *v, uint32_t count)
{
    uint32_t other = 1;
    while (other < count && same_point(v[0], v[other]))
        other++;
    for (uint32_t i = other + 1; i < count; i++) {
        const struct pen_vec3 corner[3] = {v[0], v[other], v[i]};
        if (pen_points_have_area(corner))
            return true;
    }
    return false;
}

/* Removes vertices at the end that repeat the first vertex, or the one before. Returns whether
 * there were any. */
static bool remove_repeated_end(struct pen_object_desc *object)
{
    const struct pen_vec3 *v = object->u.polygon.vertices;
    uint32_t *count = &object->u.polygon.count, before = *count;
    while (*count > 1 &&
           (same_point(v[*count - 1], v[0]) || same_point(v[*count - 1], v[*count - 2])))
        (*count)--;
    return *count < before;
}

/* Leaves out parts that a picture cannot show but that exporters write: repeated vertices at the
 * end of a polygon, and objects without area. */
static bool check_loop(struct pen_reader *r, const struct pen_place *at, bool triangle,
                       struct pen_object_desc *object)
{
    const struct pen_vec3 *v = object->u.polygon.vertices;
    const bool repeats = !triangle && remove_repeated_end(object);
    const uint32_t count = object->u.polygon.count;
    object->left_out = !has_area(v, count);
    object->repeats_vertex = repeats && !object->left_out;
    r->left_out_count += object->left_out;
    r->left_out_vertices += object->left_out ? count : 0;
    r->repeat_count += object->repeats_vertex;
    if (triangle || object->left_out)
        return true;
    struct pen_status st;
    size_t i;
    if (pen_polygon_check(v, count, &st))
        return true;
    bool indexed = sscanf(st.at, "/vertices/%zu", &i) == 1;
    struct pen_place place = pen_place_index(at, indexed ? i : 0);
    return pen_reader_fail(r, indexed ? &place : at, st.code, "%s", st.msg);
}

static bool read_vertices(struct pen_reader *r, const struct pen_place *up, const json_t *json,
                          bool triangle, struct pen_object_desc *object)
{
    struct pen_place at = pen_place_key(up, "vertices");
    size_t count = json_array_size(json);
    if (count < 3 || (triangle && count > 3)) {
        const char *wanted = triangle ? "3" : "at least 3";
        if (pen_reader_is_xml(r) && json_is_array(json))
            return pen_reader_fail(r, &at, PEN_INVALID,
                                   "must be %s points, \"x y z; x y z; …\", found %zu", wanted,
                                   count);
        struct pen_text found = pen_reader_found(r, &at, json);
        return pen_reader_fail(r, &at, PEN_INVALID, "must be an array of %s points, found %s",
                               wanted, found.text);
    }
    struct pen_vec3 *vertices = pen_reader_alloc(r, count, sizeof *vertices);
    if (!vertices)
        return false;
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        struct pen_place place = pen_place_index(&at, i);
        ok &= pen_read_vec3(r, &place, json_array_get(json, i), &pen_range_any, &vertices[i]);
    }
    object->u.polygon.vertices = vertices;
    object->u.polygon.count = (uint32_t)count;
    return ok && check_loop(r, &at, triangle, object);
}

static bool check_cone(struct pen_reader *r, const struct pen_place *up,
                       const struct pen_object_desc *object)
{
    struct pen_place at = pen_place_key(up, "top_radius");
    if (object->u.cone.top_radius != object->u.cone.radius)
        return true;
    struct pen_text found = pen_text_number(object->u.cone.top_radius);
    return pen_reader_fail(r, &at, PEN_INVALID,
                           "must not equal the radius, found %.30s for both: equal radii make a "
                           "cylinder",
                           found.text);
}

/* The name of a primitive without an inside; NULL if it has one, or may be the side of one. */
static const char *without_inside(const struct pen_object_desc *object)
{
    switch (object->kind) {
    case PEN_OBJECT_PLANE:
        return "a plane";
    case PEN_OBJECT_INFINITE_CYLINDER:
        return "a tube";
    case PEN_OBJECT_CYLINDER:
        return object->u.cylinder.caps ? NULL : "a cylinder without caps";
    case PEN_OBJECT_CONE:
        return object->u.cone.caps ? NULL : "a cone without caps";
    case PEN_OBJECT_SPHERE:
    case PEN_OBJECT_TRIANGLE:
    case PEN_OBJECT_POLYGON:
    case PEN_OBJECT_GROUP:
    case PEN_OBJECT_MESH:
        break;
    }
    return NULL;
}

/* Refuses an index other than 1 for an object without an inside. */
static bool check_inside(struct pen_reader *r, const struct pen_place *up, const json_t *material,
                         const struct pen_object_desc *object)
{
    const char *what = without_inside(object);
    const double ior = r->materials[object->material].ior;
    if (ior == 1 || !what)
        return true;
    const struct pen_place at = pen_place_key(up, "material"), inner = pen_place_key(&at, "ior");
    const struct pen_text found = pen_text_number(ior);
    return pen_reader_fail(r, json_is_object(material) ? &inner : &at, PEN_INVALID,
                           "must have the index of refraction (ior) 1, found %.30s: %s has no "
                           "inside; spheres, cylinders and cones with caps, and closed surfaces of "
                           "triangles and polygons have one",
                           found.text, what);
}

struct list {
    uint32_t count;
    struct pen_object_desc *objects;
};

static bool read_list(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      const struct pen_transform_chain *chain, struct list *out);

static bool read_group(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       const struct pen_transform_chain *outer, struct pen_object_desc *object)
{
    const json_t *transform = json_object_get(json, "transform");
    const json_t *members = json_object_get(json, "objects");
    struct pen_place transform_at = pen_place_key(at, "transform");
    struct pen_place members_at = pen_place_key(at, "objects");
    struct pen_transform_chain chain = *outer;
    bool ok = true;
    if (transform) {
        struct pen_transform *f = &object->u.group.transform;
        object->u.group.has_transform = true;
        ok = pen_group_transform_read(r, &transform_at, transform, f);
        if (ok && !chain.invalid)
            ok = pen_transform_chain_add(r, &transform_at, f, &chain);
        chain.invalid |= !ok;
    }
    if (members) {
        struct list list = {0};
        ok &= read_list(r, &members_at, members, &chain, &list);
        object->u.group.count = list.count;
        object->u.group.objects = list.objects;
    }
    return ok;
}

static bool read_mesh(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      struct pen_object_desc *object)
{
    const json_t *material = json_object_get(json, "material");
    const struct pen_place material_at = pen_place_key(at, "material");
    bool ok = !material || pen_material_ref_read(r, &material_at, material, &object->material);
    ok &= pen_mesh_read(r, at, json, object);
    r->primitive_count += object->u.mesh ? object->u.mesh->triangle_count : 0;
    return ok;
}

static bool read_object(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                        const struct pen_transform_chain *chain, struct pen_object_desc *object)
{
    int kind;
    object->material = -1;
    if (!pen_read_type(r, at, json, kinds, &kind))
        return false;
    object->kind = (enum pen_object_kind)kind;
    if (kind == PEN_OBJECT_CYLINDER)
        object->u.cylinder.caps = true;
    if (kind == PEN_OBJECT_CONE)
        object->u.cone.caps = true;
    if (kind == PEN_OBJECT_MESH)
        return read_mesh(r, at, json, object);
    const struct pen_field *fields = fields_of(object->kind);
    bool ok = pen_fields_read_whole(r, at, json, fields, object);
    if (kind == PEN_OBJECT_GROUP)
        return read_group(r, at, json, chain, object) && ok;
    if (kind == PEN_OBJECT_CONE && ok)
        ok = check_cone(r, at, object);
    const json_t *material = json_object_get(json, "material");
    const json_t *vertices = json_object_get(json, "vertices");
    struct pen_place material_at = pen_place_key(at, "material");
    if (material)
        ok &= pen_material_ref_read(r, &material_at, material, &object->material) &&
              check_inside(r, at, material, object);
    if (vertices && fields == pen_polygon_fields)
        ok &= read_vertices(r, at, vertices, kind == PEN_OBJECT_TRIANGLE, object);
    if (ok && !pen_prim_flat((uint32_t)kind) && !chain->invalid)
        ok = pen_transform_chain_check_quadric(r, at, pen_kinds[kind].name, chain);
    r->primitive_count += !object->left_out;
    return ok;
}

static bool read_list(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      const struct pen_transform_chain *chain, struct list *out)
{
    if (!pen_read_array(r, at, json, "objects"))
        return false;
    size_t count = json_array_size(json);
    r->object_count += count;
    if (r->object_count > r->limits->objects)
        return pen_reader_fail(r, at, PEN_INVALID,
                               "with these %zu the scene holds more than %llu objects, the most "
                               "allowed",
                               count, (unsigned long long)r->limits->objects);
    out->objects = pen_reader_alloc(r, count, sizeof *out->objects);
    if (!out->objects)
        return false;
    out->count = (uint32_t)count;
    bool ok = true;
    for (size_t i = 0; i < count && !r->no_memory; i++) {
        struct pen_place place = pen_place_index(at, i);
        ok &= read_object(r, &place, json_array_get(json, i), chain, &out->objects[i]);
    }
    return ok;
}

bool pen_objects_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      struct pen_scene_desc *desc)
{
    struct pen_transform_chain chain = {.f = pen_transform_identity(), .similar = true};
    struct list list = {0};
    bool ok = read_list(r, at, json, &chain, &list);
    desc->objects = list.objects;
    desc->object_count = list.count;
    desc->primitive_count = r->primitive_count;
    desc->left_out_count = r->left_out_count;
    desc->left_out_vertices = r->left_out_vertices;
    return ok;
}

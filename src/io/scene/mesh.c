/* SPDX-License-Identifier: MIT */
/* Meshes: triangles from a model file, or positions and triangles in the document. */
#include <math.h>
#include <string.h>

#include "io/models.h"
#include "io/scene/object.h"
#include "io/scene/tables.h"
#include "math/scale.h"

/* The target of pen_mesh_fields. */
struct mesh_target {
    const char *name, *file;
    bool smooth;
};

const struct pen_field pen_mesh_fields[] = {
    {"type", .type = PEN_FIELD_OTHER},
    {"name", PEN_FIELD_STRING, .offset = offsetof(struct mesh_target, name)},
    {"material", .type = PEN_FIELD_OTHER},
    {"file", PEN_FIELD_STRING, .offset = offsetof(struct mesh_target, file)},
    {"positions", .type = PEN_FIELD_OTHER},
    {"normals", .type = PEN_FIELD_OTHER},
    {"faces", .type = PEN_FIELD_OTHER},
    {"smooth", PEN_FIELD_BOOL, .offset = offsetof(struct mesh_target, smooth)},
    {0}};

/* ---- in the document ---- */

static bool read_index(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       uint32_t count, uint32_t *out)
{
    const json_int_t i = json_integer_value(json);
    *out = (uint32_t)i;
    if (json_is_integer(json) && i >= 0 && i < (json_int_t)count)
        return true;
    struct pen_text found = pen_reader_found(r, at, json);
    return pen_reader_fail(r, at, PEN_INVALID,
                           "must be the number of a position, from 0 to %u, found %s", count - 1,
                           found.text);
}

static bool read_corners(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         const struct pen_mesh_desc *mesh, uint32_t corner[3])
{
    bool ok = json_array_size(json) == 3;
    if (!ok) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must be an array of 3 numbers of positions, found %s", found.text);
    }
    for (size_t k = 0; k < 3; k++) {
        const struct pen_place place = pen_place_index(at, k);
        ok &= read_index(r, &place, json_array_get(json, k), mesh->vertex_count, &corner[k]);
    }
    return ok;
}

static struct pen_vec3 position(const struct pen_mesh_desc *mesh, uint32_t i)
{
    const float *v = mesh->vertex + 3 * (size_t)i;
    return pen_vec3((double)v[0], (double)v[1], (double)v[2]);
}

/* Keeps triangles with an area; returns false if there is none. */
static bool drop_flat(struct pen_reader *r, struct pen_mesh_desc *mesh, uint32_t *corner)
{
    uint32_t kept = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const struct pen_vec3 v[3] = {position(mesh, corner[3 * (size_t)t]),
                                      position(mesh, corner[3 * (size_t)t + 1]),
                                      position(mesh, corner[3 * (size_t)t + 2])};
        if (!pen_points_have_area(v))
            continue;
        memmove(corner + 3 * (size_t)kept++, corner + 3 * (size_t)t, 3 * sizeof *corner);
    }
    r->mesh_flat_count += mesh->triangle_count - kept;
    mesh->triangle_count = kept;
    return kept > 0;
}

static bool read_positions(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                           struct pen_mesh_desc *mesh)
{
    const size_t count = json_array_size(json);
    if (count < 3) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must be an array of at least 3 points, found %s", found.text);
    }
    float *vertex = pen_reader_alloc(r, 3 * count, sizeof *vertex);
    if (!vertex)
        return false;
    static const struct pen_range floats = {-0x1p120, 0x1p120, false, false};
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        const struct pen_place place = pen_place_index(at, i);
        struct pen_vec3 v = {0};
        ok &= pen_read_vec3(r, &place, json_array_get(json, i), &floats, &v);
        vertex[3 * i] = (float)v.x;
        vertex[3 * i + 1] = (float)v.y;
        vertex[3 * i + 2] = (float)v.z;
    }
    mesh->vertex = vertex;
    mesh->vertex_count = (uint32_t)count;
    return ok;
}

/* Reads a normal for each position, and rounds it to floats. */
static bool read_normals(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         struct pen_mesh_desc *mesh)
{
    const size_t count = json_array_size(json);
    if (count != mesh->vertex_count) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must be an array of %u normals, one for each position, found %s",
                               mesh->vertex_count, found.text);
    }
    float *normal = pen_reader_alloc(r, 3 * count, sizeof *normal);
    bool ok = normal != NULL;
    for (size_t i = 0; normal && i < count; i++) {
        const struct pen_place place = pen_place_index(at, i);
        struct pen_vec3 n = {0};
        ok &= pen_read_direction(r, &place, json_array_get(json, i), &n);
        const int exponent = pen_exponent(pen_larger(fabs(n.x), pen_larger(fabs(n.y), fabs(n.z))));
        const int down = exponent < -64 || exponent > 64 ? -exponent : 0;
        normal[3 * i] = (float)pen_scale2(n.x, down);
        normal[3 * i + 1] = (float)pen_scale2(n.y, down);
        normal[3 * i + 2] = (float)pen_scale2(n.z, down);
    }
    mesh->normal = normal;
    mesh->normal_count = (uint32_t)count;
    return ok;
}

static bool read_triangles(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                           struct pen_mesh_desc *mesh)
{
    const size_t count = json_array_size(json);
    if (count < 1) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(
            r, at, PEN_INVALID,
            "must be an array of triangles, 3 numbers of positions each, found %s", found.text);
    }
    uint32_t *corner = pen_reader_alloc(r, 3 * count, sizeof *corner);
    if (!corner)
        return false;
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        const struct pen_place place = pen_place_index(at, i);
        ok &= read_corners(r, &place, json_array_get(json, i), mesh, corner + 3 * i);
    }
    mesh->corner = corner;
    mesh->triangle_count = (uint32_t)count;
    return ok && (drop_flat(r, mesh, corner) ||
                  pen_reader_fail(r, at, PEN_INVALID, "has no triangle with an area"));
}

static bool read_inline(struct pen_reader *r, const struct pen_place *up, const json_t *json,
                        struct pen_mesh_desc *mesh)
{
    const struct pen_place positions_at = pen_place_key(up, "positions"),
                           normals_at = pen_place_key(up, "normals"),
                           faces_at = pen_place_key(up, "faces");
    const json_t *triangles = json_object_get(json, "faces"),
                 *normals = json_object_get(json, "normals");
    if (!triangles)
        return pen_reader_missing(r, up, "faces", NULL);
    return read_positions(r, &positions_at, json_object_get(json, "positions"), mesh) &&
           (!normals || read_normals(r, &normals_at, normals, mesh)) &&
           read_triangles(r, &faces_at, triangles, mesh);
}

/* ---- from a file ---- */

static struct pen_material material_of(const struct pen_model_material *from)
{
    struct pen_material m = pen_material_default();
    const double through = 1 - (double)from->opacity;
#define RGB(c) pen_vec3((double)(c)[0], (double)(c)[1], (double)(c)[2])
    m.kd = m.ka = pen_scale(RGB(from->diffuse), 1 - through);
    m.ks = RGB(from->specular);
    m.emission = RGB(from->emission);
#undef RGB
    m.shininess = (double)from->shininess;
    m.kt = pen_vec3(through, through, through);
    if (through > 0 && from->ior > 0) {
        m.ior = (double)from->ior;
        m.ior_written = true;
    }
    return m;
}

/* Takes the file's materials, unless the object has one. */
static bool take_materials(struct pen_reader *r, const struct pen_model *model, int own,
                           struct pen_mesh_desc *mesh)
{
    const uint32_t count = own >= 0 || model->material_count == 0 ? 1 : model->material_count;
    int *material = pen_reader_alloc(r, count, sizeof *material);
    if (!material)
        return false;
    material[0] = own;
    mesh->material = material;
    mesh->material_count = count;
    if (own >= 0 || model->material_count == 0)
        return true;
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_material m = material_of(&model->material[i]);
        if (!pen_material_add(r, &m, &material[i]))
            return false;
    }
    if (count > 1)
        mesh->material_of = model->material_of;
    return true;
}

static const void *copy(struct pen_reader *r, const void *from, size_t count, size_t size, bool *ok)
{
    void *to = from ? pen_reader_alloc(r, count, size) : NULL;
    if (to)
        memcpy(to, from, count * size);
    *ok &= to || !from;
    return to;
}

/* Takes the file's normals. Their numbers by corner are left out if they are those of vertices. */
static bool take_normals(struct pen_reader *r, const struct pen_model *model,
                         struct pen_mesh_desc *mesh)
{
    const size_t triangles = model->triangle_count, bytes = triangles * sizeof *model->corner;
    bool ok = true;
    mesh->normal = copy(r, model->normal, model->normal_count, sizeof *model->normal, &ok);
    mesh->normal_count = model->normal_count;
    if (model->corner_normal && memcmp(model->corner_normal, model->corner, bytes) != 0)
        mesh->corner_normal =
            copy(r, model->corner_normal, triangles, sizeof *model->corner_normal, &ok);
    return ok;
}

static bool take_model(struct pen_reader *r, const struct pen_model *model, int own, bool smooth,
                       struct pen_mesh_desc *mesh)
{
    if (!take_materials(r, model, own, mesh))
        return false;
    bool ok = !smooth || !model->normal || take_normals(r, model, mesh);
    mesh->vertex = copy(r, model->vertex, model->vertex_count, sizeof *model->vertex, &ok);
    mesh->corner = copy(r, model->corner, model->triangle_count, sizeof *model->corner, &ok);
    mesh->material_of =
        copy(r, mesh->material_of, model->triangle_count, sizeof *mesh->material_of, &ok);
    mesh->vertex_count = model->vertex_count;
    mesh->triangle_count = model->triangle_count;
    memcpy(mesh->shift, model->shift, sizeof mesh->shift);
    return ok;
}

/* ":LINE:COLUMN", or nothing if the status has no line. */
static const char *line_of(const struct pen_status *st, char out[48])
{
    out[0] = '\0';
    if (st->line > 0)
        snprintf(out, 48, ":%d:%d", st->line, st->column);
    return out;
}

static void note(struct pen_reader *r, const struct pen_place *at, const char *file,
                 const struct pen_errors *notes)
{
    struct pen_errors *errors = r->errors;
    char line[48];
    r->errors = r->model_notes;
    for (size_t i = 0; i < notes->count; i++)
        pen_reader_fail(r, at, PEN_OK, "%.100s%s: %s", file, line_of(&notes->item[i], line),
                        notes->item[i].msg);
    r->errors = errors;
}

static bool read_file(struct pen_reader *r, const struct pen_place *at, const char *file, int own,
                      bool smooth, struct pen_mesh_desc *mesh)
{
    struct pen_models *models = r->limits->models;
    struct pen_model model = {0};
    struct pen_errors notes = {0};
    struct pen_status st;
    if (!models)
        return pen_reader_fail(r, at, PEN_INVALID,
                               "names a file, which only penumbra on the machine that has it can "
                               "read; a daemon opens no files. Write positions and faces");
    bool ok = pen_models_read(models, file, &model, &notes, &st);
    if (ok) {
        ok = take_model(r, &model, own, smooth, mesh);
        note(r, at, file, &notes);
    } else {
        char line[48];
        pen_reader_fail(r, at, st.code, "%.100s%s: %s", file, line_of(&st, line), st.msg);
    }
    pen_model_release(&model);
    return ok;
}

bool pen_mesh_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                   struct pen_object_desc *object)
{
    struct mesh_target target = {.smooth = true};
    struct pen_mesh_desc *mesh = pen_reader_alloc(r, 1, sizeof *mesh);
    int *material = pen_reader_alloc(r, 1, sizeof *material);
    if (!mesh || !material)
        return false;
    bool ok = pen_fields_read_whole(r, at, json, pen_mesh_fields, &target);
    object->name = target.name;
    object->u.mesh = mesh;
    material[0] = object->material;
    mesh->material = material;
    mesh->material_count = 1;
    const struct pen_place file_at = pen_place_key(at, "file"),
                           normals_at = pen_place_key(at, "normals");
    if (target.file && (json_object_get(json, "positions") || json_object_get(json, "faces")))
        return pen_reader_fail(r, &file_at, PEN_INVALID,
                               "must not stand beside positions or faces");
    if (target.file && json_object_get(json, "normals"))
        return pen_reader_fail(r, &normals_at, PEN_INVALID,
                               "must not stand beside file, whose own normals count");
    if (target.file)
        return read_file(r, &file_at, target.file, object->material, target.smooth, mesh) && ok;
    if (!json_object_get(json, "positions"))
        return pen_reader_missing(r, at, "file", "positions");
    ok &= read_inline(r, at, json, mesh);
    if (!target.smooth)
        mesh->normal = NULL;
    return ok;
}

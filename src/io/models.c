/* SPDX-License-Identifier: MIT */
/* Reading models by name, and the scene of a model. */
#include "io/models.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/document.h"
#include "math/box.h"

/* The files beside a model: names in it are relative to its own folder. */
struct beside {
    const struct pen_models *models;
    const char *model;
};

static bool fetch_beside(void *self, const char *name, struct pen_buf *out, struct pen_status *st)
{
    const struct beside *beside = self;
    const char *slash = strrchr(beside->model, '/');
    struct pen_buf path = {0};
    bool ok = (!slash || pen_buf_add(&path, beside->model, (size_t)(slash - beside->model) + 1)) &&
              pen_buf_puts(&path, name);
    ok = ok ? beside->models->fetch(beside->models->self, (const char *)path.data, out, st)
            : pen_fail(st, PEN_NO_MEMORY, "out of memory");
    pen_buf_release(&path);
    return ok;
}

static bool read_file(const struct pen_models *models, const char *name, struct pen_model *model,
                      struct pen_errors *notes, struct pen_status *st)
{
    struct beside beside = {models, name};
    struct pen_buf bytes = {0};
    struct pen_model_file file = {.kind = pen_model_kind_of_name(name),
                                  .max_triangles = models->max_triangles,
                                  .fetch = fetch_beside,
                                  .self = &beside};
    if (file.kind == PEN_MODEL_NONE)
        return pen_fail(st, PEN_UNSUPPORTED,
                        "\"%.100s\" is no model: its name must end in .ply, .obj or .stl", name);
    if (!pen_model_name_is_inside(name))
        return pen_fail(
            st, PEN_FORBIDDEN,
            "\"%.100s\" leads out of the scene's folder; a name must be relative to it, "
            "without ..",
            name);
    bool ok = models->fetch(models->self, name, &bytes, st);
    file.data = bytes.data;
    file.bytes = bytes.bytes;
    ok = ok && pen_model_read(&file, model, notes, st);
    pen_buf_release(&bytes);
    return ok;
}

bool pen_models_read(struct pen_models *models, const char *name, struct pen_model *model,
                     struct pen_errors *notes, struct pen_status *st)
{
    *model = (struct pen_model){0};
    if (!models->known_name || strcmp(models->known_name, name) != 0)
        return read_file(models, name, model, notes, st);
    *model = models->known;
    models->known = (struct pen_model){0};
    for (size_t i = 0; i < models->known_notes->count; i++)
        pen_errors_add(notes, &models->known_notes->item[i]);
    pen_models_release(models);
    return true;
}

void pen_models_release(struct pen_models *models)
{
    pen_model_release(&models->known);
    free(models->known_notes);
    free(models->known_name);
    models->known_notes = NULL;
    models->known_name = NULL;
}

struct sphere {
    struct pen_vec3 center;
    double radius;
};

static struct pen_vec3 vertex_of(const struct pen_model *model, uint32_t i)
{
    const float *v = model->vertex[i];
    return pen_vec3(model->shift[0] + (double)v[0], model->shift[1] + (double)v[1],
                    model->shift[2] + (double)v[2]);
}

/* A sphere around all triangles: its centre is that of their box. */
static struct sphere sphere_around(const struct pen_model *model)
{
    struct pen_box box = pen_box_empty();
    for (uint32_t t = 0; t < model->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            box = pen_box_add_point(box, vertex_of(model, model->corner[t][k]));
    struct sphere s = {pen_box_center(box), 0};
    for (uint32_t t = 0; t < model->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            const struct pen_vec3 v = pen_sub(vertex_of(model, model->corner[t][k]), s.center);
            const double square = pen_dot(v, v);
            s.radius = square > s.radius ? square : s.radius;
        }
    s.radius = sqrt(s.radius);
    return s;
}

/* A vector given by right, up and towards the viewer, in the model's axes. */
static struct pen_vec3 in_axes(bool z_up, double right, double up, double front)
{
    return z_up ? pen_vec3(right, 0 - front, up) : pen_vec3(right, up, front);
}

static json_t *json_of(struct pen_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

static json_t *camera_of(const struct sphere *s, bool z_up)
{
    const double fov = 40, sine_of_half = 0.34202014332566873;
    const struct pen_vec3 towards = in_axes(z_up, 0.5, 0.4, 1); /* from the model to the camera */
    const double distance = s->radius / sine_of_half;
    const struct pen_vec3 eye = pen_along(s->center, towards, distance / pen_length(towards));
    return json_pack("{s:o, s:o, s:o, s:f}", "position", json_of(eye), "look_at",
                     json_of(s->center), "up", json_of(in_axes(z_up, 0, 1, 0)), "fov_degrees", fov);
}

static json_t *light_of(struct pen_vec3 direction, double r, double g, double b, bool shadows)
{
    return json_pack("{s:s, s:o, s:[f, f, f], s:b}", "type", "directional", "direction",
                     json_of(direction), "intensity", r, g, b, "shadows", shadows);
}

static json_t *scene_of(const struct pen_model *model, const char *name, bool z_up)
{
    const struct sphere s = sphere_around(model);
    json_t *object = json_pack("{s:s, s:s}", "type", "mesh", "file", name);
    if (model->material_count == 0)
        json_object_set_new(
            object, "material",
            json_pack("{s:f, s:f, s:f, s:f}", "ka", 0.7, "kd", 0.7, "ks", 0.1, "shininess", 20.0));
    return json_pack("{s:s, s:s, s:[f, f, f], s:[f, f, f], s:o, s:[o, o], s:[o]}", "format",
                     "penumbra-scene/1", "name", name, "background", 0.85, 0.88, 0.92, "ambient",
                     0.12, 0.12, 0.13, "camera", camera_of(&s, z_up), "lights",
                     light_of(in_axes(z_up, 0.6, -1.0, -0.8), 0.85, 0.83, 0.8, true),
                     light_of(in_axes(z_up, -1.0, -0.2, -0.5), 0.25, 0.26, 0.3, false), "objects",
                     object);
}

/* Keeps the model for the reader of the scene. */
static bool keep(struct pen_models *models, const char *name, struct pen_model *model,
                 const struct pen_errors *notes)
{
    pen_models_release(models);
    models->known_name = strdup(name);
    models->known_notes = malloc(sizeof *notes);
    if (!models->known_name || !models->known_notes) {
        pen_models_release(models);
        return false;
    }
    *models->known_notes = *notes;
    models->known = *model;
    *model = (struct pen_model){0};
    return true;
}

bool pen_models_scene(struct pen_models *models, const char *name, char up, struct pen_buf *out,
                      struct pen_status *st)
{
    struct pen_model model = {0};
    struct pen_errors notes = {0};
    if (!pen_utf8_is_valid(name, strlen(name)))
        return pen_fail(st, PEN_INVALID, "the file's name is not UTF-8; rename it");
    if (!read_file(models, name, &model, &notes, st))
        return false;
    const bool z_up = up == 'z' || (up == 0 && pen_model_kind_of_name(name) == PEN_MODEL_STL);
    json_t *scene = scene_of(&model, name, z_up);
    const bool ok = scene && pen_json_write(scene, out) && keep(models, name, &model, &notes);
    json_decref(scene);
    pen_model_release(&model);
    return ok || pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

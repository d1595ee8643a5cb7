/* SPDX-License-Identifier: MIT */
/* The oracle's reader: from the JSON tree of a scene file to primitives in world space. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "support/oracle.h"
#include "support/oracle_parts.h"

struct map {
    struct point x, y, z, shift; /* where the unit vectors and the origin are mapped */
};

static const struct map stay = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};

static struct point map_way(const struct map *m, struct point v)
{
    return point_sum(point_times(m->x, v.x),
                     point_sum(point_times(m->y, v.y), point_times(m->z, v.z)));
}
static struct point map_point(const struct map *m, struct point p)
{
    return point_sum(map_way(m, p), m->shift);
}
static real map_scale(const struct map *m)
{
    return cbrtl(fabsl(point_dot(m->x, point_cross(m->y, m->z))));
}
static struct map map_both(const struct map *outer, const struct map *inner)
{
    return (struct map){map_way(outer, inner->x), map_way(outer, inner->y),
                        map_way(outer, inner->z), map_point(outer, inner->shift)};
}

static real number_or(const json_t *o, const char *key, real otherwise)
{
    const json_t *v = json_object_get(o, key);
    return v ? (real)json_number_value(v) : otherwise;
}

static struct point triple(const json_t *v)
{
    return (struct point){json_number_value(json_array_get(v, 0)),
                          json_number_value(json_array_get(v, 1)),
                          json_number_value(json_array_get(v, 2))};
}

/* A triple, or one number three times. */
static struct point triple_or(const json_t *o, const char *key, real otherwise)
{
    const json_t *v = json_object_get(o, key);
    if (json_is_array(v))
        return triple(v);
    real n = v ? (real)json_number_value(v) : otherwise;
    return (struct point){n, n, n};
}

/* A vector rotated about a unit axis by the right-hand rule. */
static struct point turned(struct point v, struct point axis, real degrees)
{
    real a = degrees * 3.14159265358979323846264338327950288L / 180;
    struct point along = point_times(axis, point_dot(axis, v));
    struct point across = point_difference(v, along);
    return point_sum(
        along, point_sum(point_times(across, cosl(a)), point_times(point_cross(axis, v), sinl(a))));
}

static struct map map_read(const json_t *t)
{
    struct map m = stay;
    const json_t *matrix = json_object_get(t, "matrix"), *turn = json_object_get(t, "rotate");
    if (matrix) {
        real n[12];
        for (size_t i = 0; i < 12; i++)
            n[i] = json_number_value(json_array_get(matrix, i));
        return (struct map){
            {n[0], n[4], n[8]}, {n[1], n[5], n[9]}, {n[2], n[6], n[10]}, {n[3], n[7], n[11]}};
    }
    real scale = number_or(t, "scale", 1);
    struct point *unit[3] = {&m.x, &m.y, &m.z};
    for (int i = 0; i < 3; i++) {
        if (turn)
            *unit[i] = turned(*unit[i], point_unit(triple(json_object_get(turn, "axis"))),
                              number_or(turn, "degrees", 0));
        *unit[i] = point_times(*unit[i], scale);
    }
    m.shift = triple_or(t, "translate", 0);
    return m;
}

static struct oracle_material material_read(const json_t *named, const json_t *m)
{
    if (json_is_string(m))
        m = json_object_get(named, json_string_value(m));
    return (struct oracle_material){.emission = triple_or(m, "emission", 0),
                                    .ka = triple_or(m, "ka", 1),
                                    .kd = triple_or(m, "kd", 0),
                                    .ks = triple_or(m, "ks", 0),
                                    .kt = triple_or(m, "kt", 0),
                                    .kr = triple_or(m, "kr", 0),
                                    .shininess = number_or(m, "shininess", 1),
                                    .ior = number_or(m, "ior", 1),
                                    .ior_written = json_object_get(m, "ior") != NULL,
                                    .reflection_blur = number_or(m, "reflection_blur", 0),
                                    .transmission_blur = number_or(m, "transmission_blur", 0)};
}

static struct oracle_primitive *body_add(struct oracle_scene *s)
{
    if (s->body_count == s->body_capacity) {
        int capacity = 2 * s->body_capacity + 16;
        struct oracle_primitive *grown = realloc(s->primitives, (size_t)capacity * sizeof *grown);
        if (!grown)
            return NULL;
        s->primitives = grown;
        s->body_capacity = capacity;
    }
    struct oracle_primitive *b = &s->primitives[s->body_count++];
    memset(b, 0, sizeof *b);
    return b;
}

/* Transforms the corners to world space; computes the normal by Newell's sum about the first. */
static bool ring_read(const json_t *o, const struct map *m, struct oracle_primitive *b)
{
    const json_t *list = json_object_get(o, "vertices");
    size_t count = json_array_size(list);
    b->kind = ORACLE_RING;
    b->corners = calloc(count, sizeof *b->corners);
    if (!b->corners)
        return false;
    b->count = (int)count;
    for (size_t i = 0; i < count; i++)
        b->corners[i] = map_point(m, triple(json_array_get(list, i)));
    b->origin = b->corners[0];
    for (int i = 1; i + 1 < b->count; i++)
        b->axis = point_sum(b->axis, point_cross(point_difference(b->corners[i], b->origin),
                                                 point_difference(b->corners[i + 1], b->origin)));
    b->axis = point_unit(b->axis);
    return true;
}

static bool body_read(const json_t *o, const struct map *m, struct oracle_primitive *b)
{
    const char *type = json_string_value(json_object_get(o, "type"));
    real scale = map_scale(m);
    b->radius = number_or(o, "radius", 0) * scale;
    b->height = number_or(o, "height", 0) * scale;
    b->top = number_or(o, "top_radius", 0) * scale;
    b->caps = !json_is_false(json_object_get(o, "caps"));
    if (!strcmp(type, "sphere")) {
        b->kind = ORACLE_SPHERE;
        b->origin = map_point(m, triple(json_object_get(o, "center")));
    } else if (!strcmp(type, "plane")) {
        struct point n = triple(json_object_get(o, "normal"));
        b->kind = ORACLE_PLANE;
        b->origin = map_point(m, triple(json_object_get(o, "point")));
        struct point side =
            fabsl(n.x) > fabsl(n.y) ? (struct point){-n.z, 0, n.x} : (struct point){0, n.z, -n.y};
        struct point u = map_way(m, side), v = map_way(m, point_cross(n, side));
        b->axis = point_unit(point_cross(u, v));
    } else if (!strcmp(type, "tube") || !strcmp(type, "cylinder") || !strcmp(type, "cone")) {
        b->kind = type[0] == 't'   ? ORACLE_INFINITE_CYLINDER
                  : type[1] == 'y' ? ORACLE_CYLINDER
                                   : ORACLE_CONE;
        const char *origin = type[0] == 't' ? "origin" : "base";
        b->origin = map_point(m, triple(json_object_get(o, origin)));
        b->axis = point_unit(map_way(m, triple(json_object_get(o, "axis"))));
    } else {
        return ring_read(o, m, b);
    }
    return true;
}

static bool objects_read(struct oracle_scene *s, const json_t *named, const json_t *list,
                         const struct map *outer)
{
    size_t i;
    const json_t *o;
    json_array_foreach(list, i, o)
    {
        const json_t *t = json_object_get(o, "transform");
        struct map inner = t ? map_read(t) : stay, both = map_both(outer, &inner);
        if (!strcmp(json_string_value(json_object_get(o, "type")), "group")) {
            if (!objects_read(s, named, json_object_get(o, "objects"), &both))
                return false;
            continue;
        }
        struct oracle_primitive *b = body_add(s);
        if (!b || !body_read(o, outer, b))
            return false;
        b->written = json_object_get(o, "material");
        b->material = material_read(named, b->written);
    }
    return true;
}

static bool lights_read(struct oracle_scene *s, const json_t *list)
{
    size_t i;
    const json_t *o;
    s->lights = calloc(json_array_size(list) + 1, sizeof *s->lights);
    if (!s->lights)
        return false;
    json_array_foreach(list, i, o)
    {
        struct oracle_light *l = &s->lights[s->light_count++];
        const char *type = json_string_value(json_object_get(o, "type"));
        const json_t *fade = json_object_get(o, "attenuation");
        struct point k = fade ? triple(fade) : (struct point){1, 0, 0};
        l->kind = type[0] == 'd' ? ORACLE_DIRECTIONAL : type[0] == 'p' ? ORACLE_POINT : ORACLE_SPOT;
        l->intensity = triple_or(o, "intensity", 0);
        l->position = triple_or(o, "position", 0);
        if (l->kind != ORACLE_POINT)
            l->direction = point_unit(triple(json_object_get(o, "direction")));
        l->kc = k.x;
        l->kl = k.y;
        l->kq = k.z;
        l->beam_exponent = number_or(o, "beam_exponent", 1);
        real spread = number_or(o, "angular_radius", 0) * 3.14159265358979323846264338327950288L;
        l->radius = l->kind == ORACLE_DIRECTIONAL ? tanl(spread / 180) : number_or(o, "radius", 0);
        l->shadows = !json_is_false(json_object_get(o, "shadows"));
    }
    return true;
}

static void frame_turn(struct oracle_scene *s, struct point axis, real degrees)
{
    axis = point_unit(axis);
    s->forward = turned(s->forward, axis, degrees);
    s->right = turned(s->right, axis, degrees);
    s->up = turned(s->up, axis, degrees);
}

static void camera_move(struct oracle_scene *s, const json_t *move)
{
    const json_t *by = json_object_get(move, "translate");
    const json_t *turn = json_object_get(move, "rotate"), *orbit = json_object_get(move, "orbit");
    if (by)
        s->eye = point_sum(s->eye, triple(by));
    if (turn) {
        const json_t *a = json_object_get(turn, "axis");
        const char *name = json_string_value(a);
        struct point axis = !name            ? triple(a)
                            : name[0] == 'f' ? s->forward
                            : name[0] == 'r' ? s->right
                                             : s->up;
        frame_turn(s, axis, number_or(turn, "degrees", 0));
    }
    if (orbit) {
        struct point target = triple(json_object_get(orbit, "target"));
        struct point axis = triple(json_object_get(orbit, "axis"));
        real degrees = number_or(orbit, "degrees", 0);
        struct point arm = point_difference(s->eye, target);
        s->eye = point_sum(target, turned(arm, point_unit(axis), degrees));
        frame_turn(s, axis, degrees);
    }
}

static void camera_read(struct oracle_scene *s, const json_t *c)
{
    const json_t *plane = json_object_get(c, "view_plane"), *at = json_object_get(c, "look_at");
    s->eye = triple(json_object_get(c, "position"));
    s->forward = point_unit(at ? point_difference(triple(at), s->eye)
                               : triple(json_object_get(c, "direction")));
    const json_t *up = json_object_get(c, "up");
    s->right = point_unit(point_cross(s->forward, up ? triple(up) : (struct point){0, 1, 0}));
    s->up = point_cross(s->right, s->forward);
    s->square_pixels = !plane;
    s->distance = plane ? number_or(plane, "distance", 1) : 1;
    s->plane_width = number_or(plane, "width", 0);
    real half = number_or(c, "fov_degrees", 50) * 3.14159265358979323846264338327950288L / 360;
    s->plane_height = plane ? number_or(plane, "height", 0) : 2 * tanl(half);
    s->aperture = number_or(c, "aperture_radius", 0);
    s->focus = number_or(c, "focus_distance", 1);
    size_t i;
    const json_t *move;
    json_array_foreach(json_object_get(c, "transforms"), i, move) camera_move(s, move);
}

/* The scene's camera with a view's overrides; a new object. */
static json_t *camera_of_view(const json_t *document, const char *view)
{
    json_t *camera = json_copy(json_object_get(document, "camera"));
    size_t i;
    const json_t *v;
    json_array_foreach(json_object_get(document, "views"), i, v)
    {
        if (!view || strcmp(view, json_string_value(json_object_get(v, "name"))) != 0)
            continue;
        json_t *changes = json_object_get(v, "camera");
        if (json_object_get(changes, "direction"))
            json_object_del(camera, "look_at");
        if (json_object_get(changes, "look_at"))
            json_object_del(camera, "direction");
        if (json_object_get(changes, "fov_degrees"))
            json_object_del(camera, "view_plane");
        json_object_update(camera, changes);
    }
    return camera;
}

static void background_read(struct oracle_scene *s, const json_t *document)
{
    const json_t *sky = json_object_get(json_object_get(document, "background"), "sky");
    if (!sky) {
        s->zenith = s->nadir = s->background = triple_or(document, "background", 0);
        s->sky_up = (struct point){0, 1, 0};
        return;
    }
    s->zenith = triple_or(sky, "zenith", 0);
    s->background = triple_or(sky, "horizon", 0);
    s->nadir = json_object_get(sky, "nadir") ? triple_or(sky, "nadir", 0) : s->background;
    s->sky_up = (struct point){0, 1, 0};
    if (json_object_get(sky, "up"))
        s->sky_up = point_unit(triple_or(sky, "up", 0));
}

static bool scene_read(struct oracle_scene *s, const char *view)
{
    const json_t *render = json_object_get(s->document, "render");
    json_t *camera = camera_of_view(s->document, view);
    background_read(s, s->document);
    s->ambient = triple_or(s->document, "ambient", 0);
    s->max_depth = (int)number_or(render, "max_depth", 10);
    s->min_contribution = number_or(render, "min_contribution", 0.001L);
    s->tie = 1e-9L;
    camera_read(s, camera);
    json_decref(camera);
    return lights_read(s, json_object_get(s->document, "lights")) &&
           objects_read(s, json_object_get(s->document, "materials"),
                        json_object_get(s->document, "objects"), &stay);
}

struct oracle_scene *oracle_load(const char *path, const char *view)
{
    struct oracle_scene *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->document = json_load_file(path, JSON_REJECT_DUPLICATES, NULL);
    if (s->document && scene_read(s, view)) {
        oracle_solids_find(s);
        return s;
    }
    oracle_free(s);
    return NULL;
}

void oracle_free(struct oracle_scene *s)
{
    if (!s)
        return;
    for (int i = 0; i < s->body_count; i++)
        free(s->primitives[i].corners);
    free(s->primitives);
    free(s->lights);
    json_decref(s->document);
    free(s);
}

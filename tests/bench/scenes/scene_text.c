/* SPDX-License-Identifier: MIT */
#include "bench/scenes/scene_text.h"

#include <string.h>

static void put_vec(struct scene_text *s, const char *key, struct pen_vec3 v)
{
    fprintf(s->out, "\"%s\": [%.17g, %.17g, %.17g]", key, v.x, v.y, v.z);
}

void scene_begin(struct scene_text *s, const char *name, struct pen_vec3 background,
                 struct pen_vec3 ambient, const struct scene_view *view)
{
    *s = (struct scene_text){.out = stdout, .section = ""};
    fprintf(s->out, "{\"format\": \"penumbra-scene/1\", \"name\": \"%s\",\n ", name);
    put_vec(s, "background", background);
    fputs(", ", s->out);
    put_vec(s, "ambient", ambient);
    fputs(",\n \"camera\": {", s->out);
    put_vec(s, "position", view->eye);
    fputs(", ", s->out);
    put_vec(s, "look_at", view->at);
    fputs(", ", s->out);
    put_vec(s, "up", view->up);
    fprintf(s->out, ",\n  \"view_plane\": {\"distance\": 1, \"width\": %.17g, \"height\": %.17g}}",
            view->width, view->height);
}

/* Closes the open list, and opens the one with this key between these brackets. */
static void enter(struct scene_text *s, const char *section, char open)
{
    if (strcmp(s->section, section) == 0)
        return;
    if (s->section[0])
        fputs(strcmp(s->section, "materials") == 0 ? "}" : "]", s->out);
    fprintf(s->out, ",\n \"%s\": %c", section, open);
    s->section = section;
    s->follows = false;
}

static void begin_member(struct scene_text *s)
{
    fputs(s->follows ? ",\n  " : "\n  ", s->out);
    s->follows = true;
}

void scene_material(struct scene_text *s, const char *name, struct scene_look look)
{
    enter(s, "materials", '{');
    begin_member(s);
    fprintf(s->out, "\"%s\": {", name);
    put_vec(s, "emission", look.emission);
    fputs(", ", s->out);
    put_vec(s, "ka", look.kd);
    fputs(", ", s->out);
    put_vec(s, "kd", look.kd);
    fprintf(s->out, ", \"ks\": %.17g, \"shininess\": %.17g, \"kt\": %.17g, \"kr\": %.17g", look.ks,
            look.shininess, look.kt, look.kr);
    if (look.ior > 0)
        fprintf(s->out, ", \"ior\": %.17g", look.ior);
    fputs("}", s->out);
}

void scene_light(struct scene_text *s, struct pen_vec3 position, struct pen_vec3 intensity,
                 double quadratic_attenuation, double radius)
{
    enter(s, "lights", '[');
    begin_member(s);
    fputs("{\"type\": \"point\", ", s->out);
    put_vec(s, "intensity", intensity);
    fputs(", ", s->out);
    put_vec(s, "position", position);
    fprintf(s->out, ", \"attenuation\": [1, 0, %.17g], \"radius\": %.17g}", quadratic_attenuation,
            radius);
}

void scene_use(struct scene_text *s, const char *material)
{
    s->material = material;
}

static void begin_object(struct scene_text *s, const char *type)
{
    enter(s, "objects", '[');
    begin_member(s);
    fprintf(s->out, "{\"type\": \"%s\", \"material\": \"%s\", ", type, s->material);
}

void scene_sphere(struct scene_text *s, struct pen_vec3 center, double radius)
{
    begin_object(s, "sphere");
    put_vec(s, "center", center);
    fprintf(s->out, ", \"radius\": %.17g}", radius);
}

void scene_tube(struct scene_text *s, struct pen_vec3 origin, struct pen_vec3 axis, double radius)
{
    begin_object(s, "tube");
    put_vec(s, "origin", origin);
    fputs(", ", s->out);
    put_vec(s, "axis", axis);
    fprintf(s->out, ", \"radius\": %.17g}", radius);
}

void scene_cone(struct scene_text *s, struct pen_vec3 from, struct pen_vec3 to, double radius)
{
    struct pen_vec3 axis = pen_sub(to, from);
    begin_object(s, "cone");
    put_vec(s, "base", from);
    fputs(", ", s->out);
    put_vec(s, "axis", axis);
    fprintf(s->out, ", \"radius\": %.17g, \"height\": %.17g}", radius, sqrt(pen_dot(axis, axis)));
}

void scene_cylinder(struct scene_text *s, struct pen_vec3 from, struct pen_vec3 to, double radius,
                    bool caps)
{
    struct pen_vec3 axis = pen_sub(to, from);
    begin_object(s, "cylinder");
    put_vec(s, "base", from);
    fputs(", ", s->out);
    put_vec(s, "axis", axis);
    fprintf(s->out, ", \"radius\": %.17g, \"height\": %.17g, \"caps\": %s}", radius,
            sqrt(pen_dot(axis, axis)), caps ? "true" : "false");
}

void scene_polygon(struct scene_text *s, const struct pen_vec3 *vertex, int count)
{
    begin_object(s, count == 3 ? "triangle" : "polygon");
    fputs("\"vertices\": [", s->out);
    for (int i = 0; i < count; i++)
        fprintf(s->out, "%s[%.17g, %.17g, %.17g]", i ? ", " : "", vertex[i].x, vertex[i].y,
                vertex[i].z);
    fputs("]}", s->out);
}

void scene_quad(struct scene_text *s, struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c,
                struct pen_vec3 d)
{
    struct pen_vec3 vertex[4] = {a, b, c, d};
    scene_polygon(s, vertex, 4);
}

void scene_box(struct scene_text *s, struct pen_vec3 lo, struct pen_vec3 hi)
{
    static const int face[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; f++) {
        struct pen_vec3 v[4];
        for (int i = 0; i < 4; i++) {
            int corner = face[f][i];
            v[i] = pen_vec3(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y,
                            corner & 4 ? hi.z : lo.z);
        }
        scene_polygon(s, v, 4);
    }
}

void scene_end(struct scene_text *s, const char *render)
{
    enter(s, "objects", '[');
    fprintf(s->out, "],\n \"render\": {%s}}\n", render);
}

/* SPDX-License-Identifier: MIT */
#include "study/explain.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "io/figures.h"
#include "io/json_build.h"

enum { NAMED = 4, KINDS = 5 };

static bool is_lit(struct pen_vec3 c)
{
    return c.x > 0 || c.y > 0 || c.z > 0;
}

/* Whether a material shows an effect; smooth normals, on a mesh that has normals. */
static bool shows(const struct pen_material *m, enum pen_effect effect)
{
    const bool reflects = is_lit(m->kr), transmits = is_lit(m->kt),
               refracts = transmits && m->ior != 1;
    return (effect == PEN_FX_AMBIENT && is_lit(m->ka)) ||
           (effect == PEN_FX_SPECULAR && is_lit(m->ks)) || (effect == PEN_FX_MIRROR && reflects) ||
           (effect & (PEN_FX_TRANSMISSION | PEN_FX_SHADOW_TRANSMITTANCE) && transmits) ||
           (effect == PEN_FX_REFRACTION && refracts) ||
           (effect == PEN_FX_GLOSSY && m->reflection_blur > 0 && (reflects || refracts)) ||
           (effect == PEN_FX_FROSTED && m->transmission_blur > 0 && transmits) ||
           (effect == PEN_FX_PATTERNS && pen_material_is_patterned(m)) ||
           (effect == PEN_FX_SMOOTH_NORMALS && (is_lit(m->kd) || is_lit(m->ks)));
}

/* The property of a material that shows the effect; NULL if no material shows it. */
static const char *property(enum pen_effect effect)
{
    static const struct {
        unsigned effects;
        const char *property;
    } properties[] = {{PEN_FX_AMBIENT, "ka > 0"},
                      {PEN_FX_SPECULAR, "ks > 0"},
                      {PEN_FX_MIRROR, "kr > 0"},
                      {PEN_FX_TRANSMISSION | PEN_FX_SHADOW_TRANSMITTANCE, "kt > 0"},
                      {PEN_FX_REFRACTION, "kt > 0 and an ior other than 1"},
                      {PEN_FX_GLOSSY, "a reflection_blur above 0 where they reflect"},
                      {PEN_FX_FROSTED, "a transmission_blur above 0 and kt > 0"},
                      {PEN_FX_PATTERNS, "patterns"},
                      {PEN_FX_SMOOTH_NORMALS, "normals, and kd or ks > 0"}};
    for (size_t i = 0; i < sizeof properties / sizeof properties[0]; i++)
        if (properties[i].effects & effect)
            return properties[i].property;
    return NULL;
}

/* The objects that show an effect: their first distinct names, and the number of objects with other
 * names. */
struct objects {
    const struct pen_scene_desc *desc;
    enum pen_effect effect;
    const atomic_bool *seen; /* by primitive number */
    /* Objects found; primitives passed; objects found but not named; objects found and seen. */
    uint32_t count, primitive, more, seen_count;
    const char *name[NAMED]; /* NULL: no name */
    int named;
    struct pen_buf names;
};

static bool is_named(const struct objects *found, const char *name)
{
    for (int i = 0; name && i < found->named; i++)
        if (found->name[i] && strcmp(found->name[i], name) == 0)
            return true;
    return false;
}

/* Adds an object that shows the effect. If it has no name, `number` identifies it. */
static void add_object(struct objects *found, const char *kind, const char *name, uint32_t number)
{
    found->count++;
    if (is_named(found, name))
        return;
    if (found->named == NAMED) {
        found->more++;
        return;
    }
    pen_buf_puts(&found->names, found->named ? ", " : "");
    if (name)
        pen_buf_puts(&found->names, name);
    else
        pen_buf_printf(&found->names, "%s %u", kind, (unsigned)number);
    found->name[found->named++] = name;
}

/* Whether an object, which is no group, shows the effect with one of its materials. */
static bool object_shows(const struct objects *found, const struct pen_object_desc *o)
{
    const struct pen_material none = pen_material_default();
    const bool mesh = o->kind == PEN_OBJECT_MESH;
    const int *material = mesh ? o->u.mesh->material : &o->material;
    const uint32_t count = mesh ? o->u.mesh->material_count : 1;
    if (found->effect == PEN_FX_SMOOTH_NORMALS && !(mesh && o->u.mesh->normal))
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (shows(material[i] < 0 ? &none : &found->desc->materials[material[i]], found->effect))
            return true;
    return false;
}

static void find_objects(struct objects *found, const struct pen_object_desc *list, uint32_t count,
                         const char *group)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *o = &list[i];
        if (o->kind == PEN_OBJECT_GROUP) {
            find_objects(found, o->u.group.objects, o->u.group.count, o->name ? o->name : group);
            continue;
        }
        if (o->left_out)
            continue;
        const bool mesh = o->kind == PEN_OBJECT_MESH;
        const uint32_t number = found->primitive;
        found->primitive += mesh ? o->u.mesh->triangle_count : 1;
        if (!object_shows(found, o))
            continue;
        bool seen = false;
        for (uint32_t k = number; k < found->primitive && !seen; k++)
            seen = atomic_load_explicit(&found->seen[k], memory_order_relaxed);
        found->seen_count += seen;
        add_object(found, mesh ? "mesh" : pen_kinds[o->kind].name, o->name ? o->name : group,
                   number);
    }
}

/* Appends to a sentence how many of its objects the view sees directly. */
static void say_seen(const struct objects *found, const char *view, struct pen_buf *out)
{
    const uint32_t seen = found->seen_count, count = found->count;
    if (seen == count)
        pen_buf_printf(out, " and %s visible from view %s", count > 1 ? "are" : "is", view);
    else if (seen == 0)
        pen_buf_printf(out, ", which no camera ray of the pre-render meets");
    else
        pen_buf_printf(out, ", and %u of their %u primitives %s visible from view %s",
                       (unsigned)seen, (unsigned)count, seen > 1 ? "are" : "is", view);
}

/* "objects a, b and 3 more have kr > 0 and are visible from view main", or "no object has kr > 0".
 */
static void say_objects(const struct pen_explain_task *task, enum pen_effect effect,
                        struct pen_buf *out)
{
    const struct pen_scene_desc *desc = task->desc;
    struct objects found = {.desc = desc, .effect = effect, .seen = task->forecast->seen};
    find_objects(&found, desc->objects, desc->object_count, NULL);
    if (found.count == 0)
        pen_buf_printf(out, "no object has %s", property(effect));
    else
        pen_buf_printf(out, "object%s %s", found.count > 1 ? "s" : "",
                       (const char *)found.names.data);
    if (found.more > 0)
        pen_buf_printf(out, " and %u more", (unsigned)found.more);
    if (found.count > 0)
        pen_buf_printf(out, " ha%s %s", found.count > 1 ? "ve" : "s", property(effect));
    if (found.count > 0)
        say_seen(&found, desc->views[task->view].name, out);
    out->failed |= found.names.failed;
    pen_buf_release(&found.names);
}

static bool has_objects(const struct pen_explain_task *task, enum pen_effect effect)
{
    const struct pen_scene_desc *desc = task->desc;
    struct objects found = {.desc = desc, .effect = effect, .seen = task->forecast->seen};
    find_objects(&found, desc->objects, desc->object_count, NULL);
    pen_buf_release(&found.names);
    return found.count > 0;
}

static uint32_t lights_with(const struct pen_scene_desc *desc, bool soft)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < desc->light_count; i++)
        count += is_lit(desc->lights[i].intensity) && desc->lights[i].shadows &&
                 pen_light_desc_soft(&desc->lights[i]) == soft;
    return count;
}

static void say_shadows(const struct pen_scene_desc *desc, bool soft, struct pen_buf *out)
{
    const uint32_t count = lights_with(desc, soft);
    const char *radius = soft ? "with a radius" : "without a radius";
    if (count == 0)
        pen_buf_printf(out, "no light %s casts shadows", radius);
    else
        pen_buf_printf(out, "%u light%s %s cast%s shadows", (unsigned)count, count > 1 ? "s" : "",
                       radius, count > 1 ? "" : "s");
}

/* Why the scene calls for an effect, or does not. */
static void say_why(const struct pen_explain_task *task, enum pen_effect effect, bool called_for,
                    struct pen_buf *out)
{
    const struct pen_scene_desc *desc = task->desc;
    const struct pen_camera_desc *camera = &desc->views[task->view].camera;
    const bool secondary = effect & (PEN_FX_MIRROR | PEN_FX_TRANSMISSION | PEN_FX_REFRACTION |
                                     PEN_FX_GLOSSY | PEN_FX_FROSTED);
    if (secondary && task->settings->max_depth <= 1)
        pen_buf_puts(out, "max_depth is 1");
    else if (property(effect))
        say_objects(task, effect, out);
    else if (effect == PEN_FX_HARD_SHADOWS || effect == PEN_FX_SOFT_SHADOWS)
        say_shadows(desc, effect == PEN_FX_SOFT_SHADOWS, out);
    else if (effect == PEN_FX_ANTI_ALIASING && pen_settings_adaptive(task->settings))
        pen_buf_printf(out, "target_error is %g", task->settings->target_error);
    else if (effect == PEN_FX_ANTI_ALIASING)
        pen_buf_printf(out, "a pixel has %d camera ray%s",
                       pen_camera_samples(camera->aperture_radius > 0, task->settings),
                       called_for ? "s" : "");
    else if (effect == PEN_FX_SKY)
        pen_buf_puts(out, called_for ? "the background is a sky" : "the background has one colour");
    else
        pen_buf_printf(out, "aperture_radius is %g", camera->aperture_radius);
    if (secondary && !called_for && task->settings->max_depth > 1 && has_objects(task, effect))
        pen_buf_puts(out, "; too little, in all of them, for min_contribution");
    if (effect == PEN_FX_AMBIENT && !is_lit(desc->ambient))
        pen_buf_puts(out, "; there is no ambient light");
    if (effect == PEN_FX_SHADOW_TRANSMITTANCE && !called_for &&
        lights_with(desc, false) + lights_with(desc, true) == 0)
        pen_buf_puts(out, "; no light casts shadows");
}

/* The share of all rays that are of the effect's kind. */
static double rays_share(const struct pen_forecast *f, enum pen_effect effect)
{
    double rays = 0;
    if (effect & (PEN_FX_HARD_SHADOWS | PEN_FX_SOFT_SHADOWS))
        rays = f->shadow.expected;
    if (effect & (PEN_FX_MIRROR | PEN_FX_GLOSSY))
        rays = f->reflection.expected;
    if (effect & (PEN_FX_TRANSMISSION | PEN_FX_REFRACTION | PEN_FX_FROSTED))
        rays = f->transmission.expected;
    if (effect & (PEN_FX_ANTI_ALIASING | PEN_FX_DEPTH_OF_FIELD))
        rays = f->primary.expected;
    return f->total.expected > 0 ? rays / f->total.expected : 0;
}

static json_t *effects_json(const struct pen_explain_task *task, bool called_for)
{
    json_t *list = json_array();
    size_t count = 0;
    for (int i = 0; i < PEN_FX_COUNT; i++) {
        const enum pen_effect effect = (enum pen_effect)(1 << i);
        struct pen_buf why = {0};
        if ((task->forecast->effects >> i & 1) != called_for)
            continue;
        say_why(task, effect, called_for, &why);
        json_t *item = why.failed ? NULL
                                  : json_pack("{s:s, s:s}", "name", pen_effect_name(i), "because",
                                              (const char *)why.data);
        if (called_for)
            item =
                pen_json_with(item, "rays_share", pen_figure(rays_share(task->forecast, effect)));
        json_array_append_new(list, item);
        pen_buf_release(&why);
        count++;
    }
    return pen_json_all(list, count);
}

static json_t *estimate_json(const struct pen_estimate *e, const double *actual)
{
    json_t *json = json_pack("{s:o, s:o, s:o}", "expected", pen_figure(e->expected), "low",
                             pen_figure(e->low), "high", pen_figure(e->high));
    return actual ? pen_json_with(json, "actual", pen_figure(*actual)) : json;
}

static json_t *rays_json(const struct pen_explain_task *task)
{
    static const char *const names[KINDS] = {"primary", "shadow", "reflection", "transmission",
                                             "total"};
    const struct pen_forecast *f = task->forecast;
    const struct pen_estimate *of[KINDS] = {&f->primary, &f->shadow, &f->reflection,
                                            &f->transmission, &f->total};
    double actual[KINDS] = {0};
    if (task->actual) {
        const struct pen_ray_counts *r = &task->actual->rays;
        actual[0] = (double)r->primary;
        actual[1] = (double)r->shadow;
        actual[2] = (double)r->reflection;
        actual[3] = (double)r->transmission;
        actual[4] = actual[0] + actual[1] + actual[2] + actual[3];
    }
    json_t *json = json_object();
    for (int i = 0; i < KINDS; i++)
        json =
            pen_json_with(json, names[i], estimate_json(of[i], task->actual ? &actual[i] : NULL));
    return json;
}

json_t *pen_explain_json(const struct pen_explain_task *task)
{
    const struct pen_forecast *f = task->forecast;
    const double *ms = task->actual ? &task->actual->render_ms : NULL,
                 *cpu_ms = task->actual ? &task->actual->cpu_ms : NULL;
    /* By the clock: low is the time without other programs, high the time beside them. */
    const struct pen_estimate time_ms = {f->time_ms.expected / f->used, f->time_ms.low,
                                         f->time_ms.high / f->used};
    return json_pack("{s:s, s:o, s:o, s:s, s:o, s:o, s:o, s:o, s:o, s:{s:i, s:o}}", "view",
                     task->desc->views[task->view].name, "effects", effects_json(task, true),
                     "absent", effects_json(task, false), "kernel", f->kernel, "rays",
                     rays_json(task), "cpu_ms", estimate_json(&f->cpu_ms, cpu_ms), "time_ms",
                     estimate_json(&time_ms, ms), "load", pen_figure(1 - f->used), "memory_bytes",
                     pen_figure(f->memory_bytes), "pre_render", "pixels", f->pixels, "ms",
                     pen_figure(f->spent_ms));
}

/* Writes a text in lines from this column up to the 80th column of a terminal. */
static void write_wrapped(const char *text, int column, struct pen_buf *out)
{
    enum { COLUMNS = 80 };
    int at = column;
    while (*text) {
        const size_t bytes = strcspn(text, " ");
        const int wide = (int)pen_utf8_columns(text, bytes);
        if (at > column && at + 1 + wide > COLUMNS) {
            pen_buf_printf(out, "\n%*s", column, "");
            at = column;
        } else if (at > column) {
            pen_buf_puts(out, " ");
            at++;
        }
        pen_buf_add(out, text, bytes);
        at += wide;
        text += bytes;
        text += strspn(text, " ");
    }
    pen_buf_puts(out, "\n");
}

static void write_effects(const json_t *list, const char *title, struct pen_buf *out)
{
    size_t i;
    json_t *item;
    pen_buf_printf(out, "%s\n", title);
    json_array_foreach(list, i, item)
    {
        pen_buf_printf(out, "  %-20s ", json_string_value(json_object_get(item, "name")));
        write_wrapped(json_string_value(json_object_get(item, "because")), 23, out);
    }
}

/* A unit for numbers of at least `from`. */
struct unit {
    double from, one;
    const char *name;
};
static const struct unit ray_units[] = {{1e9, 1e9, "billion rays"},
                                        {1e6, 1e6, "million rays"},
                                        {1e4, 1e3, "thousand rays"},
                                        {0, 1, "rays"}};
static const struct unit time_units[] = {{1e3, 1e3, "s"}, {0, 1, "ms"}};

/* Writes an estimate with few digits: the ends of its interval differ by at least two in the last
 * digit. An exact number has all digits. */
static void write_estimate(const char *name, const json_t *e, const struct unit *unit,
                           struct pen_buf *out)
{
    const json_t *actual = json_object_get(e, "actual");
    double low = json_number_value(json_object_get(e, "low")),
           high = json_number_value(json_object_get(e, "high"));
    const bool exact = low == high;
    while (exact ? unit->from > 0 : high < unit->from)
        unit++;
    low /= unit->one;
    high /= unit->one;
    int digits = 0; /* decimals */
    for (double width = high - low; !exact && digits < 3 && width < 2; digits++)
        width *= 10;
    pen_buf_printf(out, "  %-20s %8.*f", name, digits,
                   json_number_value(json_object_get(e, "expected")) / unit->one);
    if (!exact)
        pen_buf_printf(out, "   %.*f to %.*f", digits, low, digits, high);
    pen_buf_printf(out, " %s", unit->name);
    if (actual)
        pen_buf_printf(out, "   actual %.*f", digits, json_number_value(actual) / unit->one);
    pen_buf_puts(out, "\n");
}

/* Writes the time by the clock: without other programs, and at the present load. There is no
 * interval, because nobody knows how long the load stays. */
static void write_clock(const json_t *explanation, struct pen_buf *out)
{
    const json_t *time = json_object_get(explanation, "time_ms"),
                 *actual = json_object_get(time, "actual");
    const double ms = json_number_value(json_object_get(time, "expected")),
                 load = json_number_value(json_object_get(explanation, "load"));
    const struct unit *unit = time_units;
    while (ms < unit->from)
        unit++;
    pen_buf_printf(out, "  %-20s %8.3g %s now (threads wait %.0f %%), %.3g alone",
                   "time by the clock", ms / unit->one, unit->name, 100 * load,
                   ms * (1 - load) / unit->one);
    if (actual)
        pen_buf_printf(out, "   actual %.3g", json_number_value(actual) / unit->one);
    pen_buf_puts(out, "\n");
}

void pen_explain_write_text(const json_t *explanation, struct pen_buf *out)
{
    const char *key;
    json_t *value;
    write_effects(json_object_get(explanation, "effects"), "calls for", out);
    write_effects(json_object_get(explanation, "absent"), "does not call for", out);
    pen_buf_printf(out, "kernel %s\nexpected, and its 95 %% interval\n",
                   json_string_value(json_object_get(explanation, "kernel")));
    json_object_foreach(json_object_get(explanation, "rays"), key, value)
    {
        write_estimate(key, value, ray_units, out);
    }
    write_estimate("processor time", json_object_get(explanation, "cpu_ms"), time_units, out);
    write_clock(explanation, out);
    const double mib = json_number_value(json_object_get(explanation, "memory_bytes")) / 0x1p20;
    pen_buf_printf(out, "  %-20s %8.*f MiB\n", "memory", mib < 10 ? 2 : mib < 100 ? 1 : 0, mib);
}

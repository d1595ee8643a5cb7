/* SPDX-License-Identifier: MIT */
/* Pictures for the rows of light and shadow. */
#include "property/shot.h"

#include <math.h>
#include <string.h>

#include "scene/precision.h"

void shot_begin(struct kit *kit)
{
    kit_init(kit);
    kit->settings.width = kit->settings.height = SHOT_SIDE;
}

void shot_look(struct kit *kit, struct pen_vec3 eye, struct pen_vec3 at, double wide)
{
    struct pen_camera_desc *camera = &kit->view.camera;
    struct pen_vec3 d = pen_sub(at, eye);
    bool steep = fabs(d.y) > fabs(d.x) && fabs(d.y) > fabs(d.z);
    camera->position = eye;
    camera->direction = d;
    camera->up = steep ? pen_vec3(1, 0, 0) : pen_vec3(0, 1, 0);
    camera->has_view_plane = true;
    camera->plane_distance = pen_length(d);
    camera->plane_width = camera->plane_height = wide;
}

double shot_take(struct kit *kit, float rgb[3 * SHOT_PIXELS])
{
    static struct pen_thread_pool *pool;
    struct pen_status st;
    struct pen_render_stats stats = {.threads = 0};
    struct pen_scene *scene = kit_freeze(kit);
    if (!pool)
        pool = pen_thread_pool_new(1, &st);
    memset(rgb, 0, 3 * SHOT_PIXELS * sizeof *rgb);
    struct pen_render_task task = {
        .scene = scene, .settings = &kit->settings, .tile_count = -1, .rgb = rgb};
    pen_render_run(pool, &task, &stats, &st);
    pen_scene_free(scene);
    return (double)stats.rays.shadow;
}

bool shot_warns(struct kit *kit)
{
    char warning[512];
    struct pen_scene_precision precision;
    struct pen_scene *scene = kit_freeze(kit);
    bool warns =
        pen_scene_precision(scene, 0, kit->settings.width, kit->settings.height, &precision) &&
        pen_precision_warning(&precision, warning, sizeof warning);
    pen_scene_free(scene);
    return warns;
}

int shot_lit(const float rgb[3 * SHOT_PIXELS])
{
    int count = 0;
    for (int i = 0; i < 3 * SHOT_PIXELS; i += 3)
        count += !(rgb[i] == 0 && rgb[i + 1] == 0 && rgb[i + 2] == 0);
    return count;
}

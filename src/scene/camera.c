/* SPDX-License-Identifier: MIT */
/* Cameras: from a description to a frame, and from a frame to the rays of an image. The frame is
 * made from the camera's keys; then the moves are applied in order. After every rotation the frame
 * is made orthonormal again, so rounding cannot skew the picture after any number of moves. */
#include "math/exact.h"
#include "math/fn.h"
#include "math/scale.h"
#include "scene/internal/vec.h"
#include "scene/scene.h"

/* The sine of the smallest accepted angle between view direction and `up`. At a smaller angle, the
 * rounding of the numbers in the document may decide where up is. */
static const double PARALLEL_SINE = 0x1p-40;

/* Makes right and up orthonormal to forward, a unit vector. Returns false if up is parallel to
 * forward. */
static bool orthonormalize(struct pen_camera_frame *frame, struct pen_vec3 up)
{
    struct pen_vec3 right = pen_cross(frame->forward, vec_normalize(up));
    if (!(pen_length(right) > PARALLEL_SINE))
        return false;
    frame->right = vec_normalize(right);
    frame->up = vec_normalize(pen_cross(frame->right, frame->forward));
    return true;
}

static void turn(struct pen_camera_frame *frame, struct pen_vec3 axis, double degrees)
{
    if (degrees == 0)
        return; /* the frame keeps its bits */
    frame->forward = vec_normalize(pen_rotate(frame->forward, axis, degrees));
    orthonormalize(frame, pen_rotate(frame->up, axis, degrees));
}

static struct pen_vec3 move_axis(const struct pen_camera_frame *frame,
                                 const struct pen_camera_move *move)
{
    switch (move->axis_kind) {
    case PEN_AXIS_FORWARD:
        return frame->forward;
    case PEN_AXIS_RIGHT:
        return frame->right;
    case PEN_AXIS_UP:
        return frame->up;
    case PEN_AXIS_VECTOR:
        break;
    }
    return vec_normalize(move->axis);
}

static void apply(struct pen_camera_frame *frame, const struct pen_camera_move *move)
{
    struct pen_vec3 axis, arm;
    switch (move->kind) {
    case PEN_MOVE_TRANSLATE:
        frame->eye = pen_add(frame->eye, move->vector);
        break;
    case PEN_MOVE_ROTATE:
        turn(frame, move_axis(frame, move), move->degrees);
        break;
    case PEN_MOVE_ORBIT:
        axis = vec_normalize(move->axis);
        arm = pen_sub(frame->eye, move->vector);
        frame->eye = pen_add(move->vector, pen_rotate(arm, axis, move->degrees));
        turn(frame, axis, move->degrees);
        break;
    }
}

/* Up for a view along y. A view from above shows x to the right and -z upward, as maps do. */
static struct pen_vec3 up_along_y(struct pen_vec3 direction)
{
    return pen_vec3(0, 0, direction.y < 0 ? -1 : 1);
}

bool pen_camera_frame_make(const struct pen_camera_desc *camera, struct pen_camera_frame *frame,
                           struct pen_status *st)
{
    struct pen_vec3 direction = camera->direction;
    if (camera->has_look_at)
        direction = pen_sub(camera->look_at, camera->position);
    if (!(vec_max_abs(direction) > 0) && camera->has_look_at)
        return pen_fail_at(st, PEN_INVALID, "/look_at", "is the same point as position");
    if (!(vec_max_abs(direction) > 0))
        return pen_fail_at(st, PEN_INVALID, "/direction", "has no length");
    if (!(vec_max_abs(camera->up) > 0))
        return pen_fail_at(st, PEN_INVALID, "/up", "has no length");
    if (!isfinite(vec_max_abs(direction)))
        return pen_fail_at(st, PEN_INVALID, "/look_at", "is too far from position");
    *frame =
        (struct pen_camera_frame){.eye = camera->position, .forward = vec_normalize(direction)};
    frame->other_up = camera->default_up && !orthonormalize(frame, camera->up);
    if (!orthonormalize(frame, frame->other_up ? up_along_y(direction) : camera->up))
        return pen_fail_at(st, PEN_INVALID, "/up", "is parallel to the view direction");
    for (uint32_t i = 0; i < camera->move_count; i++)
        apply(frame, &camera->moves[i]);
    return true;
}

struct pen_pinhole pen_scene_pinhole(const struct pen_scene *scene, int view, int width, int height)
{
    const struct pen_scene_view *v = &scene->views[view];
    const struct pen_camera_desc *camera = &v->camera;
    double distance = camera->plane_distance;
    double plane_width = camera->plane_width, plane_height = camera->plane_height;
    if (!camera->has_view_plane) {
        double sine, cosine;
        pen_sincos_deg(0.5 * camera->fov_degrees, &sine, &cosine);
        distance = cosine;
        plane_height = 2 * sine;
        plane_width = plane_height * width / height;
    }
    /* Directions may have any length. A power of two, which does not round, brings them near 1. */
    int exponent = pen_exponent(pen_larger(distance, pen_larger(plane_width, plane_height)));
    double step_x = pen_scale2(plane_width, -exponent) / width;
    double step_y = pen_scale2(plane_height, -exponent) / height;
    return (struct pen_pinhole){
        .eye = vec_scale2_down(pen_sub(v->frame.eye, scene->center), scene->exponent),
        .middle = pen_scale(v->frame.forward, pen_scale2(distance, -exponent)),
        .dx = pen_scale(v->frame.right, step_x),
        .dy = pen_scale(v->frame.up, -step_y),
        .half_width = 0.5 * width,
        .half_height = 0.5 * height,
    };
}

struct pen_lens pen_scene_lens(const struct pen_scene *scene, int view,
                               const struct pen_pinhole *pinhole)
{
    const struct pen_scene_view *v = &scene->views[view];
    const double radius = pen_scale2(v->camera.aperture_radius, -scene->exponent);
    const double focus = pen_scale2(v->camera.focus_distance, -scene->exponent);
    return (struct pen_lens){
        .open = v->camera.aperture_radius > 0,
        .right = pen_scale(v->frame.right, radius),
        .up = pen_scale(v->frame.up, radius),
        .focus = focus / pen_length(pinhole->middle),
    };
}

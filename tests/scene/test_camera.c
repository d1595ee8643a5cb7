/* SPDX-License-Identifier: MIT */
/* Cameras: frames, moves, and the rays of an image. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"
#include "support/suite.h"

static struct pen_camera_desc camera_at(struct pen_vec3 position, struct pen_vec3 direction)
{
    return (struct pen_camera_desc){
        .position = position,
        .direction = direction,
        .up = {0, 1, 0},
        .fov_degrees = 50,
    };
}

static struct pen_camera_frame frame_of(const struct pen_camera_desc *camera)
{
    struct pen_camera_frame frame;
    struct pen_status st;
    ck_assert(pen_camera_frame_make(camera, &frame, &st));
    return frame;
}

static void assert_vec(struct pen_vec3 got, double x, double y, double z)
{
    ck_assert_msg(got.x == x && got.y == y && got.z == z, "(%a %a %a) is not (%a %a %a)", got.x,
                  got.y, got.z, x, y, z);
}

static struct pen_pinhole pinhole_of(const struct pen_camera_desc *camera, int width, int height)
{
    struct pen_scene_view view = {.name = "main", .frame = frame_of(camera), .camera = *camera};
    struct pen_scene scene = {.views = &view, .view_count = 1};
    return pen_scene_pinhole(&scene, 0, width, height);
}

static struct pen_vec3 ray_through(const struct pen_pinhole *p, double px, double py)
{
    struct pen_vec3 d = pen_along(p->middle, p->dx, px - p->half_width);
    return pen_along(d, p->dy, py - p->half_height);
}

START_TEST(test_camera__frame_is_right_handed)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 100), pen_vec3(0, 0, -49));
    struct pen_camera_frame frame = frame_of(&camera);
    assert_vec(frame.forward, 0, 0, -1);
    assert_vec(frame.up, 0, 1, 0);
    assert_vec(frame.right, 1, 0, 0);
    assert_vec(frame.eye, 0, 0, 100);
}
END_TEST

START_TEST(test_camera__up_is_made_orthogonal)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(1, 2, 3), pen_vec3(0, 0, 0));
    camera.has_look_at = true;
    camera.look_at = pen_vec3(1, 2, -5);
    camera.up = pen_vec3(0, 7, 3);
    struct pen_camera_frame frame = frame_of(&camera);
    assert_vec(frame.forward, 0, 0, -1);
    assert_vec(frame.up, 0, 1, 0);
}
END_TEST

static void assert_refused(const struct pen_camera_desc *camera, const char *at)
{
    struct pen_camera_frame frame;
    struct pen_status st;
    ck_assert(!pen_camera_frame_make(camera, &frame, &st));
    ck_assert_int_eq(st.code, PEN_INVALID);
    ck_assert_str_eq(st.at, at);
}

START_TEST(test_camera__h036_refuses_what_gives_no_frame)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(1, 2, 3), pen_vec3(0, -2, 0));
    assert_refused(&camera, "/up");
    camera = camera_at(pen_vec3(0, 0, 0), pen_vec3(0.1, 0.2, 0.3));
    camera.up = pen_vec3(-0.3, -0.6, -0.9); /* parallel except for the rounding of decimals */
    assert_refused(&camera, "/up");
    camera = camera_at(pen_vec3(1, 2, 3), pen_vec3(0, 0, 0));
    assert_refused(&camera, "/direction");
    camera.has_look_at = true;
    camera.look_at = camera.position;
    assert_refused(&camera, "/look_at");
    camera = camera_at(pen_vec3(1, 2, 3), pen_vec3(0, 0, 1));
    camera.up = pen_vec3(0, 0, 0);
    assert_refused(&camera, "/up");
}
END_TEST

START_TEST(test_camera__frame_survives_any_length)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 0), pen_vec3(0, 3e-320, -4e-320));
    camera.up = pen_vec3(1e300, 1e-300, 0);
    struct pen_camera_frame frame = frame_of(&camera);
    ck_assert_double_eq_tol(frame.forward.y, 0.6, 1e-3); /* subnormals have few digits */
    ck_assert_double_eq_tol(pen_dot(frame.forward, frame.forward), 1, 1e-15);
    assert_vec(frame.up, 1, 0, 0);
}
END_TEST

static struct pen_camera_frame moved(const struct pen_camera_move *moves, uint32_t count)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 100), pen_vec3(0, 0, -1));
    camera.moves = moves;
    camera.move_count = count;
    return frame_of(&camera);
}

START_TEST(test_camera__translate_is_in_world_axes)
{
    const struct pen_camera_move moves[] = {
        {.kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_UP, .degrees = 90},
        {.kind = PEN_MOVE_TRANSLATE, .vector = {1, 2, 3}},
    };
    struct pen_camera_frame frame = moved(moves, 2);
    assert_vec(frame.eye, 1, 2, 103);
    assert_vec(frame.forward, -1, 0, 0);
}
END_TEST

START_TEST(test_camera__rotate_is_about_the_current_axes)
{
    const struct pen_camera_move roll[] = {
        {.kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_FORWARD, .degrees = 90}};
    struct pen_camera_frame frame = moved(roll, 1);
    assert_vec(frame.up, 1, 0, 0);
    assert_vec(frame.right, 0, -1, 0);
    const struct pen_camera_move two[] = {
        {.kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_UP, .degrees = 90},
        {.kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_RIGHT, .degrees = 90},
    };
    frame = moved(two, 2); /* looks left, then up */
    assert_vec(frame.forward, 0, 1, 0);
    assert_vec(frame.up, 1, 0, 0);
    assert_vec(frame.eye, 0, 0, 100);
    const struct pen_camera_move world[] = {
        {.kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_UP, .degrees = 90},
        {.kind = PEN_MOVE_ROTATE, .axis = {5, 0, 0}, .degrees = 90},
    };
    frame = moved(world, 2);
    assert_vec(frame.forward, -1, 0, 0);
    assert_vec(frame.up, 0, 0, 1);
}
END_TEST

START_TEST(test_camera__orbit_moves_eye_and_frame)
{
    const struct pen_camera_move orbit[] = {
        {.kind = PEN_MOVE_ORBIT, .axis = {0, 3, 0}, .vector = {0, 0, 0}, .degrees = 90}};
    struct pen_camera_frame frame = moved(orbit, 1);
    assert_vec(frame.eye, 100, 0, 0);
    assert_vec(frame.forward, -1, 0, 0);
    assert_vec(frame.right, 0, 0, -1);
    const struct pen_camera_move other[] = {
        {.kind = PEN_MOVE_ORBIT, .axis = {0, 1, 0}, .vector = {0, 0, 90}, .degrees = -180}};
    frame = moved(other, 1);
    assert_vec(frame.eye, 0, 0, 80);
    assert_vec(frame.forward, 0, 0, 1);
}
END_TEST

static void assert_near(struct pen_vec3 got, double x, double y, double z)
{
    double off = pen_length(pen_sub(got, pen_vec3(x, y, z)));
    ck_assert_msg(off <= 1e-14 * (1 + pen_length(got)), "(%g %g %g) is not (%g %g %g)", got.x,
                  got.y, got.z, x, y, z);
}

/* Angles without a right one among them, by closed forms: 30 degrees about each axis, and a third
 * of a turn about the diagonal, which permutes the axes: x to y to z to x. */
START_TEST(test_camera__rotate_by_any_angle_about_any_axis)
{
    const double half = 0.5, most = 0.5 * sqrt(3);
    struct pen_camera_move move = {
        .kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_RIGHT, .degrees = 30};
    struct pen_camera_frame frame = moved(&move, 1); /* looks up */
    assert_near(frame.forward, 0, half, -most);
    assert_near(frame.up, 0, most, half);
    assert_near(frame.right, 1, 0, 0);
    move.axis_kind = PEN_AXIS_UP; /* looks left */
    frame = moved(&move, 1);
    assert_near(frame.forward, -half, 0, -most);
    assert_near(frame.up, 0, 1, 0);
    assert_near(frame.right, most, 0, -half);
    move.axis_kind = PEN_AXIS_FORWARD; /* leans to the right */
    frame = moved(&move, 1);
    assert_near(frame.forward, 0, 0, -1);
    assert_near(frame.up, half, most, 0);
    assert_near(frame.right, most, -half, 0);
    move = (struct pen_camera_move){.kind = PEN_MOVE_ROTATE, .axis = {7, 7, 7}, .degrees = 120};
    frame = moved(&move, 1);
    assert_near(frame.forward, -1, 0, 0);
    assert_near(frame.up, 0, 0, 1);
    assert_near(frame.right, 0, 1, 0);
    assert_vec(frame.eye, 0, 0, 100);
}
END_TEST

/* The same third of a turn about a diagonal through (10, 20, 30): seen from there the eye is at
 * (-10, -20, 70), and goes to (70, -10, -20). */
START_TEST(test_camera__orbit_about_any_axis_and_target)
{
    const struct pen_camera_move orbit = {
        .kind = PEN_MOVE_ORBIT, .axis = {2, 2, 2}, .vector = {10, 20, 30}, .degrees = 120};
    struct pen_camera_frame frame = moved(&orbit, 1);
    assert_near(frame.eye, 80, 10, 10);
    assert_near(frame.forward, -1, 0, 0);
    assert_near(frame.up, 0, 0, 1);
    assert_near(frame.right, 0, 1, 0);
}
END_TEST

/* A camera that looks at the target of an orbit still does so afterwards, from the same distance,
 * and an orbit about the view direction is a rotation. */
START_TEST(test_camera__orbit_keeps_its_target_in_place)
{
    srand(29);
    for (int i = 0; i < 200; i++) {
        struct pen_vec3 target = pen_vec3(rand() % 19 - 9, rand() % 19 - 9, rand() % 19 - 9);
        struct pen_vec3 axis = pen_vec3(1 + rand() % 9, rand() % 19 - 9, rand() % 19 - 9);
        const struct pen_camera_move orbit = {.kind = PEN_MOVE_ORBIT,
                                              .axis = axis,
                                              .vector = target,
                                              .degrees = rand() % 7200 * 0.1 - 360};
        struct pen_camera_desc camera = camera_at(pen_vec3(20, 3, -5), pen_vec3(0, 0, 0));
        camera.has_look_at = true;
        camera.look_at = target;
        camera.up = pen_vec3(0.1, 1, 0.2);
        struct pen_camera_frame before = frame_of(&camera);
        camera.moves = &orbit;
        camera.move_count = 1;
        struct pen_camera_frame after = frame_of(&camera);
        double distance = pen_length(pen_sub(target, before.eye));
        struct pen_vec3 ahead = pen_along(after.eye, after.forward, distance);
        assert_near(ahead, target.x, target.y, target.z);
        /* Rigid: eye and axes keep their angles to the axis of the orbit. */
        struct pen_vec3 n = pen_normalize(axis);
        ck_assert_double_eq_tol(pen_dot(before.up, n), pen_dot(after.up, n), 1e-14);
        ck_assert_double_eq_tol(pen_dot(before.right, n), pen_dot(after.right, n), 1e-14);
    }
    const struct pen_camera_move roll[] = {
        {.kind = PEN_MOVE_ORBIT, .axis = {0, 0, -1}, .vector = {0, 0, 5}, .degrees = 37},
        {.kind = PEN_MOVE_ROTATE, .axis_kind = PEN_AXIS_FORWARD, .degrees = 37}};
    struct pen_camera_frame orbited = moved(&roll[0], 1), rotated = moved(&roll[1], 1);
    assert_near(orbited.eye, rotated.eye.x, rotated.eye.y, rotated.eye.z);
    assert_near(orbited.up, rotated.up.x, rotated.up.y, rotated.up.z);
}
END_TEST

/* Moves apply one after the other: the same two in another order are another camera, parts of a
 * turn add up, and a turn and its opposite cancel. */
START_TEST(test_camera__moves_apply_in_order)
{
    const struct pen_camera_move step = {.kind = PEN_MOVE_TRANSLATE, .vector = {10, 0, 0}};
    const struct pen_camera_move orbit = {
        .kind = PEN_MOVE_ORBIT, .axis = {0, 1, 0}, .vector = {0, 0, 0}, .degrees = 90};
    const struct pen_camera_move first[] = {step, orbit}, last[] = {orbit, step};
    assert_vec(moved(first, 2).eye, 100, 0, -10);
    assert_vec(moved(last, 2).eye, 110, 0, 0);
    struct pen_camera_move parts[] = {orbit, orbit, orbit};
    parts[0].degrees = 17;
    parts[1].degrees = 44;
    parts[2].degrees = 29;
    struct pen_camera_frame sum = moved(parts, 3);
    assert_near(sum.eye, 100, 0, 0);
    assert_near(sum.forward, -1, 0, 0);
    parts[2].degrees = -61;
    sum = moved(parts, 3);
    assert_near(sum.eye, 0, 0, 100);
    assert_near(sum.forward, 0, 0, -1);
}
END_TEST

START_TEST(test_camera__frame_stays_orthonormal)
{
    enum { MOVES = 4000 };
    static struct pen_camera_move moves[MOVES];
    srand(17);
    for (int i = 0; i < MOVES; i++) {
        moves[i].kind = i % 2 ? PEN_MOVE_ROTATE : PEN_MOVE_ORBIT;
        moves[i].axis_kind = (enum pen_move_axis)(i % 2 ? rand() % 4 : 0);
        moves[i].axis = pen_vec3(1 + rand() % 9, rand() % 9, rand() % 9);
        moves[i].degrees = rand() % 3600 * 0.1;
    }
    struct pen_camera_frame f = moved(moves, MOVES);
    const double tolerance = 4 * 0x1p-53;
    ck_assert_double_eq_tol(pen_length(f.forward), 1, tolerance);
    ck_assert_double_eq_tol(pen_length(f.right), 1, tolerance);
    ck_assert_double_eq_tol(pen_length(f.up), 1, tolerance);
    ck_assert_double_eq_tol(pen_dot(f.forward, f.right), 0, tolerance);
    ck_assert_double_eq_tol(pen_dot(f.forward, f.up), 0, tolerance);
    ck_assert_double_eq_tol(pen_dot(f.right, f.up), 0, tolerance);
}
END_TEST

/* H036: a camera looking along -z with up = -y, so that +x is left; pixels by column and row. */
START_TEST(test_camera__h036_classic_view_planes)
{
    static const struct {
        int pixels;
        double plane;
        int column, row;
        struct pen_vec3 d;
    } rows[] = {
        {4, 8, 1, 1, {1, -1, -10}}, {4, 8, 0, 0, {3, -3, -10}}, {4, 8, 1, 0, {1, -3, -10}},
        {4, 8, 3, 2, {-3, 1, -10}}, {3, 6, 1, 1, {0, 0, -10}},  {3, 6, 1, 0, {0, -2, -10}},
        {3, 6, 0, 1, {2, 0, -10}},  {3, 6, 0, 0, {2, -2, -10}}, {3, 6, 2, 2, {-2, 2, -10}},
    };
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 0), pen_vec3(0, 0, -1));
    camera.up = pen_vec3(0, -1, 0);
    camera.has_view_plane = true;
    camera.plane_distance = 10;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        camera.plane_width = camera.plane_height = rows[i].plane;
        struct pen_pinhole p = pinhole_of(&camera, rows[i].pixels, rows[i].pixels);
        struct pen_vec3 d = ray_through(&p, rows[i].column + 0.5, rows[i].row + 0.5);
        d = pen_scale(d, -10 / d.z);
        assert_vec(d, rows[i].d.x, rows[i].d.y, rows[i].d.z);
    }
}
END_TEST

START_TEST(test_camera__fov_is_vertical_and_pixels_are_square)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 0), pen_vec3(0, 0, -1));
    camera.fov_degrees = 90;
    struct pen_pinhole p = pinhole_of(&camera, 300, 100);
    struct pen_vec3 top = ray_through(&p, 150, 0);
    ck_assert_double_eq_tol(top.y / -top.z, 1, 4e-16);
    ck_assert(top.x == 0);
    struct pen_vec3 right = ray_through(&p, 300, 50);
    ck_assert_double_eq_tol(right.x / -right.z, 3, 4e-15);
    ck_assert(right.y == 0);
}
END_TEST

START_TEST(test_camera__view_plane_may_stretch)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 0), pen_vec3(0, 0, -1));
    camera.has_view_plane = true;
    camera.plane_distance = 3e-200;
    camera.plane_width = 4e-200;
    camera.plane_height = 1e-200;
    struct pen_pinhole p = pinhole_of(&camera, 10, 10);
    struct pen_vec3 corner = ray_through(&p, 0, 10);
    ck_assert_double_eq_tol(corner.x / corner.z, 2.0 / 3, 1e-15);
    ck_assert_double_eq_tol(corner.y / corner.z, 1.0 / 6, 1e-15);
    ck_assert_double_gt(-corner.z, 0.1); /* brought to about 1 */
    ck_assert_double_lt(-corner.z, 10);
}
END_TEST

START_TEST(test_camera__mirrored_pixels_have_mirrored_rays)
{
    struct pen_camera_desc camera = camera_at(pen_vec3(0, 0, 0), pen_vec3(0, 0, -1));
    camera.fov_degrees = 37.3;
    struct pen_pinhole p = pinhole_of(&camera, 1000, 777);
    for (int x = 0; x < 1000; x += 13) {
        struct pen_vec3 a = ray_through(&p, x + 0.5, 100.5);
        struct pen_vec3 b = ray_through(&p, 999 - x + 0.5, 776 - 100 + 0.5);
        assert_vec(b, -a.x, -a.y, a.z);
    }
}
END_TEST

PEN_SUITE("camera", test_camera__frame_is_right_handed, test_camera__up_is_made_orthogonal,
          test_camera__h036_refuses_what_gives_no_frame, test_camera__frame_survives_any_length,
          test_camera__translate_is_in_world_axes, test_camera__rotate_is_about_the_current_axes,
          test_camera__orbit_moves_eye_and_frame, test_camera__rotate_by_any_angle_about_any_axis,
          test_camera__orbit_about_any_axis_and_target,
          test_camera__orbit_keeps_its_target_in_place, test_camera__moves_apply_in_order,
          test_camera__frame_stays_orthonormal, test_camera__h036_classic_view_planes,
          test_camera__fov_is_vertical_and_pixels_are_square, test_camera__view_plane_may_stretch,
          test_camera__mirrored_pixels_have_mirrored_rays)

/* SPDX-License-Identifier: MIT */
/* Cameras, and the keys that a view overrides. */
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "io/scene/reader.h"
#include "io/scene/tables.h"

static const struct pen_range fov_range = {0, 180, true, true};

const struct pen_field pen_camera_fields[] = {
    {"position", PEN_FIELD_POINT, .required = true,
     .offset = offsetof(struct pen_camera_desc, position)},
    {"look_at", PEN_FIELD_POINT, .offset = offsetof(struct pen_camera_desc, look_at)},
    {"direction", PEN_FIELD_DIRECTION, .offset = offsetof(struct pen_camera_desc, direction)},
    {"up", PEN_FIELD_DIRECTION, .offset = offsetof(struct pen_camera_desc, up)},
    {"view_plane", .type = PEN_FIELD_OTHER},
    {"fov_degrees", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_camera_desc, fov_degrees),
     .range = &fov_range},
    {"aperture_radius", PEN_FIELD_NUMBER,
     .offset = offsetof(struct pen_camera_desc, aperture_radius), .range = &pen_range_not_negative},
    {"focus_distance", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_camera_desc, focus_distance),
     .range = &pen_range_positive},
    {"transforms", .type = PEN_FIELD_OTHER},
    {0}};

static const struct pen_field plane_fields[] = {
    {"distance", PEN_FIELD_NUMBER, .required = true,
     .offset = offsetof(struct pen_camera_desc, plane_distance), .range = &pen_range_positive},
    {"width", PEN_FIELD_NUMBER, .required = true,
     .offset = offsetof(struct pen_camera_desc, plane_width), .range = &pen_range_positive},
    {"height", PEN_FIELD_NUMBER, .required = true,
     .offset = offsetof(struct pen_camera_desc, plane_height), .range = &pen_range_positive},
    {0}};

static const struct pen_field move_fields[] = {
    {"translate", PEN_FIELD_POINT, .offset = offsetof(struct pen_camera_move, vector)},
    {"rotate", .type = PEN_FIELD_OTHER},
    {"orbit", .type = PEN_FIELD_OTHER},
    {0}};

const struct pen_field pen_camera_rotate_fields[] = {
    {"axis", PEN_FIELD_OTHER, .required = true},
    {"degrees", PEN_FIELD_NUMBER, .required = true,
     .offset = offsetof(struct pen_camera_move, degrees), .range = &pen_range_turn},
    {0}};

const struct pen_field pen_camera_orbit_fields[] = {
    {"target", PEN_FIELD_POINT, .required = true,
     .offset = offsetof(struct pen_camera_move, vector)},
    {"axis", PEN_FIELD_DIRECTION, .required = true,
     .offset = offsetof(struct pen_camera_move, axis)},
    {"degrees", PEN_FIELD_NUMBER, .required = true,
     .offset = offsetof(struct pen_camera_move, degrees), .range = &pen_range_turn},
    {0}};

static const struct pen_word axis_words[] = {{"forward", PEN_AXIS_FORWARD, NULL},
                                             {"right", PEN_AXIS_RIGHT, NULL},
                                             {"up", PEN_AXIS_UP, NULL},
                                             {0}};

static bool read_rotate(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                        struct pen_camera_move *move)
{
    move->kind = PEN_MOVE_ROTATE;
    bool ok = pen_fields_read_whole(r, at, json, pen_camera_rotate_fields, move);
    const json_t *axis = json_object_get(json, "axis");
    struct pen_place place = pen_place_key(at, "axis");
    int word = PEN_AXIS_VECTOR;
    if (json_is_array(axis))
        ok &= pen_read_direction(r, &place, axis, &move->axis);
    else if (axis)
        ok &= pen_read_word(r, &place, axis, axis_words, &word);
    move->axis_kind = (enum pen_move_axis)word;
    return ok;
}

static bool read_orbit(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_camera_move *move)
{
    move->kind = PEN_MOVE_ORBIT;
    return pen_fields_read_whole(r, at, json, pen_camera_orbit_fields, move);
}

static bool read_move(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      struct pen_camera_move *move)
{
    bool ok = pen_fields_read(r, at, json, move_fields, move);
    if (!ok)
        return false;
    if (pen_fields_count(json) != 1)
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must hold exactly one of \"translate\", \"rotate\", \"orbit\", "
                               "found %zu",
                               pen_fields_count(json));
    const json_t *rotate = json_object_get(json, "rotate"), *orbit = json_object_get(json, "orbit");
    struct pen_place place = pen_place_key(at, rotate ? "rotate" : "orbit");
    if (rotate)
        return read_rotate(r, &place, rotate, move);
    if (orbit)
        return read_orbit(r, &place, orbit, move);
    move->kind = PEN_MOVE_TRANSLATE;
    return true;
}

static bool read_moves(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_camera_desc *camera)
{
    if (!pen_read_array(r, at, json, "camera transforms"))
        return false;
    size_t count = json_array_size(json);
    struct pen_camera_move *moves = pen_reader_alloc(r, count, sizeof *moves);
    if (!moves)
        return false;
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        struct pen_place place = pen_place_index(at, i);
        ok &= read_move(r, &place, json_array_get(json, i), &moves[i]);
    }
    camera->moves = moves;
    camera->move_count = (uint32_t)count;
    return ok;
}

/* Reports two keys that exclude each other, at the second. */
static bool refuse_both(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                        const char *first, const char *second)
{
    if (!json_object_get(json, first) || !json_object_get(json, second))
        return true;
    struct pen_place place = pen_place_key(at, second);
    return pen_reader_fail(r, &place, PEN_INVALID, "%s and %s exclude each other, found both",
                           pen_reader_name(r, at, first).text, pen_reader_name(r, at, second).text);
}

static bool check_lens(struct pen_reader *r, const struct pen_place *at,
                       const struct pen_camera_desc *camera)
{
    if (camera->aperture_radius <= 0 || camera->focus_distance > 0)
        return true;
    return pen_reader_fail(r, at, PEN_INVALID, "missing %s, which a camera with %s above 0 needs",
                           pen_reader_name(r, at, "focus_distance").text,
                           pen_reader_name(r, at, "aperture_radius").text);
}

/* Reports a camera that has no valid frame, at the wrong key if this object has it. A view may
 * lack any key, because it overrides only some; the message then names the key. */
static bool check_frame(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                        const struct pen_camera_desc *camera)
{
    struct pen_camera_frame frame;
    struct pen_status st;
    if (pen_camera_frame_make(camera, &frame, &st))
        return true;
    const char *key = st.at[0] == '/' ? st.at + 1 : NULL;
    struct pen_place place = pen_place_key(at, key);
    if (!key)
        return pen_reader_fail(r, at, st.code, "%s", st.msg);
    if (json_object_get(json, key))
        return pen_reader_fail(r, &place, st.code, "%s", st.msg);
    const struct pen_vec3 *found = strcmp(key, "up") == 0 ? &camera->up : &camera->look_at;
    return pen_reader_fail(r, at, st.code, "%s %s, found [%.30s, %.30s, %.30s]",
                           pen_reader_name(r, at, key).text, st.msg, pen_text_number(found->x).text,
                           pen_text_number(found->y).text, pen_text_number(found->z).text);
}

/* Reads the keys that the table does not read. Of two keys that exclude each other (look_at and
 * direction; view_plane and fov_degrees), a view's key replaces the other one of the camera. */
static bool read_others(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                        struct pen_camera_desc *camera)
{
    bool ok = true;
    const json_t *plane = json_object_get(json, "view_plane");
    const json_t *moves = json_object_get(json, "transforms");
    struct pen_place plane_at = pen_place_key(at, "view_plane");
    struct pen_place moves_at = pen_place_key(at, "transforms");
    ok &= refuse_both(r, at, json, "look_at", "direction");
    ok &= refuse_both(r, at, json, "view_plane", "fov_degrees");
    if (plane)
        ok &= pen_fields_read_whole(r, &plane_at, plane, plane_fields, camera);
    if (moves)
        ok &= read_moves(r, &moves_at, moves, camera);
    if (json_object_get(json, "look_at") || json_object_get(json, "direction"))
        camera->has_look_at = json_object_get(json, "look_at") != NULL;
    if (plane || json_object_get(json, "fov_degrees"))
        camera->has_view_plane = plane != NULL;
    camera->default_up = camera->default_up && !json_object_get(json, "up");
    return ok;
}

bool pen_camera_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_camera_desc *camera)
{
    *camera = (struct pen_camera_desc){
        .up = {0, 1, 0}, .default_up = !json_object_get(json, "up"), .fov_degrees = 50};
    bool ok = pen_fields_read_whole(r, at, json, pen_camera_fields, camera);
    ok &= read_others(r, at, json, camera);
    if (json_is_object(json) && !json_object_get(json, "look_at") &&
        !json_object_get(json, "direction"))
        ok = pen_reader_missing(r, at, "look_at", "direction");
    return ok && check_lens(r, at, camera) && check_frame(r, at, json, camera);
}

bool pen_camera_override(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         bool check, struct pen_camera_desc *camera)
{
    bool ok = pen_fields_read(r, at, json, pen_camera_fields, camera);
    ok &= read_others(r, at, json, camera);
    return ok && (!check || (check_lens(r, at, camera) && check_frame(r, at, json, camera)));
}

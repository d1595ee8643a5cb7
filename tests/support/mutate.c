/* SPDX-License-Identifier: MIT */
#include "support/mutate.h"

/* A member or element somewhere in a document. */
struct spot {
    json_t *parent;
    const char *key;
    size_t index;
};

enum { SPOTS_MAX = 4096 };

static size_t collect(json_t *value, struct spot *spots, size_t count)
{
    const char *key;
    size_t index;
    json_t *child;
    json_object_foreach(value, key, child)
    {
        if (count < SPOTS_MAX)
            spots[count++] = (struct spot){value, key, 0};
        count = collect(child, spots, count);
    }
    json_array_foreach(value, index, child)
    {
        if (count < SPOTS_MAX)
            spots[count++] = (struct spot){value, NULL, index};
        count = collect(child, spots, count);
    }
    return count;
}

static json_t *at(const struct spot *spot)
{
    return spot->key ? json_object_get(spot->parent, spot->key)
                     : json_array_get(spot->parent, spot->index);
}

/* Replaces a member or element; takes the reference to value. */
static void put(const struct spot *spot, json_t *value)
{
    if (spot->key)
        json_object_set_new(spot->parent, spot->key, value);
    else
        json_array_set_new(spot->parent, spot->index, value);
}

static json_t *odd_value(struct random *random)
{
    static const char *const values[] = {
        "null",
        "true",
        "0",
        "-1",
        "1",
        "0.5",
        "2",
        "90",
        "180",
        "1e100",
        "1.1e100",
        "-1e100",
        "65536",
        "65537",
        "800.0",
        "2147483647",
        "2147483648",
        "9007199254740993",
        "-0.0",
        "1e-320",
        "\"\"",
        "\"sphere\"",
        "\"plane\"",
        "\"all\"",
        "\"m\"",
        "\"auto\"",
        "\"cbr\"",
        "[]",
        "{}",
        "[0, 0, 0]",
        "[1, 0, 0]",
        "[0, 0, -1]",
        "[1, 2, 3, 4]",
        "[0, 1]",
        "[-1, 0, 0]",
        "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]",
        "{\"kd\": 1}",
        "{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1}",
        "{\"degrees\": 3}",
        "{\"translate\": [1, 2, 3]}",
        "{\"scale\": 2}",
        "{\"matrix\": [1,0,0,0,0,1,0,0,0,0,1,0]}",
    };
    size_t count = sizeof values / sizeof values[0];
    return json_loads(values[random_below(random, (uint32_t)count)], JSON_DECODE_ANY, NULL);
}

/* A random key of the format; it may be wrong where it is put. */
static const char *some_key(struct random *random)
{
    static const char *const keys[] = {
        "type",       "name",        "material", "center", "radius",  "camera",   "look_at",
        "direction",  "up",          "position", "caps",   "height",  "objects",  "transform",
        "scale",      "matrix",      "rotate",   "seed",   "width",   "emission", "kd",
        "ior",        "shadows",     "nonsense", "axis",   "degrees", "vertices", "fov_degrees",
        "view_plane", "definitions", "views",    "",
    };
    return keys[random_below(random, (uint32_t)(sizeof keys / sizeof keys[0]))];
}

void mutate_document(struct random *random, json_t *document)
{
    struct spot spots[SPOTS_MAX];
    size_t count = collect(document, spots, 0);
    if (count == 0)
        return;
    const struct spot *spot = &spots[random_below(random, (uint32_t)count)];
    json_t *value = at(spot);
    switch (random_below(random, 7)) {
    case 0:
        if (spot->key)
            json_object_del(spot->parent, spot->key);
        else
            json_array_remove(spot->parent, spot->index);
        break;
    case 1:
        if (spot->key)
            json_object_set_new(spot->parent, some_key(random), odd_value(random));
        else
            json_array_insert_new(spot->parent, spot->index, json_deep_copy(value));
        break;
    case 2:
        if (json_is_number(value))
            put(spot, json_real(-json_number_value(value)));
        break;
    case 3:
        put(spot, json_deep_copy(at(&spots[random_below(random, (uint32_t)count)])));
        break;
    default:
        put(spot, odd_value(random));
        break;
    }
}

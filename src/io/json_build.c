/* SPDX-License-Identifier: MIT */
#include "io/json_build.h"

json_t *pen_json_all(json_t *list, size_t count)
{
    if (list && json_array_size(list) == count)
        return list;
    json_decref(list);
    return NULL;
}

json_t *pen_json_with(json_t *object, const char *key, json_t *value)
{
    if (!object)
        json_decref(value);
    else if (json_object_set_new(object, key, value) == 0)
        return object;
    json_decref(object);
    return NULL;
}

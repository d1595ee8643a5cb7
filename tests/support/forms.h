/* SPDX-License-Identifier: MIT */
/* Two forms of a scene for each effect: without the effect, and with the effect but without
 * consequence. Both must give the same bits and rays, at the same cost. */
#ifndef TESTS_SUPPORT_FORMS_H
#define TESTS_SUPPORT_FORMS_H

#include "scene/scene.h"

struct form {
    const char *name;
    unsigned effect;
    /* Changes the scene; with `idle`, to the form with the effect. The memory of a pattern is
     * static. */
    void (*make)(struct pen_scene_desc *desc, bool idle);
    bool called_for; /* the idle form calls for the effect; only rays show that none meets it */
};

/* All of them; the last has no name. */
extern const struct form forms[];

/* The form, or NULL. */
const struct form *form_find(const char *name);

#endif

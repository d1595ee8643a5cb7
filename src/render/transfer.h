/* SPDX-License-Identifier: MIT */
/* The transfer function that a scene's settings name. */
#ifndef PEN_RENDER_TRANSFER_H
#define PEN_RENDER_TRANSFER_H

#include "film/encode.h"
#include "scene/settings.h"

_Static_assert((int)PEN_SETTING_SRGB == (int)PEN_TRANSFER_SRGB &&
                   (int)PEN_SETTING_LINEAR == (int)PEN_TRANSFER_LINEAR &&
                   (int)PEN_SETTING_DISPLAY == (int)PEN_TRANSFER_DISPLAY,
               "the settings' values are the film's");

static inline enum pen_transfer pen_settings_transfer(const struct pen_settings *settings)
{
    return (enum pen_transfer)settings->transfer;
}

#endif

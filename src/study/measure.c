/* SPDX-License-Identifier: MIT */
#include "film/flip.h"
#include "film/metrics.h"
#include "film/ssim.h"
#include "render/transfer.h"
#include "study/study.h"

const char *const pen_metrics[] = {"rmse", "relative_mse", "psnr", "ssim",
                                   "flip", "max_error",    NULL};

bool pen_metric_rises(enum pen_metric metric)
{
    return metric == PEN_METRIC_PSNR || metric == PEN_METRIC_SSIM;
}

bool pen_study_measure(const struct pen_study_pair *pair, double error[PEN_METRIC_COUNT],
                       float *map, struct pen_status *st)
{
    const enum pen_transfer transfer = pen_settings_transfer(pair->settings);
    const int width = pair->settings->width, height = pair->settings->height;
    const struct pen_film film = {width, height, (float *)(uintptr_t)pair->rgb},
                          other = {width, height, (float *)(uintptr_t)pair->reference};
    struct pen_picture *a = pen_picture_of_film(&film, transfer, st);
    struct pen_picture *b = a ? pen_picture_of_film(&other, transfer, st) : NULL;
    struct pen_difference d;
    struct pen_flip flip;
    const bool ok = b && pen_picture_compare(a, b, 0, &d, st) &&
                    pen_picture_ssim(a, b, &error[PEN_METRIC_SSIM], st) &&
                    pen_picture_flip(a, b, map, &flip, st);
    pen_picture_free(a);
    pen_picture_free(b);
    if (!ok)
        return false;
    error[PEN_METRIC_RMSE] = d.rmse;
    error[PEN_METRIC_RELATIVE_MSE] = d.relative_mse;
    error[PEN_METRIC_PSNR] = d.psnr;
    error[PEN_METRIC_FLIP] = flip.mean;
    error[PEN_METRIC_MAX_ERROR] = d.max_error;
    return true;
}

/* SPDX-License-Identifier: MIT */
#include "study/internal/axis.h"

#include <math.h>

double pen_axis_place(const struct pen_axis *axis, double value)
{
    double share = axis->logarithmic ? log(value / axis->low) / log(axis->high / axis->low)
                                     : (value - axis->low) / (axis->high - axis->low);
    if (!(share > 0))
        share = 0;
    return axis->first + (share < 1 ? share : 1) * (axis->end - axis->first);
}

double pen_axis_step(double range, int most)
{
    const double least = range / most, unit = pow(10, floor(log10(least)));
    if (least > 5 * unit)
        return 10 * unit;
    if (least > 2 * unit)
        return 5 * unit;
    return least > unit ? 2 * unit : unit;
}

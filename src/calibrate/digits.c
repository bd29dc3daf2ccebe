/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See digits.h. Rounding goes through decimal text, so that it is the rounding
 * that a reader of the printed number would do. */
#include "calibrate/digits.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

double digits_round(double value, int digits)
{
    char text[48];
    snprintf(text, sizeof text, "%.*e", digits - 1, value);
    double rounded = strtod(text, NULL);
    return rounded == 0 ? 0 : rounded; // no negative zero
}

double digits_unit(double low, double high, int digits)
{
    double size = fmax(fabs(low), fabs(high));
    return size > 0 ? pow(10, floor(log10(size)) - digits + 1) : 0;
}

bool digits_closed(double low, double high, int digits, double span)
{
    double width = high - low;
    return digits_round(low, digits) == digits_round(high, digits) || width <= 0.1 * digits_unit(low, high, digits) ||
           width <= 1e-12 * span;
}

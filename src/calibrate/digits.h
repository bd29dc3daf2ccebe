/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Significant digits: when a bracket says what was asked for.
 *
 * "Until both ends agree to three significant figures" (seed 000, S4.3) never
 * comes true for a threshold that lies on a rounding boundary (0.2365 between
 * 0.236 and 0.237). A bracket is therefore closed, too, once it is no wider than
 * a tenth of the last digit's unit: the answer is then right to half that unit
 * and a twentieth of it. */
#ifndef SCREE_CALIBRATE_DIGITS_H
#define SCREE_CALIBRATE_DIGITS_H

#include <stdbool.h>

/* `value` rounded to so many significant decimal digits. */
double digits_round(double value, int digits);

/* Unit of the last of them, for numbers of the size of the larger end; 0 when both ends are 0. */
double digits_unit(double low, double high, int digits);

/* Whether [low, high] is narrow enough; `span`: its width at the start. A bracket that
 * closes on 0 never agrees in significant digits, and ends at 1e-12 of its span. */
bool digits_closed(double low, double high, int digits, double span);

#endif

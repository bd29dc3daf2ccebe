/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The value of a parameter at which a measured number meets its target.
 *
 * Both ends of [low, high] are tried; the number must lie on different sides of
 * the target there. Then one point at a time: where the straight line between the
 * bracket's ends meets the target (false position), with the weight of an end that
 * stays twice in a row halved (Illinois: Dowell & Jarratt, BIT 11, 168, 1971), and
 * the middle instead when two points together have not halved the bracket. A point
 * keeps an eighth of the last digit's unit away from the ends, so that it comes to
 * lie on the other side of a root that is all but known. The sign decides alone, so
 * scatter of the number widens the answer but never loses it.
 *
 * Plain data without pointers, as a bisection (bisect.h) is. */
#ifndef SCREE_CALIBRATE_ROOT_H
#define SCREE_CALIBRATE_ROOT_H

#include <stdbool.h>

enum { ROOT_POINTS_MAX = 128 };

enum root_end {
    ROOT_SEARCHING,
    ROOT_FOUND,
    ROOT_SAME_SIDE, // at both ends the number lies on one side of the target
    ROOT_STUCK      // a trial ended without a number
};

struct root_point {
    double at, number;
    bool answered, failed;
    double low, high; // the bracket after it
};

struct root {
    int digits;
    double span, target;
    double low, high;         // the bracket
    double low_off, high_off; // number minus target there, halved by Illinois
    int kept;                 // -1, +1: the low, the high end stayed last time
    double width[2];          // of the bracket one and two points ago
    enum root_end end;
    struct root_point points[ROOT_POINTS_MAX];
    int point_count;
};

/* low < high, digits 1..15. */
void root_start(struct root *root, double low, double high, double target, int digits);

/* The number at a point; `failed`: it has none. */
void root_put(struct root *root, int point, double number, bool failed);

/* The root to `digits` digits. */
double root_value(const struct root *root);

#endif

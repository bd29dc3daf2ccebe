/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The threshold of a yes-or-no answer: seed 000, S4.3, several points at once.
 *
 * A bracket [low, high]: at low the answer is `raise` (the flow goes on: the low
 * end may move up), at high it is `lower`. First both ends are tried; then rounds
 * of k points cut the bracket into k + 1 equal parts (k = 1: the paper's midpoint),
 * until both ends agree to so many significant digits. A round ends in
 *   high = the lowest point that answered `lower`
 *   low  = the highest point below that which answered `raise`
 * and thus finds the *lowest* value at which the answer is `lower`, as the paper
 * words it, even where answers are not monotone. From this rule follow two facts:
 * points above one that answered `lower` are no longer needed, and the bracket
 * does not depend on the order in which answers come in.
 *
 * The state is plain data without pointers; it can be copied, compared and made
 * anew from the answers alone: putting the same answers again, in any order that
 * has a point before its answer, gives the same points and the same bracket. */
#ifndef SCREE_CALIBRATE_BISECT_H
#define SCREE_CALIBRATE_BISECT_H

#include <stdbool.h>

#include "base/status.h"

enum { BISECT_SECTIONS_MAX = 32, BISECT_POINTS_MAX = 320, BISECT_ROUNDS_MAX = 64 };

enum bisect_answer {
    BISECT_PENDING,
    BISECT_RAISE,
    BISECT_LOWER,
    BISECT_NEITHER // the trial ended without an answer: undecided, failed or stopped
};

enum bisect_end {
    BISECT_SEARCHING,
    BISECT_FOUND,
    BISECT_SAME_ENDS, // both ends give the same answer: the bracket holds no threshold
    BISECT_REVERSED,  // `lower` at low and `raise` at high
    BISECT_STUCK      // answers are missing, and without them the bracket cannot get narrower
};

struct bisect_point {
    double at;
    int round; // 0: the ends
    enum bisect_answer answer;
    bool needed; // false once the bracket cannot depend on it
};

struct bisect_round {
    int first, count; // of its points
    double low, high; // the bracket after it
};

struct bisect {
    int digits, sections;
    double span; // width at the start
    double low, high;
    enum bisect_end end;
    struct bisect_point points[BISECT_POINTS_MAX];
    int point_count;
    struct bisect_round rounds[BISECT_ROUNDS_MAX]; // those that are complete
    int round_count;
};

/* low < high, digits 1..15, sections 1..BISECT_SECTIONS_MAX: the points of a round after the first. */
void bisect_start(struct bisect *bisect, double low, double high, int digits, int sections);

/* The answer of a point; it may add points, and others may no longer be needed. A point that
 * is not needed may answer all the same: it is kept for what it shows. */
void bisect_put(struct bisect *bisect, int point, enum bisect_answer answer);

/* The threshold to `digits` digits: the middle of the bracket as it stands. */
double bisect_value(const struct bisect *bisect);

/* A point that answered `lower` below one that answered `raise`: false when there is none. */
bool bisect_contradiction(const struct bisect *bisect, int *lower, int *raise);

/* Rounds that are still to come after the ends, at most. */
int bisect_rounds_left(const struct bisect *bisect);

#endif

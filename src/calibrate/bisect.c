/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See bisect.h. */
#include "calibrate/bisect.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "calibrate/digits.h"

static void add_point(struct bisect *b, double at, int round)
{
    b->points[b->point_count++] = (struct bisect_point){.at = at, .round = round, .answer = BISECT_PENDING, .needed = true};
}

void bisect_start(struct bisect *b, double low, double high, int digits, int sections)
{
    assert(low < high && digits >= 1 && digits <= 15 && sections >= 1 && sections <= BISECT_SECTIONS_MAX);
    memset(b, 0, sizeof *b); // padding too: states are compared as bytes
    b->digits = digits;
    b->sections = sections;
    b->span = high - low;
    b->low = low;
    b->high = high;
    add_point(b, low, 0);
    add_point(b, high, 0);
}

/* First point of the round that is not complete yet. */
static int open_round(const struct bisect *b)
{
    const struct bisect_round *last = b->round_count ? &b->rounds[b->round_count - 1] : NULL;
    return last ? last->first + last->count : 0;
}

static void keep_round(struct bisect *b, int first)
{
    b->rounds[b->round_count++] =
        (struct bisect_round){.first = first, .count = b->point_count - first, .low = b->low, .high = b->high};
}

static void judge_ends(struct bisect *b)
{
    enum bisect_answer low = b->points[0].answer, high = b->points[1].answer;
    if (low == BISECT_NEITHER || high == BISECT_NEITHER)
        b->end = BISECT_STUCK;
    else if (low == high)
        b->end = BISECT_SAME_ENDS;
    else if (low == BISECT_LOWER)
        b->end = BISECT_REVERSED;
}

/* The rule of bisect.h over the points of one round. */
static void judge_round(struct bisect *b, int first)
{
    double low = b->low, high = b->high;
    for (int k = b->point_count; k-- > first;) // points rise within a round
        if (b->points[k].answer == BISECT_LOWER)
            high = b->points[k].at;
    for (int k = first; k < b->point_count; k++)
        if (b->points[k].answer == BISECT_RAISE && b->points[k].at < high)
            low = b->points[k].at;
    if (low == b->low && high == b->high)
        b->end = BISECT_STUCK;
    b->low = low;
    b->high = high;
}

/* A bracket that is closed, or as narrow as numbers and this struct allow. */
static bool closed(const struct bisect *b)
{
    double part = (b->high - b->low) / (b->sections + 1);
    return digits_closed(b->low, b->high, b->digits, b->span) || b->low + part <= b->low || b->high - part >= b->high ||
           b->round_count + 1 >= BISECT_ROUNDS_MAX || b->point_count + b->sections > BISECT_POINTS_MAX;
}

static void next_round(struct bisect *b)
{
    for (int k = 1; k <= b->sections; k++)
        add_point(b, b->low + (b->high - b->low) * k / (b->sections + 1), b->round_count);
}

/* Points above one that answered `lower` can change nothing. */
static void spare(struct bisect *b, int first)
{
    bool lowered = false;
    for (int k = first; k < b->point_count; k++) {
        b->points[k].needed = !lowered;
        lowered |= b->points[k].answer == BISECT_LOWER;
    }
}

void bisect_put(struct bisect *b, int point, enum bisect_answer answer)
{
    assert(point >= 0 && point < b->point_count && answer != BISECT_PENDING);
    int first = open_round(b);
    b->points[point].answer = answer;
    if (b->end != BISECT_SEARCHING || point < first)
        return; // it comes too late to matter
    if (first > 0)
        spare(b, first);
    for (int k = first; k < b->point_count; k++)
        if (b->points[k].needed && b->points[k].answer == BISECT_PENDING)
            return;
    if (first == 0)
        judge_ends(b);
    else
        judge_round(b, first);
    keep_round(b, first);
    if (b->end != BISECT_SEARCHING)
        return;
    if (closed(b))
        b->end = BISECT_FOUND;
    else
        next_round(b);
}

double bisect_value(const struct bisect *b)
{
    return digits_round(0.5 * (b->low + b->high), b->digits);
}

bool bisect_contradiction(const struct bisect *b, int *lower, int *raise)
{
    *lower = *raise = -1;
    for (int k = 0; k < b->point_count; k++) {
        const struct bisect_point *p = &b->points[k];
        if (p->answer == BISECT_LOWER && (*lower < 0 || p->at < b->points[*lower].at))
            *lower = k;
        if (p->answer == BISECT_RAISE && (*raise < 0 || p->at > b->points[*raise].at))
            *raise = k;
    }
    return *lower >= 0 && *raise >= 0 && b->points[*lower].at < b->points[*raise].at;
}

int bisect_rounds_left(const struct bisect *b)
{
    double unit = 0.1 * digits_unit(b->low, b->high, b->digits), width = b->high - b->low;
    if (b->end != BISECT_SEARCHING || !(unit > 0) || width <= unit)
        return 0;
    return (int)ceil(log(width / unit) / log(b->sections + 1));
}

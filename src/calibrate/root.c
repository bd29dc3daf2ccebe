/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See root.h. */
#include "calibrate/root.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "calibrate/digits.h"

static void add_point(struct root *r, double at)
{
    r->points[r->point_count++] = (struct root_point){.at = at, .low = r->low, .high = r->high};
}

void root_start(struct root *r, double low, double high, double target, int digits)
{
    assert(low < high && digits >= 1 && digits <= 15);
    memset(r, 0, sizeof *r);
    r->digits = digits;
    r->target = target;
    r->low = low;
    r->high = high;
    r->span = high - low;
    r->width[0] = r->width[1] = INFINITY;
    add_point(r, low);
    add_point(r, high);
}

static bool opposite(double a, double b)
{
    return (a < 0 && b > 0) || (a > 0 && b < 0);
}

/* Where to try next. */
static double next_at(const struct root *r)
{
    double width = r->high - r->low, middle = r->low + 0.5 * width;
    if (width > 0.5 * r->width[1])
        return middle;
    double at = (r->low_off * r->high - r->high_off * r->low) / (r->low_off - r->high_off);
    double away = fmin(digits_unit(r->low, r->high, r->digits) / 8, 0.25 * width);
    if (!isfinite(at))
        return middle;
    return fmax(r->low + away, fmin(r->high - away, at));
}

/* The bracket is narrowed to `at`, where the number is off by `off`. */
static void narrow(struct root *r, double at, double off)
{
    r->width[1] = r->width[0];
    r->width[0] = r->high - r->low;
    if (opposite(r->low_off, off)) { // the root is between low and here: low stays
        r->high = at;
        r->high_off = off;
        r->low_off *= r->kept < 0 ? 0.5 : 1;
        r->kept = -1;
    } else {
        r->low = at;
        r->low_off = off;
        r->high_off *= r->kept > 0 ? 0.5 : 1;
        r->kept = 1;
    }
}

static void judge_ends(struct root *r)
{
    r->low_off = r->points[0].number - r->target;
    r->high_off = r->points[1].number - r->target;
    if (r->low_off == 0 || r->high_off == 0) {
        r->low = r->high = r->low_off == 0 ? r->low : r->high;
        r->end = ROOT_FOUND;
    } else if (!opposite(r->low_off, r->high_off)) {
        r->end = ROOT_SAME_SIDE;
    }
}

static void judge_point(struct root *r, int point)
{
    double off = r->points[point].number - r->target;
    if (off == 0) {
        r->low = r->high = r->points[point].at;
        r->end = ROOT_FOUND;
        return;
    }
    narrow(r, r->points[point].at, off);
}

void root_put(struct root *r, int point, double number, bool failed)
{
    assert(point >= 0 && point < r->point_count);
    struct root_point *p = &r->points[point];
    p->answered = true;
    p->failed = failed || !isfinite(number);
    p->number = p->failed ? 0 : number;
    if (r->end != ROOT_SEARCHING || point < r->point_count - (r->point_count == 2 ? 2 : 1))
        return;
    if (r->point_count == 2 && !(r->points[0].answered && r->points[1].answered))
        return;
    bool missing = p->failed || (r->point_count == 2 && (r->points[0].failed || r->points[1].failed));
    if (missing)
        r->end = ROOT_STUCK;
    else if (r->point_count == 2)
        judge_ends(r);
    else
        judge_point(r, point);
    for (int k = r->point_count == 2 ? 0 : point; k < r->point_count; k++) {
        r->points[k].low = r->low;
        r->points[k].high = r->high;
    }
    if (r->end != ROOT_SEARCHING)
        return;
    double at = next_at(r);
    bool spent = r->point_count == ROOT_POINTS_MAX || at <= r->low || at >= r->high;
    if (spent || digits_closed(r->low, r->high, r->digits, r->span))
        r->end = ROOT_FOUND;
    else
        add_point(r, at);
}

double root_value(const struct root *r)
{
    return digits_round(0.5 * (r->low + r->high), r->digits);
}

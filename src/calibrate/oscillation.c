/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See oscillation.h. Samples h apart of such a motion obey u[k + 1] = 2 q cos(w h) u[k] - q^2 u[k - 1] with
 * q = exp(-g h): a linear fit of the two coefficients (Prony) is where Gauss and Newton start from. */
#include "calibrate/oscillation.h"

#include <math.h>
#include <string.h>

enum { UNKNOWNS = 4, ROUNDS_MAX = 50 };

/* Samples between the first and the last change of sign, over the changes between: half a period. */
static double half_period(const double *u, size_t count)
{
    size_t first = 0, last = 0, changes = 0;
    for (size_t k = 1; k < count; k++)
        if ((u[k - 1] < 0) != (u[k] < 0)) {
            first = changes ? first : k;
            last = k;
            changes++;
        }
    return changes >= 4 ? (double)(last - first) / (double)(changes - 1) : 0;
}

/* The recurrence over samples `stride` apart, an eighth of a period, where it is well conditioned. */
static bool guess(const double *u, size_t count, double interval, struct oscillation *out)
{
    size_t stride = (size_t)fmax(1, floor(half_period(u, count) / 4));
    double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
    for (size_t k = stride; k + stride < count; k++) {
        double a = u[k], b = u[k - stride], y = u[k + stride];
        aa += a * a;
        ab += a * b;
        bb += b * b;
        ay += a * y;
        by += b * y;
    }
    double det = aa * bb - ab * ab, c1 = (ay * bb - by * ab) / det, c2 = (by * aa - ay * ab) / det;
    double h = (double)stride * interval, q = sqrt(-c2);
    if (!(det > 0) || !(c2 < 0) || !(fabs(c1) < 2 * q))
        return false;
    *out = (struct oscillation){.decay = -log(q) / h, .rate = acos(0.5 * c1 / q) / h, .cosine = u[0]};
    return true;
}

/* Solves m x = y in place, by elimination with pivots; false if m is singular. */
static bool solve(double m[UNKNOWNS][UNKNOWNS + 1])
{
    for (int c = 0; c < UNKNOWNS; c++) {
        int pivot = c;
        for (int r = c + 1; r < UNKNOWNS; r++)
            pivot = fabs(m[r][c]) > fabs(m[pivot][c]) ? r : pivot;
        if (!(fabs(m[pivot][c]) > 0))
            return false;
        for (int k = 0; k <= UNKNOWNS; k++) {
            double swap = m[c][k];
            m[c][k] = m[pivot][k];
            m[pivot][k] = swap;
        }
        for (int r = 0; r < UNKNOWNS; r++)
            for (int k = UNKNOWNS; r != c && k >= c; k--)
                m[r][k] -= m[r][c] / m[c][c] * m[c][k];
    }
    for (int c = 0; c < UNKNOWNS; c++)
        m[c][UNKNOWNS] /= m[c][c];
    return true;
}

/* One round of Gauss and Newton; returns the largest change, relative to what it changes, or NaN. */
static double improve(const double *u, size_t count, double interval, struct oscillation *o)
{
    double m[UNKNOWNS][UNKNOWNS + 1], left = 0, all = 0;
    memset(m, 0, sizeof m);
    for (size_t k = 0; k < count; k++) {
        double t = (double)k * interval, fade = exp(-o->decay * t), c = fade * cos(o->rate * t), s = fade * sin(o->rate * t);
        double fit = o->cosine * c + o->sine * s, off = u[k] - fit;
        const double slope[UNKNOWNS] = {c, s, t * (o->sine * c - o->cosine * s), -t * fit};
        for (int a = 0; a < UNKNOWNS; a++) {
            for (int b = 0; b < UNKNOWNS; b++)
                m[a][b] += slope[a] * slope[b];
            m[a][UNKNOWNS] += slope[a] * off;
        }
        left += off * off;
        all += u[k] * u[k];
    }
    o->misfit = sqrt(left / all);
    if (!solve(m))
        return NAN;
    o->cosine += m[0][UNKNOWNS];
    o->sine += m[1][UNKNOWNS];
    o->rate += m[2][UNKNOWNS];
    o->decay += m[3][UNKNOWNS];
    return hypot(m[2][UNKNOWNS], m[3][UNKNOWNS]) / o->rate + hypot(m[0][UNKNOWNS], m[1][UNKNOWNS]) / hypot(o->cosine, o->sine);
}

bool oscillation_fit(const double *u, size_t count, double interval, struct oscillation *out)
{
    double change = INFINITY;
    if (half_period(u, count) == 0 || !guess(u, count, interval, out))
        return false;
    for (int k = 0; k < ROUNDS_MAX && change > 1e-12; k++)
        change = improve(u, count, interval, out);
    return change < 1e-6 && out->rate > 0 && isfinite(out->misfit);
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See impact.h. Classical Runge-Kutta in steps of T0 / 3000 or less: the error is that of the first step, where sqrt(x) is
 * not smooth, some 1e-8. */
#include "calibrate/impact.h"

#include <math.h>

#define STEP_MAX 1e-3

double impact_length(double reduced_mass, double reduced_radius, double modulus, double speed)
{
    return pow(1.5 * reduced_mass * speed * speed / (modulus * sqrt(reduced_radius)), 0.4);
}

void impact_start(struct impact *impact, double damping)
{
    *impact = (struct impact){.damping = damping, .rate = 1};
}

static double pull(const struct impact *impact, double x, double v)
{
    return x > 0 ? -sqrt(x) * (x + impact->damping * v) : 0;
}

static void step(struct impact *impact, double h)
{
    double x = impact->overlap, v = impact->rate;
    double a1 = pull(impact, x, v), v2 = v + 0.5 * h * a1;
    double a2 = pull(impact, x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2;
    double a3 = pull(impact, x + 0.5 * h * v2, v3), v4 = v + h * a3;
    double a4 = pull(impact, x + h * v3, v4);
    double next = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    impact->rate = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    impact->time += h;
    impact->overlap = fmax(0, next);
    if (next <= 0) // at the end the force is all but nothing, and the way straight
        impact->end = impact->time - next / impact->rate;
}

void impact_advance(struct impact *impact, double by)
{
    double until = impact->time + by;
    int count = (int)fmin(1e7, ceil(by / STEP_MAX));
    for (int k = 0; k < count && impact->end == 0; k++)
        step(impact, by / count);
    impact->time = until;
}

double impact_force(const struct impact *impact)
{
    return -pull(impact, impact->overlap, impact->rate);
}

double impact_restitution(double damping, double *duration)
{
    struct impact impact;
    impact_start(&impact, damping);
    while (impact.end == 0 && impact.time < 1000)
        impact_advance(&impact, STEP_MAX);
    *duration = impact.end;
    return -impact.rate;
}

double impact_damping(double restitution)
{
    double low = 0, high = 1, unused;
    while (impact_restitution(high, &unused) > restitution && high < 64)
        high *= 2;
    for (int k = 0; k < 45; k++) {
        double middle = 0.5 * (low + high);
        *(impact_restitution(middle, &unused) > restitution ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

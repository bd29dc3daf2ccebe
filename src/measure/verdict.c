/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See verdict.h. Windows do not overlap and start at t = 0. */
#include "measure/verdict.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define WINDOW       1.0 // s, 70 sqrt(d / g) for d = 2 mm
#define CALM         0.1 // s
#define CALM_RATIO   1e-5
#define STEADY_DRIFT 0.05
#define THIN_LAYERS  6.0
#define THIN_EXTRA   2.0 // s

void verdict_start(struct verdict *v, double diameter, double gravity, double layers, double calm)
{
    *v = (struct verdict){.diameter = diameter,
                          .gravity = gravity,
                          .layers = layers,
                          .calm = calm,
                          .window_end = WINDOW,
                          .calm_since = -1,
                          .steady_since = -1,
                          .t0_s = -1};
    snprintf(v->evidence, sizeof v->evidence, "no window of %g s has ended yet", WINDOW);
}

void verdict_restart(struct verdict *v, double now_s, double gravity)
{
    verdict_start(v, v->diameter, gravity, v->layers, v->calm);
    v->window_end = now_s + WINDOW;
    snprintf(v->evidence, sizeof v->evidence, "no window of %g s has ended since the change at %.6g s", WINDOW, now_s);
}

/* Change over four windows by the straight line of least squares, relative to the mean. */
static double drift(const double mean[VERDICT_WINDOWS])
{
    double slope = (-1.5 * mean[0] - 0.5 * mean[1] + 0.5 * mean[2] + 1.5 * mean[3]) / 5; // a window
    double average = (mean[0] + mean[1] + mean[2] + mean[3]) / 4;
    return average != 0 ? slope * 4 / fabs(average) : 0;
}

static bool monotone(const double m[VERDICT_WINDOWS])
{
    return (m[0] < m[1] && m[1] < m[2] && m[2] < m[3]) || (m[0] > m[1] && m[1] > m[2] && m[2] > m[3]);
}

static void judge_windows(struct verdict *v, double now)
{
    if (v->windows < VERDICT_WINDOWS) {
        snprintf(v->evidence, sizeof v->evidence, "%d of %d windows of %g s have ended; E_kin %.3g J", v->windows, VERDICT_WINDOWS,
                 WINDOW, v->kinetic[VERDICT_WINDOWS - 1]);
        return;
    }
    const double *k = v->kinetic;
    double kinetic = drift(k), height = drift(v->height);
    bool steady = fabs(kinetic) < STEADY_DRIFT && fabs(height) < STEADY_DRIFT && !monotone(k);
    bool rising = k[0] < k[1] && k[1] < k[2] && k[2] < k[3];
    if (!steady)
        v->steady_since = -1;
    else if (v->steady_since < 0)
        v->steady_since = now;
    v->current = VERDICT_UNDECIDED;
    if (steady && (v->layers >= THIN_LAYERS || now - v->steady_since >= THIN_EXTRA - 1e-9)) {
        v->current = VERDICT_STEADY;
        v->t0_s = v->steady_since;
    } else if (rising && k[3] > 2 * k[0]) {
        v->current = VERDICT_ACCELERATING;
    }
    snprintf(v->evidence, sizeof v->evidence,
             "over the four windows to %.4g s E_kin drifts by %+.2g %%, the centre of mass by %+.2g %% (steady below %g %%)%s; "
             "E_kin %.3g, %.3g, %.3g, %.3g J",
             now, 100 * kinetic, 100 * height, 100 * STEADY_DRIFT, monotone(k) ? ", E_kin is monotone" : "", k[0], k[1], k[2],
             k[3]);
}

/* True once the grains have been calm for long enough. */
static bool judge_rest(struct verdict *v, double now, double kinetic, double elastic, double speed_rms)
{
    double ratio = elastic > 0 ? kinetic / elastic : INFINITY;
    double slow = v->calm * sqrt(v->gravity * v->diameter);
    bool calm = now > 10 * sqrt(v->diameter / v->gravity) && (ratio < CALM_RATIO || speed_rms < slow);
    if (!calm)
        v->calm_since = -1;
    else if (v->calm_since < 0)
        v->calm_since = now;
    if (!calm || now - v->calm_since < CALM)
        return false;
    v->current = VERDICT_REST;
    snprintf(v->evidence, sizeof v->evidence,
             "since %.4g s E_kin / E_elastic is below %g or the rms speed below %.2g m/s; now %.2g and %.2g m/s", v->calm_since,
             CALM_RATIO, slow, ratio, speed_rms);
    return true;
}

void verdict_add(struct verdict *v, double time_s, double kinetic, double elastic, double speed_rms, double centre_z)
{
    if (judge_rest(v, time_s, kinetic, elastic, speed_rms))
        return;
    if (v->current == VERDICT_REST)
        v->current = VERDICT_UNDECIDED; // it moves again
    v->kinetic_sum += kinetic;
    v->height_sum += centre_z;
    v->samples++;
    if (time_s < v->window_end - 1e-9)
        return;
    memmove(v->kinetic, v->kinetic + 1, sizeof v->kinetic - sizeof *v->kinetic);
    memmove(v->height, v->height + 1, sizeof v->height - sizeof *v->height);
    v->kinetic[VERDICT_WINDOWS - 1] = v->kinetic_sum / (double)v->samples;
    v->height[VERDICT_WINDOWS - 1] = v->height_sum / (double)v->samples;
    v->windows += v->windows < VERDICT_WINDOWS;
    v->kinetic_sum = v->height_sum = 0;
    v->samples = 0;
    while (v->window_end <= time_s + 1e-9)
        v->window_end += WINDOW;
    judge_windows(v, time_s);
}

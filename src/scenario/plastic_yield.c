/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculation `plastic_yield`: the yield threshold that explains a restitution (seed 000 S2, after Thornton 1997).
 *
 * In units of E* sqrt(r) / m and the speed v_F of the measurement: F = x^(3/2) up to the threshold y, then
 * F = sqrt(y) (3 x - y) / 2, so that the work of loading to x is
 *     W(x) = 2/5 y^(5/2) + sqrt(y) (3/4 (x^2 - y^2) - 1/2 y (x - y)),   W(x_m) = v^2 / 2.
 * What unloading gives back differs between the two:
 *     printed    F = (x - x_0)^(3/2), the radius unchanged                    2/5 F_m^(5/3)
 *     Thornton   a sphere of radius R = x_m^(3/2) / F_m > 1, whose contact
 *                has the same area at x_m, hence F_m = (x_m / R)^(3/2) sqrt(R) 2/5 F_m^2 / sqrt(x_m)
 * The published 0.784 is that of the second; the law as the paper prints it gives 0.7505. */
#include <math.h>

#include "scenario/calculation.h"

/* Restitution at speed v, in units of v_F. */
static double restitution(double y, double v, bool grows)
{
    double energy = 0.5 * v * v, elastic = 0.4 * pow(y, 2.5), root = sqrt(y);
    if (energy <= elastic)
        return 1;
    /* W(x) = energy, a quadratic in x. */
    double a = 0.75 * root, b = -0.5 * root * y, c = elastic - 0.25 * root * y * y - energy;
    double x = (-b + sqrt(b * b - 4 * a * c)) / (2 * a), force = 0.5 * root * (3 * x - y);
    double back = grows ? 0.4 * force * force / sqrt(x) : 0.4 * pow(force, 5.0 / 3.0);
    return sqrt(2 * back) / v;
}

/* Overlap of an elastic impact at speed v: where yield begins if it is the threshold. */
static double elastic_overlap(double v)
{
    return pow(1.25 * v * v, 0.4);
}

static double threshold(double e, bool grows)
{
    double low = 0, high = elastic_overlap(1);
    for (int k = 0; k < 60; k++) {
        double middle = 0.5 * (low + high);
        *(restitution(middle, 1, grows) < e ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

static enum scree_status run(const struct job_spec *job, struct calculation_result *out, struct scree_error *err)
{
    (void)err;
    const struct plastic_yield_params *p = (const struct plastic_yield_params *)(const void *)job->params;
    double printed = threshold(p->restitution, false), thornton = threshold(p->restitution, true), v = p->at_m_s / p->speed_m_s;
    double onset_printed = pow(printed / elastic_overlap(1), 1.25), onset_thornton = pow(thornton / elastic_overlap(1), 1.25);
    const struct scree_number numbers[] = {
        {"threshold_printed", "1", "delta_y / delta with the unloading law as printed", printed},
        {"threshold_thornton", "1", "delta_y / delta with the enlarged radius of unloading", thornton},
        {"onset_printed", "m/s", "impact speed at which yield begins, as printed", onset_printed * p->speed_m_s},
        {"onset_thornton", "m/s", "and with the enlarged radius", onset_thornton * p->speed_m_s},
        {"restitution_printed", "1", "at params.at_m_s, as printed", restitution(printed, v, false)},
        {"restitution_thornton", "1", "and with the enlarged radius", restitution(thornton, v, true)},
    };
    calculation_put(out, numbers, sizeof numbers / sizeof *numbers);
    return SCREE_OK;
}

const struct calculation calculation_plastic_yield = {"plastic_yield", run};

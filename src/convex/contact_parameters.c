/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Contact parameters of the linear spring and dashpot.
 *
 * Slips of the paper, so that its tables can be understood: Table I's k_n of the
 * crosses is that of an impact on a wall, m_ij = m (two crosses would have half
 * of it); Table II rests on e_t = 0.3, which is not stated; restitution and
 * duration hold without the clamp of eq. 5; A9 with R in place of R_ij is four
 * times as stiff for like spheres. Eq. 16 is used in its short form: (1 + 1/zeta^2)
 * sin^2(atan zeta) = 1. */
#include "convex/contact_parameters.h"

#include <math.h>

static double reduced(double a, double b)
{
    return isinf(a) ? b : isinf(b) ? a : a * b / (a + b);
}

static enum scree_status check(const char *name, double value, double above, double to, const char *unit, struct scree_error *err)
{
    if (value > above && value <= to)
        return SCREE_OK;
    return scree_fail(err, SCREE_INVALID, name, "%s: %g%s%s is outside %g..%g", name, value, *unit ? " " : "", unit, above, to);
}

static enum scree_status check_wanted(const struct contact_wanted *w, struct scree_error *err)
{
    const struct {
        const char *name;
        double value, above, to;
        const char *unit;
    } rows[] = {{"mass", reduced(w->a.mass, w->b.mass), 0, 1e12, "kg"},
                {"radius", reduced(w->a.radius, w->b.radius), 0, 1e6, "m"},
                {"inertia", reduced(w->a.inertia, w->b.inertia), 0, 1e12, "kg m2"},
                {"restitution", w->restitution, 0, 1, ""},
                {"restitution_t", w->restitution_t, 0, 1, ""},
                {"rolling_friction", w->rolling_friction, -1e-300, 100, ""},
                {"steps", w->steps, 1, 1e9, ""}};
    enum scree_status status = SCREE_OK;
    for (unsigned k = 0; k < sizeof rows / sizeof *rows && !status; k++)
        status = check(rows[k].name, rows[k].value, rows[k].above, rows[k].to, rows[k].unit, err);
    return status;
}

/* exp(-atan(zeta) / zeta) with zeta = -pi / ln e: how much less far a damped impact goes than an elastic one. */
static double damped_reach(double restitution)
{
    if (restitution >= 1)
        return 1;
    double zeta = -M_PI / log(restitution);
    return exp(-atan(zeta) / zeta);
}

double contact_parameters_overlap(const struct contact_wanted *w, double stiffness, double speed)
{
    return speed * sqrt(reduced(w->a.mass, w->b.mass) / stiffness) * damped_reach(w->restitution);
}

double contact_parameters_hertz(double young, double poisson, double reduced_radius)
{
    return 2 * young * reduced_radius / (3 * (1 - poisson * poisson));
}

enum scree_status contact_parameters_of_stiffness(const struct contact_wanted *w, double stiffness, struct contact_parameters *out,
                                                  struct scree_error *err)
{
    enum scree_status status = check_wanted(w, err);
    if (status || (status = check("stiffness", stiffness, 0, 1e15, "N/m", err)))
        return status;
    double m = reduced(w->a.mass, w->b.mass), r = reduced(w->a.radius, w->b.radius);
    double log_n = log(w->restitution), log_t = log(w->restitution_t);
    double roll =
        1 + m * (w->a.radius * w->a.radius / w->a.inertia + (isinf(w->b.inertia) ? 0 : w->b.radius * w->b.radius / w->b.inertia));
    double across_n = M_PI * M_PI + log_n * log_n, across_t = M_PI * M_PI + log_t * log_t;
    double rolled = 3 * w->rolling_friction * w->rolling_friction * r * r;
    *out = (struct contact_parameters){.mass = m, .stiffness = stiffness, .frequency = sqrt(stiffness / m)};
    out->duration = sqrt(m * across_n / stiffness);
    out->step = out->duration / w->steps;
    out->damping = -2 * m * out->frequency * log_n / sqrt(across_n);
    out->stiffness_t = stiffness / roll * across_t / across_n;
    /* Eq. 19 as eta_n / ln e_n times ln e_t: that ratio stays finite when e_n is 1. */
    out->damping_t = -2 * m * out->frequency * log_t / sqrt(across_n) / roll;
    out->rate = out->damping / (2 * m);
    out->rate_t = out->damping_t / (2 * m);
    out->stiffness_r = rolled * stiffness;
    out->damping_r = rolled * out->damping;
    return SCREE_OK;
}

enum scree_status contact_parameters_find(const struct contact_wanted *w, struct contact_parameters *out, struct scree_error *err)
{
    enum scree_status status = check("overlap", w->overlap, 0, 1e3, "m", err);
    if (status || (status = check("speed", w->speed, 0, 1e6, "m/s", err)) || (status = check_wanted(w, err)))
        return status;
    double rate = w->speed / w->overlap * damped_reach(w->restitution);
    return contact_parameters_of_stiffness(w, reduced(w->a.mass, w->b.mass) * rate * rate, out, err);
}

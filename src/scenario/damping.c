/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculation `damping`: beta from a restitution that was measured (seed 000 S4.1).
 *
 * The impact in its own units (calibrate/impact.h) has the restitution e for one ratio b = beta v / L; beta follows from b
 * with the length L of two free spheres, (pi rho (1 - nu^2) v^2 / 4 E)^(2/5) 2 r. The paper prints r in place of 2 r,
 * which gives 35.6 ns, and publishes 45.1 ns, which is what remains when pi is dropped: both can be asked for, and
 * `restitution` says what the spheres then really do. */
#include <math.h>

#include "calibrate/impact.h"
#include "scenario/calculation.h"

static double length_of(const struct material_spec *m, enum damping_length which, double speed)
{
    double modulus = m->young_Pa / (1 - m->poisson * m->poisson);
    double whole = impact_length(0.5 * material_grain_mass(m), 0.5 * m->radius_m, modulus, speed);
    return which == DAMPING_PRINTED ? 0.5 * whole : which == DAMPING_PUBLISHED ? whole / pow(M_PI, 0.4) : whole;
}

static enum scree_status run(const struct job_spec *job, struct calculation_result *out, struct scree_error *err)
{
    (void)err;
    const struct damping_params *p = (const struct damping_params *)(const void *)job->params;
    const struct material_spec *m = &job->material;
    double b = impact_damping(p->restitution), length = length_of(m, (enum damping_length)p->length, p->speed_m_s);
    double right = length_of(m, DAMPING_FREE, p->speed_m_s), beta = b * length / p->speed_m_s, duration;
    double restitution = impact_restitution(beta * p->speed_m_s / right, &duration);
    const struct scree_number numbers[] = {
        {"damping_ratio", "1", "beta over the time scale tau", b},
        {"length", "m", "scale of the overlap, as params.length says", length},
        {"tau", "s", "that length over the speed", length / p->speed_m_s},
        {"beta", "s", "damping parameter", beta},
        {"restitution", "1", "of two free spheres with that beta, at that speed", restitution},
        {"contact_time", "s", "and how long they touch", duration * right / p->speed_m_s},
    };
    calculation_put(out, numbers, sizeof numbers / sizeof *numbers);
    return SCREE_OK;
}

const struct calculation calculation_damping = {"damping", run};

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The numbers that sum a run up. */
#include <math.h>
#include <string.h>

#include "world/state.h"

static size_t flow_summary(const struct scree_world *w, struct scree_number *out)
{
    double t0 = w->verdict.t0_s, now = dem_time(w->dem), from = t0 >= 0 && t0 < now ? t0 : 0.5 * now;
    double force[WINDOW_VALUES], bulk[WINDOW_VALUES], gravity[3];
    double window = window_means(&w->force_window, from, force);
    double bulk_from = window_means(&w->bulk_window, from, bulk);
    w->scenario->gravity(&w->job, gravity);
    double d = 2 * w->job.material.radius_m, g = hypot(gravity[0], gravity[2]);
    double weight = w->last.mass * -gravity[2], pull = w->last.mass * gravity[0];
    double height = 2 * (bulk[BULK_MEAN_HEIGHT] - w->base_z), fraction = w->last.volume / (w->area * height);
    /* Bagnold's profile: local inertial number from the mean velocity (protocols 1.11). */
    double inertial = 2.5 * bulk[BULK_MEAN_VX] * d / (height * sqrt(fraction * -gravity[2] * height));
    const struct scree_number all[] = {
        {"window_start", "s", "means below are from here to the end: t_0 if steady, else the last half",
         w->force.on ? window : bulk_from},
        {"mean_force_x", "N", "downslope force on the base", force[0]},
        {"mean_force_y", "N", "cross-slope", force[1]},
        {"mean_force_z", "N", "base-normal, negative into the base", force[2]},
        {"weight_normal", "N", "weight of the flow along the base's normal", weight},
        {"force_over_weight", "1", "mean normal force over weight: 1 when steady", -force[2] / weight},
        {"weight_tangential", "N", "weight of the flow downslope", pull},
        {"friction_ratio", "1", "mean downslope over normal force", -force[0] / force[2]},
        {"flow_height", "m", "twice the height of the centre of mass over the base", height},
        {"solid_fraction", "1", "volume of grains over area times flow height", fraction},
        {"mean_velocity", "m/s", "of the flow downslope", bulk[BULK_MEAN_VX]},
        {"mean_velocity_sqrt_gd", "1", "the same over sqrt(g d)", bulk[BULK_MEAN_VX] / sqrt(g * d)},
        {"inertial_number", "1", "bulk, from a Bagnold profile", inertial},
        {"speed_rms", "m/s", "root mean square speed of the grains", bulk[BULK_MEAN_SPEED]},
        {"contacts_per_grain", "1", "coordination number", bulk[BULK_MEAN_CONTACTS]},
        {"kinetic_energy", "J", "", bulk[BULK_MEAN_KINETIC]},
        {"steady_since", "s", "t_0, -1 if the flow was not found steady", t0},
        {"fixed_per_d2", "1", "grains of the base over its area in grain diameters squared",
         (double)dem_fixed(w->dem) * d * d / w->area},
    };
    memcpy(out, all, sizeof all);
    return sizeof all / sizeof *all;
}

size_t scree_world_summary(const struct scree_world *w, struct scree_number numbers[SCREE_SUMMARY_MAX])
{
    size_t count = 0;
    if (w->release)
        return dem_step(w->dem) > 0 ? flow_numbers(w, numbers) : 0;
    if (w->area > 0 && dem_step(w->dem) > 0)
        count = flow_summary(w, numbers);
    if (w->contact.on)
        count += contact_summary(&w->trace, w->job.time.step_s, numbers + count);
    return count;
}

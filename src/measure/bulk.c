/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See bulk.h. Sums run over rows in memory order, which is part of a world's
 * state, so they are the same in every run. */
#include "measure/bulk.h"

#include <math.h>

static const struct scree_column bulk_columns[BULK_COLUMNS] = {
    {"time", "s"}, {"kinetic", "J"}, {"elastic", "J"}, {"speed_rms", "m/s"}, {"centre_z", "m"}, {"vx", "m/s"},     {"vy", "m/s"},
    {"vz", "m/s"}, {"px", "kg m/s"}, {"py", "kg m/s"}, {"pz", "kg m/s"},     {"force_z", "N"},  {"contacts", "1"},
};
const struct scree_stream bulk_stream = {"bulk", "energies, centre of mass and momentum of the moving grains", bulk_columns,
                                         BULK_COLUMNS, false};

static const struct scree_column energy_columns[ENERGY_COLUMNS] = {
    {"time", "s"},
    {"gravity_work", "J"},
    {"kinetic_translation", "J"},
    {"kinetic_rotation", "J"},
    {"elastic", "J"},
    {"dissipated_normal", "J"},
    {"dissipated_tangential", "J"},
    {"dissipated_torsion", "J"},
    {"dissipated_rolling", "J"},
    {"residual", "J"},
};
const struct scree_stream energy_stream = {"energy", "ledger: work of gravity = kinetic + elastic + dissipated + residual",
                                           energy_columns, ENERGY_COLUMNS, false};

static double square(const double a[3])
{
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

void bulk_measure(const struct view *view, struct bulk *out)
{
    double translation = 0;
    *out = (struct bulk){.time_s = view->time_s};
    for (size_t i = 0; i < view->moving; i++) {
        const double *v = view->velocity[i], *w = view->spin[i], r = view->position[i][3];
        if (!view->bodies) {
            translation += 0.5 * v[3] * square(v);
            out->rotation += 0.5 * w[3] * square(w);
        }
        for (int a = 0; a < 3; a++)
            out->momentum[a] += v[3] * v[a];
        out->centre_z += v[3] * view->position[i][2];
        out->mass += v[3];
        out->volume += 4.0 / 3.0 * M_PI * r * r * r;
    }
    if (view->bodies)
        out->volume = 0;
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        translation += 0.5 * b->mass * square(b->velocity);
        out->rotation += 0.5 * (b->spin[0] * b->momentum[0] + b->spin[1] * b->momentum[1] + b->spin[2] * b->momentum[2]);
        out->volume += b->volume;
    }
    double sides = 0;
    for (size_t k = 0; k < view->contacts; k++) {
        out->elastic += view->contact[k].elastic;
        sides += view->contact[k].b < view->moving ? 2 : 1;
    }
    out->kinetic = translation + out->rotation;
    out->centre_z /= out->mass;
    out->speed_rms = sqrt(2 * translation / out->mass);
    out->contacts = sides / (double)view->moving;
    for (int a = 0; a < 3; a++) {
        out->velocity[a] = out->momentum[a] / out->mass;
        out->force[a] = view->base_force[a];
    }
}

void bulk_row(const struct bulk *b, double row[BULK_COLUMNS])
{
    const double values[BULK_COLUMNS] = {b->time_s,      b->kinetic,     b->elastic,     b->speed_rms,   b->centre_z,
                                         b->velocity[0], b->velocity[1], b->velocity[2], b->momentum[0], b->momentum[1],
                                         b->momentum[2], b->force[2],    b->contacts};
    for (int k = 0; k < BULK_COLUMNS; k++)
        row[k] = values[k];
}

void energy_row(const struct view *view, const struct bulk *b, double start, double row[ENERGY_COLUMNS])
{
    double dissipated = view->dissipated_normal + view->dissipated_tangential + view->dissipated_torsion + view->dissipated_rolling;
    const double values[ENERGY_COLUMNS] = {view->time_s,
                                           view->gravity_work,
                                           b->kinetic - b->rotation,
                                           b->rotation,
                                           b->elastic,
                                           view->dissipated_normal,
                                           view->dissipated_tangential,
                                           view->dissipated_torsion,
                                           view->dissipated_rolling,
                                           view->gravity_work + start - b->kinetic - b->elastic - dissipated};
    for (int k = 0; k < ENERGY_COLUMNS; k++)
        row[k] = values[k];
}

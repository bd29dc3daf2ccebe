/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sums over all moving grains at one instant, and the ledger of energy. */
#ifndef SCREE_MEASURE_BULK_H
#define SCREE_MEASURE_BULK_H

#include "scree.h"
#include "view.h"

struct bulk {
    double time_s;
    double kinetic;      // translation and rotation, J
    double rotation;     // of that, J
    double elastic;      // in the springs of contacts, J
    double speed_rms;    // mass-weighted, m/s
    double centre_z;     // height of the centre of mass, m
    double velocity[3];  // of the centre of mass, m/s
    double momentum[3];  // kg m/s
    double force[3];     // on the base, N
    double contacts;     // contacts a moving grain has, those with the base included (coordination number)
    double mass, volume; // of moving grains, kg, m3
    double grains;       // how many they are: rows
};

/* Rows of the streams `bulk` and `energy`. */
enum { BULK_COLUMNS = 13, ENERGY_LOST = 5, ENERGY_RESIDUAL = 9, ENERGY_COLUMNS = 10 };

void bulk_measure(const struct view *view, struct bulk *out);
/* The same of grains whose y is in [region[0], region[1]), and of their contacts; of bodies only all. */
void bulk_measure_within(const struct view *view, const double region[2], struct bulk *out);
void bulk_row(const struct bulk *bulk, double row[BULK_COLUMNS]);

/* `start` is the energy (kinetic and elastic) at t = 0, J: the residual is what
 * the work of gravity and the start leave unexplained (energy.c). */
void energy_row(const struct view *view, const struct bulk *bulk, double start, double row[ENERGY_COLUMNS]);

#endif

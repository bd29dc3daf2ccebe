/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The one contact of scenario `collision`: its trace, and what it amounts to. */
#ifndef SCREE_MEASURE_CONTACT_H
#define SCREE_MEASURE_CONTACT_H

#include "scree.h"
#include "view.h"

enum { CONTACT_COLUMNS = 10, CONTACT_NUMBERS = 17 };

struct contact_trace {
    bool touching, ended;
    double before[3], after[3];                 // velocity of 1 relative to 2 when apart, m/s
    double start_s, end_s;                      // of the contact, interpolated within a step, s
    double last_s, last_overlap, last_approach; // while touching
    double largest_overlap, largest_force;      // m, N
    double impulse[3];                          // of 1 on 2, trapezoid over samples, N s
    double last_force[3];
    double dissipated;       // kinetic energy lost, J
    double energy_before;    // J
    double spin_after[2][3]; // rad/s
    uint64_t samples;        // with overlap
};

/* One sample; fills a row of the stream. `trace` starts zeroed. */
void contact_measure(const struct view *view, struct contact_trace *trace, double row[CONTACT_COLUMNS]);

/* Restitution, contact time, ...; returns how many. */
size_t contact_summary(const struct contact_trace *trace, double step_s, struct scree_number numbers[CONTACT_NUMBERS]);

#endif

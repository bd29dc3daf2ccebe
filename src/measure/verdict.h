/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Is a flow at rest, steady, accelerating? Protocols 1.5, on samples of bulk
 * every millisecond, whatever is recorded:
 *   rest          E_kin / E_elastic < 1e-5, or rms speed < 1e-5 sqrt(g d), for
 *                 0.1 s, and not before 10 sqrt(d / g) (a world starts at rest)
 *   steady        over the last four windows of 1 s the means of E_kin and of the
 *                 height of the centre of mass have |slope| * 4 s < 5 % of the mean
 *                 and do not rise or fall four times in a row; t_0 is the end of
 *                 the fourth; thin flows (under six grains deep) must stay so for 2 s more
 *   accelerating  E_kin rises from window to window and more than doubles over four
 *   undecided     none of these yet */
#ifndef SCREE_MEASURE_VERDICT_H
#define SCREE_MEASURE_VERDICT_H

#include "scree.h"

#define VERDICT_CALM 1e-5
enum { VERDICT_WINDOWS = 4, VERDICT_EVIDENCE_MAX = 240 };

struct verdict {
    /* What the flow is like; set at the start. */
    double diameter, gravity, layers; // m, m/s2, grains
    double calm;                      // rms speed over sqrt(g d) that is rest: 1e-5; more where contacts keep wandering
    /* State. */
    double window_end, kinetic_sum, height_sum;
    uint64_t samples;
    double kinetic[VERDICT_WINDOWS], height[VERDICT_WINDOWS]; // means of the last windows, oldest first
    int windows;                                              // whole ones so far, at most VERDICT_WINDOWS
    double calm_since, steady_since;                          // s, negative: not so now
    double t0_s;                                              // start of steady flow, negative: none
    enum scree_verdict current;
    char evidence[VERDICT_EVIDENCE_MAX];
};

void verdict_start(struct verdict *verdict, double diameter, double gravity, double layers, double calm);

/* Forgets what was seen before now_s: forces have changed. */
void verdict_restart(struct verdict *verdict, double now_s, double gravity);

/* One sample at rising times; updates `current` and `evidence`. */
void verdict_add(struct verdict *verdict, double time_s, double kinetic, double elastic, double speed_rms, double centre_z);

#endif

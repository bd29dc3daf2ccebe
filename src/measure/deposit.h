/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a collapse of a continuum is measured by (seed 002, section 4.2; protocols
 * 3.2): free surface, line between static and flowing, front, run-out, height at
 * the back wall, inertial numbers, and how much volume was lost. */
#ifndef SCREE_MEASURE_DEPOSIT_H
#define SCREE_MEASURE_DEPOSIT_H

#include "continuum_view.h"
#include "scree.h"

/* Where the collapse takes place. */
struct deposit_site {
    double bed;   // height of the bed under the column, m
    double gate;  // x at which the column ends, m
    double start; // time at which the gate begins to lift, s
};

#define DEPOSIT_THRESHOLD 0.002 // m above the bed: where a deposit ends (Balmforth & Kerswell's rule, seed 002 Table 2)
#define DEPOSIT_REST      0.01  // m/s: static below (seed 002, section 4.2)
#define DEPOSIT_INERTIAL  5e-4  // nodes below are static and left out of the quantiles (seed 002, Fig. 13)

struct deposit {
    double time_s;             // since the gate began to lift: negative before
    double run_out;            // from the gate to the end of the deposit deeper than 2 mm, m, at the side wall
    double furthest;           // x of the furthest point that is 2 mm above the bed, from the back wall, m
    double height_back;        // of the surface over the bed at the back wall, m
    double fastest;            // speed of the fastest point, m/s
    double flowing;            // share of the material that moves at 0.01 m/s or more
    double inertial[3];        // quantiles 0.3, 0.5, 0.7 of the inertial number
    double surface_volume;     // under the free surface, m3 (bed included); too much by half a cell while a gate holds the column
    double overfull;           // volume of material that nodes hold beyond their room, m3
    double kinetic, potential; // J
    double inclination;        // of the box, deg
    double surface_angle;      // of the surface over the middle of the box against the horizontal, deg
    double residual_mean, residual_largest; // squared, of the last step
    /* Against the sample before, for whoever keeps it: */
    double front_speed; // of run_out, m/s
    double sweeps;      // a step
};

/* A row of the stream `deposit`. */
enum { DEPOSIT_COLUMNS = 19 };
extern const struct scree_stream deposit_stream;

/* Lines along the flow, one value a layer of nodes along x; and room for the quantiles. */
struct deposit_lines {
    size_t layers;
    double *surface; // height of the contour phi = 0.5, m; 0 where there is none
    double *still;   // height below which |u| < 0.01 m/s, m
    double *inertial;
};

/* Room for worlds of that shape; owned by the caller until deposit_lines_free. */
enum scree_status deposit_lines_start(struct deposit_lines *lines, const struct continuum_view *view, struct scree_error *err);
void deposit_lines_free(struct deposit_lines *lines);

/* Surface and static line at one layer of nodes across the channel (0: the side wall, as the camera sees it). */
void deposit_trace(const struct continuum_view *view, int layer_y, struct deposit_lines *lines);

/* Fills *out from a view, but what needs the sample before; traces the side wall's lines. */
void deposit_measure(const struct continuum_view *view, const struct deposit_site *site, struct deposit_lines *lines,
                     struct deposit *out);

/* A frame of the stream `surface`, lines->layers rows, from traced lines: at the side wall. */
enum { SURFACE_COLUMNS = 4 };
extern const struct scree_stream surface_stream;
void deposit_surface(const struct continuum_view *view, const struct deposit_lines *lines, double (*rows)[SURFACE_COLUMNS]);

/* The same as a row of a stream. */
void deposit_row(const struct deposit *deposit, double row[DEPOSIT_COLUMNS]);

#endif

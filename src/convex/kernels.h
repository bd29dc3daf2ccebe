/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Loops of a step that are compiled once per instruction set; the same bits on all.
 * Private to this folder. */
#ifndef SCREE_CONVEX_KERNELS_H
#define SCREE_CONVEX_KERNELS_H

#include "base/cpu.h"

struct convex;

struct convex_kernels {
    /* First half kick and drift of all bodies; returns more than 0 when a centre has left its margin since lists were
     * made, or NaN when a motion is no longer finite. */
    double (*move)(struct convex *convex);
    void (*kick)(struct convex *convex); // the second half
    /* Contacts between bodies, and with walls, and what bodies feel of them. */
    enum scree_status (*meet)(struct convex *convex, struct scree_error *err);
    enum scree_status (*meet_walls)(struct convex *convex, struct scree_error *err);
};

const struct convex_kernels *convex_kernels_for(enum cpu_isa isa);

#endif

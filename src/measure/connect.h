/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The base-connected set C (seed 000 S1; protocols 1.8): every grain that a chain
 * of contacts joins to the base. Grains of the base belong to it; so does what
 * touches a wall of the base. Periodic images are one grain; members of a rigid
 * body are joined. */
#ifndef SCREE_MEASURE_CONNECT_H
#define SCREE_MEASURE_CONNECT_H

#include "view.h"

/* What counts as a contact. */
enum connect_rule {
    CONNECT_OVERLAP, // overlap >= 0
    CONNECT_PUSH,    // normal force > 0: leaves out the end of a damped contact, where eq. 5 pulls
};

/* Rows of scratch that a view needs. */
static inline size_t connect_rows(const struct view *view)
{
    return view->moving + view->fixed + 1;
}

/* Sets root[i] for every row i and for the base, which has the last row of connect_rows:
 * row i is of C if root[i] is the base's. Union-find with the smaller root winning. */
void connect_base(const struct view *view, enum connect_rule rule, uint32_t *root);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The fragments of seed 003 and the space behind the gate that they start in. */
#ifndef SCREE_SCENARIO_FRAGMENTS_H
#define SCREE_SCENARIO_FRAGMENTS_H

#include "dem/dem.h"
#include "geom/chute.h"
#include "spec/spec.h"

enum fragment_shape { FRAGMENT_CUBE, FRAGMENT_HALF, FRAGMENT_QUARTER, FRAGMENT_SHAPES };

struct chute fragments_chute(const struct job_spec *job);

/* Shapes (the user's own clast in place of all of them, where there is one), and bodies at rest in random places and orientations
 * without overlap, cubes first (protocols 4): the same for the same job. Refuses a mass that does not fit and says how much does.
 * *bodies is owned by the caller. */
enum scree_status fragments_fill(const struct job_spec *job, struct clump shapes[FRAGMENT_SHAPES], struct dem_body **bodies,
                                 size_t *count, struct scree_error *err);

#endif

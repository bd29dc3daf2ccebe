/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A flow of bodies cut into slices: by height while it runs (seed 003, Fig. 6),
 * along the chute when it lies (Figs 7 and 16). */
#ifndef SCREE_MEASURE_OUTLINE_H
#define SCREE_MEASURE_OUTLINE_H

#include "measure/mobility.h"

/* Layers one grain size thick of the central 5 cm around `place`, from the floor up. Returns how many rows it wrote. */
enum { LAYER_COLUMNS = 5, LAYERS_MAX = 64 };
size_t outline_layers(const struct view *view, const struct mobility_site *site, double place,
                      double rows[LAYERS_MAX][LAYER_COLUMNS]);

/* Centimetres of the flow proper along the chute. The caller owns *rows. */
enum { OUTLINE_COLUMNS = 7 };
enum scree_status outline_deposit(const struct view *view, const struct mobility_site *site, const uint8_t *in_flow,
                                  double (**rows)[OUTLINE_COLUMNS], size_t *count, struct scree_error *err);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A sweep over scenarios, where grains and a continuum do the same: force on the
 * base and surface side by side, and what each can and cannot say. */
#ifndef SCREE_CLIENT_PLOT_PAIR_H
#define SCREE_CLIENT_PLOT_PAIR_H

#include "link.h"
#include "picture.h"

/* Whether a study's trials differ in their scenario, by its record of `show`. */
bool plot_pair_fits(const cJSON *record);

/* The first trial of grains beside the first of a continuum; OUTCOME_REFUSED while one of them has nothing to show. */
enum outcome plot_pair_draw(struct link *link, const cJSON *record, struct picture *picture, struct scree_error *err);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A row of a job's picture: profiles by height over the base. */
#ifndef SCREE_CLIENT_PLOT_PROFILES_H
#define SCREE_CLIENT_PLOT_PROFILES_H

#include <stdio.h>

#include "reader.h"

enum { PLOT_PROFILE_PANELS = 4 };
struct plot_profiles {
    FILE *script;
    double top;                          // of what flows, mm
    double largest[PLOT_PROFILE_PANELS]; // as drawn
    size_t rows;
};

/* A frame of the stream as data of the script; `context` is a struct plot_profiles. */
void plot_profiles_take(void *context, const struct reader_chunk *chunk);

/* The plots, between `low` and `low + high` of the picture's height. */
void plot_profiles_draw(const struct plot_profiles *profiles, double low, double high);

#endif

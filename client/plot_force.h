/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A force against time as a picture can show it: a stream has millions of samples
 * and a picture a thousand columns, so samples are gathered into bins of equal time,
 * each with mean, least and largest value of every component, while it is read. */
#ifndef SCREE_CLIENT_PLOT_FORCE_H
#define SCREE_CLIENT_PLOT_FORCE_H

#include "picture.h"
#include "reader.h"

enum { PLOT_FORCE_BINS = 900, PLOT_FORCE_COMPONENTS = 3 };

struct plot_force {
    double begin, end; // s
    struct plot_force_bin {
        double count, sum[PLOT_FORCE_COMPONENTS], least[PLOT_FORCE_COMPONENTS], most[PLOT_FORCE_COMPONENTS];
    } bins[PLOT_FORCE_BINS];
};

/* For plot_read_stream; `context` is a struct plot_force whose times are set. */
void plot_force_take(void *context, const struct reader_chunk *chunk);

/* The bins as data of the script, under a name like "$force": time, then mean, least and most of each component. */
void plot_force_write(struct picture *picture, const char *name, const struct plot_force *force);

#endif

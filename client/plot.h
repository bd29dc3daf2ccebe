/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What `scree plot` draws of a job, and of a study. */
#ifndef SCREE_CLIENT_PLOT_H
#define SCREE_CLIENT_PLOT_H

#include "link.h"
#include "picture.h"

/* The force on the base against time, and its spectrum if that is recorded. `record` is of `show`. */
enum outcome plot_job(struct link *link, const cJSON *record, const char *file, struct scree_error *err);

/* How a sweep is drawn. */
struct plot_sweep {
    const char *x, *y;  // columns of the table, NULL for the first that tell something
    const char *by;     // the column whose values get a line each; NULL: all that differ beside x
    bool log;           // both axes logarithmic, and a power law fitted to each line
    const char *beside; // power laws to draw beside them, "FACTOR,EXPONENT FACTOR,EXPONENT ..."; NULL: none
};

/* A search: bracket and trials against the round; a sweep: a number of the summary against a parameter. */
enum outcome plot_study(struct link *link, const cJSON *record, const struct plot_sweep *how, const char *file,
                        struct scree_error *err);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A running job on stderr: a bar that is redrawn on a terminal, a line now and
 * then where there is none. */
#ifndef SCREE_CLIENT_PROGRESS_H
#define SCREE_CLIENT_PROGRESS_H

#include <stdbool.h>

#include "protocol/json.h"

enum { PROGRESS_SPARKS = 24 };

struct progress {
    double told;                    // when the last line was written, on now_s's clock
    double sparks[PROGRESS_SPARKS]; // means of the basal normal force over one redrawing each, N, oldest first
    int spark_count;
    double sum, weight; // of what has come since the last redrawing
};

void progress_start(struct progress *progress);

/* Adds the mean of `samples` samples of the force. */
void progress_force(struct progress *progress, double mean, double samples);

/* Shows the job as its summary or record says. */
void progress_show(struct progress *progress, const cJSON *job);

/* Shows a study: a line for the whole, and on a terminal one for each trial that is on its way. */
void progress_show_study(struct progress *progress, const cJSON *study);

/* Takes the bar off the terminal, if there is one. Messages call it before they write. */
void progress_erase(void);

#endif

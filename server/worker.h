/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Threads that run worlds. A worker owns the world it runs; between slices it
 * looks at its orders and publishes a report. */
#ifndef SCREE_SERVER_WORKER_H
#define SCREE_SERVER_WORKER_H

#include "job.h"

struct workers;

/* Starts `count` threads; each report makes event file descriptor `wake_fd` readable. */
enum scree_status workers_start(struct workers **out, int count, int wake_fd, struct scree_error *err);

/* Hands a run to an idle worker; false when there is none. The run must stay
 * until its report says ended. */
bool workers_assign(struct workers *workers, struct run *run);

/* Ends the threads; runs must have been ordered to stop. Blocks until their slices end. */
void workers_stop(struct workers *workers);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How the daemon is, for `ping`: the work that waits, the rate of what runs, disk and memory. */
#ifndef SCREE_SERVER_HEALTH_H
#define SCREE_SERVER_HEALTH_H

#include "config.h"
#include "scheduler.h"

/* Adds jobs, grain_steps_per_s, disk and memory to the object. */
void health_put(cJSON *json, const struct config *config, struct scheduler *scheduler);

/* Bytes of memory that the machine has to give, as the kernel estimates it. */
double health_memory_available(void);

#endif

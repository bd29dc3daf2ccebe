/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The control thread: owns the three sockets, answers requests, wakes scheduler and streams. */
#ifndef SCREE_SERVER_CONTROL_H
#define SCREE_SERVER_CONTROL_H

#include "config.h"

/* Runs the daemon until SIGTERM, SIGINT or a shutdown request. The signals must
 * be blocked in the calling thread before any other thread is started. */
enum scree_status control_run(const struct config *config, struct scree_error *err);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the daemon was told: options over the config file over defaults. */
#ifndef SCREE_SERVER_CONFIG_H
#define SCREE_SERVER_CONFIG_H

#include <stdbool.h>

#include "base/status.h"

enum { CONFIG_PATH_MAX = 1024 };

struct config {
    char runtime[CONFIG_PATH_MAX]; // directory of the sockets
    char listen[CONFIG_PATH_MAX];  // control endpoint
    char stream[CONFIG_PATH_MAX], events[CONFIG_PATH_MAX];
    char data[CONFIG_PATH_MAX]; // journal.db, jobs/
    int workers;
    double checkpoint_s;       // wall time between checkpoints of a running job, 0: only at steering
    double disk_floor_gb;      // free space below which jobs are held; negative: 1 GB, or a twentieth of a small disk
    double memory_gb;          // that all worlds together may take; negative: what the machine has free
    char log[CONFIG_PATH_MAX]; // file, "": stderr
    int ready_fd;              // -1: none
    int parent;                // end when this process does; 0: none
    bool help, version;
};

/* Reads the command line (and the file that --config names). SCREE_INVALID says what is wrong and where. */
enum scree_status config_read(struct config *config, int argc, char **argv, struct scree_error *err);

extern const char config_help[];

#endif

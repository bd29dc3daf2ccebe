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
    int ready_fd; // -1: none
    int parent;   // end when this process does; 0: none
    bool help, version;
};

/* Reads the command line (and the file that --config names). SCREE_INVALID says what is wrong and where. */
enum scree_status config_read(struct config *config, int argc, char **argv, struct scree_error *err);

extern const char config_help[];

#endif

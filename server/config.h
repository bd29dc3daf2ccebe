/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the daemon was told: options over the config file over defaults. */
#ifndef SCREE_SERVER_CONFIG_H
#define SCREE_SERVER_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

enum { CONFIG_PATH_MAX = 1024 };

struct config {
    char runtime[CONFIG_PATH_MAX]; // directory of the sockets
    char listen[CONFIG_PATH_MAX];  // control endpoint
    char stream[CONFIG_PATH_MAX], events[CONFIG_PATH_MAX];
    char data[CONFIG_PATH_MAX]; // journal.db, jobs/
    int workers;
    double checkpoint_s;                    // wall time between checkpoints of a running job, 0: only at steering
    double disk_floor_gb;                   // free space below which jobs are held; negative: 1 GB, or a twentieth of a small disk
    double memory_gb;                       // that all worlds together may take; negative: what the machine has free
    char log[CONFIG_PATH_MAX];              // file, "": stderr
    char network[CONFIG_PATH_MAX];          // tcp://ADDRESS:PORT of the control endpoint, "" when there is none
    char keys[CONFIG_PATH_MAX];             // folder of server.key and trusted
    int max_jobs, max_fetches, max_streams; // of one user from the network
    int max_connections;                    // from the network, over all three sockets
    int stall_s;                            // without progress of a job, before the watchdog is let go
    int handshake_s;                        // within which a connection must have proved who it is
    int ready_fd;                           // -1: none
    int parent;                             // end when this process does; 0: none
    bool help, version, man;
};

/* An option: of the command line as `--name`, of the config file as `name = value`. */
enum config_kind { CONFIG_TEXT, CONFIG_NUMBER, CONFIG_REAL }; // char[CONFIG_PATH_MAX], int, double
struct config_option {
    const char *name, *argument;
    const char *doc;      // what it does, and its unit
    const char *standard; // what holds when it is not given, for people
    enum config_kind kind;
    size_t offset; // in struct config
    double low, high;
};
/* Ends with a name of NULL. */
extern const struct config_option config_options[];

/* Reads the command line (and the file that --config names). SCREE_INVALID says what is wrong and where. */
enum scree_status config_read(struct config *config, int argc, char **argv, struct scree_error *err);

/* What --help prints, and the manual page screed(8) in roff; both out of the table. */
void config_print_help(FILE *file);
void config_print_man(FILE *file);

#endif

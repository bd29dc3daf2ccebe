/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A private screed: started for one run, on a socket of its own, gone with it. */
#ifndef SCREE_CLIENT_DAEMON_H
#define SCREE_CLIENT_DAEMON_H

#include <limits.h>
#include <sys/types.h>

#include "link.h"

struct daemon {
    pid_t pid;              // 0: not running
    char data[PATH_MAX];    // its data and its log; removed at the end
    char runtime[PATH_MAX]; // its sockets; removed at the end
    char endpoint[WIRE_ENDPOINT_MAX];
};

/* Path of the screed that lies beside this program. */
enum outcome daemon_program(char out[PATH_MAX], struct scree_error *err);

/* Starts it and waits until it listens. Its data goes into a hidden folder in
 * `folder`, where the result will go (there is room for it there, which a
 * temporary folder in memory may not have). It dies with this process. */
enum outcome daemon_start(const char *folder, struct daemon *daemon, struct scree_error *err);

/* Whether it still runs. */
bool daemon_alive(struct daemon *daemon);

/* The last line of its log, "" if there is none. */
void daemon_last_words(const struct daemon *daemon, char *out, size_t size);

/* Asks it to end, insists after some seconds, and removes its folders. `at_once` insists from the start. */
void daemon_stop(struct daemon *daemon, struct link *link, bool at_once);

#endif

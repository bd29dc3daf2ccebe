/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the service manager is told (sd_notify(3), a datagram on $NOTIFY_SOCKET): that
 * the daemon is ready, that it ends, and, as long as its work goes on, that it is
 * alive. Without a service manager all of this does nothing. */
#ifndef SCREE_SERVER_NOTIFY_H
#define SCREE_SERVER_NOTIFY_H

#include "scheduler.h"

struct notify;

enum scree_status notify_open(struct notify **out, int stall_s, struct scree_error *err);
void notify_close(struct notify *notify);

void notify_ready(struct notify *notify);
void notify_stopping(struct notify *notify);

/* Feeds the watchdog, at half the period that the manager asked for, unless some
 * running job has not moved for stall_s: a daemon that answers while its workers
 * hang is not alive. To be called at every turn of the loop. */
void notify_turn(struct notify *notify, struct scheduler *scheduler);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The gate to the network: accepts TCP and hands the bytes on to sockets in the
 * runtime directory, where the encryption ends.
 *
 * ZeroMQ by itself takes any number of connections, waits 30 s for each to say
 * who it is and buffers up to a whole frame of 2 MiB for each meanwhile; when file
 * descriptors run out it spins or aborts. So strangers are held off before it: a
 * fixed number of places, few of them for those who have not proved a trusted key,
 * and for these a deadline and 2 KiB. A flood crowds out itself: who comes from an
 * address that holds many of these places takes one of its own. Connections that
 * have proved themselves are never given up for new ones.
 *
 * One thread, no lock: it shares nothing with the others but its end. */
#ifndef SCREE_SERVER_GATE_H
#define SCREE_SERVER_GATE_H

#include "config.h"

struct gate;

enum { GATE_SOCKETS = 3 };

/* The endpoint behind the gate for socket `index` (control, stream, events), to be bound before it opens. */
enum scree_status gate_inner(const struct config *config, int index, char out[CONFIG_PATH_MAX], struct scree_error *err);
/* The endpoint before it, as clients are told it. */
enum scree_status gate_outer(const struct config *config, int index, char out[CONFIG_PATH_MAX], struct scree_error *err);

/* Listens on config->network and the two ports after it. */
enum scree_status gate_open(struct gate **out, const struct config *config, struct scree_error *err);
/* When the daemon has closed its ends: what it sent last still goes out, for a second at most; then drops every connection. */
void gate_close(struct gate *gate);

#endif

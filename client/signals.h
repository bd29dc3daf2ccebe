/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ctrl-C (and SIGTERM, SIGHUP) as a count that loops look at.
 *
 * A verb that has something to tidy up catches them; the others die of them as
 * any program does. Every wait of the client is cut into slices of at most
 * WAIT_SLICE_MS, so that a signal is seen soon even when it falls just before
 * the wait. */
#ifndef SCREE_CLIENT_SIGNALS_H
#define SCREE_CLIENT_SIGNALS_H

enum { WAIT_SLICE_MS = 100 };

/* SIGPIPE and SIGXFSZ are ignored from here on: a write says EPIPE or EFBIG. */
void signals_start(void);

/* From now on interrupts are counted. The third ends the process at once. */
void signals_catch(void);
int signals_count(void);

/* Dies of the signal that came last, as if it had not been caught. */
void signals_die(void);

/* In a child between fork and exec: everything as a fresh program expects it. */
void signals_reset(void);

/* Sleeps up to `milliseconds`; an interrupt cuts it short. */
void wait_ms(int milliseconds);

#endif

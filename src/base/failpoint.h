/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Named places at which tests end the process, as a power failure would.
 *
 * Nothing of the test is in here: the function is looked for when the program is
 * loaded, and a library that a test preloads has it. Otherwise a failpoint is the
 * look at one pointer, in places that wait for a disk anyway. */
#ifndef SCREE_BASE_FAILPOINT_H
#define SCREE_BASE_FAILPOINT_H

extern void scree_failpoint(const char *name) __attribute__((weak));

#define FAILPOINT(name) (scree_failpoint ? scree_failpoint(name) : (void)0)

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where a result goes, made sure of before the work starts. */
#ifndef SCREE_CLIENT_DESTINATION_H
#define SCREE_CLIENT_DESTINATION_H

#include <limits.h>
#include <stddef.h>

#include "cli.h"

struct destination {
    char file[PATH_MAX];   // the result
    char folder[PATH_MAX]; // that it lies in
    size_t existing;       // how much of `folder` was there before
};

/* Takes `-o`: a name that ends in .h5 is the file, any other is a folder in which
 * it becomes result.h5. Makes the folder and tries whether a file can be
 * written there: OUTCOME_REFUSED with the reason if not. */
enum outcome destination_prepare(const char *out, struct destination *destination, struct scree_error *err);

/* The folder "STEM" in the current directory, or "STEM-2", "STEM-3", ... if there is one already. */
enum outcome destination_fresh(const char *stem, struct destination *destination, struct scree_error *err);

/* Only tries whether something can be made in the current directory. */
enum outcome destination_try_here(struct scree_error *err);

/* Removes the folders that destination_prepare made, as far as they are empty. */
void destination_abandon(struct destination *destination);

#endif

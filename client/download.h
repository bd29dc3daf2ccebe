/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A job's result from the daemon into a file of ours. */
#ifndef SCREE_CLIENT_DOWNLOAD_H
#define SCREE_CLIENT_DOWNLOAD_H

#include <limits.h>

#include "link.h"

struct download {
    double bytes;
    bool complete; // the job had ended
};

/* Asks for the result so far and copies it piece by piece, so that it works from
 * afar. Written beside as FILE.part-PID, fsynced, renamed: FILE is whole or as
 * it was. An interrupt removes the part and gives OUTCOME_CANCELLED. */
enum outcome download_result(struct link *link, const char *job, const char *file, struct download *out, struct scree_error *err);

/* The same of a study's table of trials: as HDF5 into FILE, which ends in .h5, and as text into a file
 * that ends in .csv beside it, whose name is written to `text_file`. */
enum outcome download_study(struct link *link, const char *study, const char *file, char text_file[PATH_MAX], struct download *out,
                            struct scree_error *err);

#endif

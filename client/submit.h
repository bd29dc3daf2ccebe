/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One spec to the daemon, for `run` and `submit`. */
#ifndef SCREE_CLIENT_SUBMIT_H
#define SCREE_CLIENT_SUBMIT_H

#include "link.h"
#include "spec_file.h"

/* Gives the daemon the mesh that the spec names by a file, submits, and writes the job's id; *reused: a job that had finished the
 * same spec answers. Messages start with the file's name. */
enum outcome submit_spec(struct link *link, const struct spec_file *spec, bool again, char *job, size_t size, bool *reused,
                         struct scree_error *err);

#endif

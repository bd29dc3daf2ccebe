/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What pictures take from a daemon: whole streams of a job, and what its record says. */
#ifndef SCREE_CLIENT_PLOT_READ_H
#define SCREE_CLIENT_PLOT_READ_H

#include "reader.h"

/* Hands every chunk from `from` up to the stream's `count` to `take`. */
enum outcome plot_read_chunks(struct link *link, const char *job, const char *stream, uint64_t from, uint64_t count,
                              void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err);

/* How many chunks a stream has, by the record of `show`; 0 where there is no such stream. */
uint64_t plot_chunks_of(const cJSON *record, const char *stream);

/* A number of the summary; NaN where there is none of that name. */
double plot_number_of(const cJSON *record, const char *name);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What pictures take from a daemon: whole streams of a job, and what its record says. */
#ifndef SCREE_CLIENT_PLOT_READ_H
#define SCREE_CLIENT_PLOT_READ_H

#include "reader.h"

/* Hands all chunks that a stream has by the job's record of `show` to `take`; none where there is no such stream. */
enum outcome plot_read_stream(struct link *link, const cJSON *record, const char *stream,
                              void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err);

/* The same of one of them, which may be a frame of some megabytes: no other is sent. */
enum outcome plot_read_chunk(struct link *link, const cJSON *record, const char *stream, uint64_t at,
                             void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err);

/* How many chunks a stream has, by the record of `show`; 0 where there is no such stream. */
uint64_t plot_chunks_of(const cJSON *record, const char *stream);

/* A number of the summary; NaN where there is none of that name. */
double plot_number_of(const cJSON *record, const char *name);

#endif

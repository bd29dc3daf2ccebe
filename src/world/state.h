/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world keeps beside its body. Private to this folder. */
#ifndef SCREE_WORLD_STATE_H
#define SCREE_WORLD_STATE_H

#include "measure/measure.h"
#include "scree.h"
#include "world/kind.h"

/* A measurement that this world takes. */
struct measured {
    const struct measurement *what;
    void *state;
    bool recorded;  // its streams are put
    uint64_t every; // steps between samples; 0: none are taken
    uint64_t due;   // step of the next one, while the world advances
};

enum { STREAMS_MAX = 2 * MEASUREMENTS_MAX };

struct scree_world {
    struct job_spec job;
    struct scree_sink sink;
    const struct world_kind *kind;
    void *body;
    struct world_making making;
    uint64_t step, end_step;
    bool closed;

    struct measured measured[MEASUREMENTS_MAX];
    size_t measured_count;
    struct measure_context context;
    const struct scree_stream *streams[STREAMS_MAX];
    size_t stream_count;
};

/* A world with its records and no body yet: what making and restoring one share. */
enum scree_status world_prepare(const struct job_spec *job, const struct scree_options *options, const struct scree_sink *sink,
                                struct scree_world **out, struct scree_error *err);

/* Steps between samples of a measurement as the job now says; 0: none are taken. */
uint64_t world_every(const struct measurement *what, const struct job_spec *job);

/* What the job says, and what the body holds, as of now. */
void world_look(struct scree_world *world);

/* Contacts that the body has reported go to who asked for them. */
enum scree_status world_hand_over(struct scree_world *world, struct scree_error *err);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world keeps beside its grains. Private to this folder. */
#ifndef SCREE_WORLD_STATE_H
#define SCREE_WORLD_STATE_H

#include "dem/dem.h"
#include "measure/bulk.h"
#include "measure/contact.h"
#include "measure/mobility.h"
#include "measure/series.h"
#include "measure/verdict.h"
#include "measure/window.h"
#include "scenario/scenario.h"
#include "scree.h"

/* Something taken every so many steps. */
struct schedule {
    bool on;
    uint64_t every; // steps, at least 1
};

enum { STREAMS_MAX = 8 };

struct scree_world {
    struct job_spec job;
    struct scree_sink sink;
    const struct scenario *scenario;
    struct dem *dem;
    int threads;
    uint64_t step, end_step;
    bool stopped, closed;

    struct schedule force, bulk, energy, snapshots, contact, flow;
    struct series force_series, bulk_series, energy_series, contact_series, flow_series;
    uint64_t snapshot_seq;
    const struct scree_stream *streams[STREAMS_MAX];
    size_t stream_count;

    double base_z, area; // of the scenario's base, m, m2
    struct bulk last;    // the newest sample
    double start_energy; // J
    struct verdict verdict;
    struct window force_window; // force on the base, weighted by steps
    struct window bulk_window;  // what bulk samples say, each of weight 1
    struct contact_trace trace;
    double (*release)[4]; // where bodies started, for flows that come to rest; else NULL
    struct mobility_site site;
};

/* Values of bulk_window. */
enum { BULK_MEAN_HEIGHT, BULK_MEAN_VX, BULK_MEAN_SPEED, BULK_MEAN_CONTACTS, BULK_MEAN_KINETIC };

/* A world with its records and no grains yet: what making and restoring one share. */
enum scree_status world_prepare(const struct job_spec *job, const struct scree_options *options, const struct scree_sink *sink,
                                struct scree_world **out, struct scree_error *err);

/* flow.c: records of flows that are let go; nothing for others. */
enum scree_status flow_start(struct scree_world *world, struct scree_error *err);
void flow_end(struct scree_world *world);
enum scree_status flow_take(struct scree_world *world, const struct view *view, struct scree_error *err);
enum scree_status flow_close(struct scree_world *world, const struct view *view, struct scree_error *err);
size_t flow_numbers(const struct scree_world *world, struct scree_number *out);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A measurement: one file, one const descriptor, one line in registry.c.
 *
 * A world keeps a state for each measurement it takes, calls its hooks when they
 * are due, and saves and restores it with everything else, all from what the
 * descriptor says. A state is a struct whose first `plain` bytes are plain data;
 * then come a `struct series` for each stream and, if it needs them, buffers of
 * numbers. All of it starts zeroed. Measurements see views and the engine's
 * reports, never an engine. */
#ifndef SCREE_MEASURE_MEASURE_H
#define SCREE_MEASURE_MEASURE_H

#include "continuum_view.h"
#include "measure/bulk.h"
#include "measure/mobility.h"
#include "measure/series.h"
#include "measure/verdict.h"
#include "scree.h"
#include "view.h"

/* Where a world is measured; the scenario says it. */
struct measure_site {
    double base_z, area; // height of the base's nominal top, basal area; area 0: there is no base, m, m2
    double diameter;     // of a grain, m
    double density;      // of its material, kg/m3
    double area_z;       // area that sums along z are per: the whole base, or its part within `region`; 0: nothing flows on it, m2
    double region[2];    // y of what is measured, m: [from, to); all of it, but verdicts and the ledger of energy
    size_t layers;       // grains over each point of the base: profiles reach four times as high
    struct mobility_site fall;  // of flows that are let go and come to rest; count 0 for others
    double bed, gate_x, gate_s; // of a collapse: depth of its bed, where its gate stands, when that begins to lift, m, m, s
    double height;              // of its column over the bed, m; 0: there is no column
    bool gate;                  // is there one?
    double length_x, width_y;   // of a box in which bodies pile up; 0: there is none, m
    double ledge_z;             // height of a hopper's bottom over the middle of it; 0: there is none, m
    double calm;                // see verdict.h; 0: VERDICT_CALM
};

/* What measurements of one world share; the world keeps it. */
struct measure_context {
    const struct job_spec *job; // as it now stands
    const struct scree_sink *sink;
    struct measure_site site;
    double gravity[3]; // m/s2, as it now stands
    uint64_t step;     // steps done
    double time_s;
    size_t moving, fixed; // grains
    struct verdict verdict;
    struct bulk last;    // the newest sums over grains: of this sample's view, if it has one
    struct bulk here;    // the same over those within the site's region
    double start_energy; // of the grains at t = 0, kinetic and elastic, J
    bool stop;           // a measurement has seen the end
};

/* What is seen at one sample: one of the views is set where the measurement asked for one. */
struct measure_now {
    const struct view *grains;
    const struct continuum_view *points;
    uint64_t every;       // steps since the last sample
    double base_force[3]; // mean over those steps, for those who asked, N
};

/* Numbers that grow or whose count the job decides. */
struct measure_buffer {
    double *values;
    size_t count, room, most; // elements; `most` is their maximum, set by start
};

enum measure_needs {
    MEASURE_VIEW = 1 << 0,       // of grains or points
    MEASURE_BASE_FORCE = 1 << 1, // all that need it are due together
    MEASURE_FORMATIONS = 1 << 2, // contacts that form, through `formed`
    MEASURE_END_VIEW = 1 << 3,   // a view for its numbers
};

struct measurement {
    const char *name;        // key under `record`; NULL: nobody chooses it, and without an interval it is taken once, at the end
    enum scenario_kind kind; // of worlds it can see
    unsigned needs;          // bits of enum measure_needs
    const char *every_of;    // whose interval it shares; NULL: its own
    double interval_s;       // between samples where the job has no say, else 0
    size_t size, plain;      // of the state, and of its plain part, bytes
    size_t series;           // offset of its series, as many as streams
    const struct scree_stream *const *streams;
    size_t stream_count;
    size_t buffers, buffer_count; // offset of its buffers

    /* Taken even where it is not recorded, since others rest on it; its streams are not started then. NULL: never.
     * Of a measurement without name: whether it is taken at all; NULL: always. */
    bool (*wanted)(const struct measure_context *context);
    /* Series' capacity is `chunk(context)` rows; 0: chunks are frames. NULL: MEASURE_CHUNK. */
    size_t (*chunk)(const struct measure_context *context);
    /* Sets buffers' `most` and whatever else follows from the job; called before restoring, too. */
    enum scree_status (*start)(void *state, const struct measure_context *context, struct scree_error *err);
    /* The state at t = 0. */
    enum scree_status (*first)(void *state, struct measure_context *context, const struct measure_now *now,
                               struct scree_error *err);
    /* One sample. */
    enum scree_status (*sample)(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err);
    /* Contacts that formed, in the order of steps; whenever the engine hands some over, which never shows. */
    enum scree_status (*formed)(void *state, struct measure_context *context, const struct view_formation *formations, size_t count,
                                struct scree_error *err);
    /* The end, before series are flushed. `now` has a view. */
    enum scree_status (*close)(void *state, struct measure_context *context, const struct measure_now *now,
                               struct scree_error *err);
    /* Forces have changed under a running world. */
    void (*steered)(void *state, const struct measure_context *context);
    /* Numbers for the summary; returns how many, at most `room`. */
    size_t (*numbers)(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room);
    /* Bytes of the plain part that are in use, where its end need not be stored. NULL: all. */
    size_t (*used)(const void *state);
    /* Whether a restored state is one that can be: images come from outside. NULL: any is. */
    bool (*sound)(const void *state, const struct measure_context *context);
};

enum { MEASURE_CHUNK = 128, MEASUREMENTS_MAX = 24 };
extern const struct measurement *const measurement_list[];
extern const size_t measurement_count;

/* The i-th series of a state, and buffers. */
static inline struct series *measure_series(const struct measurement *m, void *state)
{
    return (struct series *)(void *)((char *)state + m->series);
}
static inline struct measure_buffer *measure_buffers(const struct measurement *m, void *state)
{
    return (struct measure_buffer *)(void *)((char *)state + m->buffers);
}

/* Room for `need` numbers in all; SCREE_NO_MEMORY beyond the buffer's maximum. New ones are zero. */
enum scree_status measure_buffer_resize(struct measure_buffer *buffer, size_t need, struct scree_error *err);

/* `bytes` bytes that last until the next call and that no image holds. NULL: there is no memory. */
void *measure_scratch(struct measure_buffer *buffer, size_t bytes, struct scree_error *err);

/* Copies `count` numbers to `out` while there is room; for `numbers`. */
size_t measure_numbers(struct scree_number *out, size_t room, const struct scree_number *numbers, size_t count);

/* From when the summary's means are taken: t_0 where the flow was found steady, else the last half. */
double measure_window_from(const struct measure_context *context);

#endif

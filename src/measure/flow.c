/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Flows that are let go and come to rest: samples on the way, the deposit at the
 * end, what it amounts to (mobility.h). Where bodies started follows from the job,
 * so that images need not hold it. */
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/measure.h"

enum { FLOW_CHUNK = 16 };

static const struct scree_column flow_columns[FLOW_COLUMNS] = {
    {"time", "s"},
    {"place", "m"},
    {"bodies", "1"},
    {"variance_across", "m2/s2"},
    {"speed", "m/s"},
    {"kinetic_translation", "J/kg"},
    {"kinetic_rotation", "J/kg"},
    {"potential", "J/kg"},
    {"dissipated", "J/kg"},
};
static const struct scree_stream flow_stream = {
    "flow",
    "central 5 cm of the flow: place along the chute, variance of velocities across it, energies, energy lost since the release",
    flow_columns, FLOW_COLUMNS, false};

static const struct scree_column fragment_columns[FRAGMENT_COLUMNS] = {
    {"id", "1"}, {"shape", "1"}, {"in_flow", "1"}, {"mass", "kg"}, {"x", "m"},    {"y", "m"},    {"z", "m"},       {"qw", "1"},
    {"qx", "1"}, {"qy", "1"},    {"qz", "1"},      {"vx", "m/s"},  {"vy", "m/s"}, {"vz", "m/s"}, {"members", "1"}, {"volume", "m3"},
};
static const struct scree_stream fragments_stream = {"fragments", "every body at the end", fragment_columns, FRAGMENT_COLUMNS,
                                                     true};

static size_t flow_chunk(const struct measure_context *context)
{
    (void)context;
    return FLOW_CHUNK;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    double row[FLOW_COLUMNS];
    enum scree_status status = flow_measure(now->grains, &context->site.fall, row, err);
    return status ? status : series_add(state, context->sink, context->time_s, row, err);
}

static const struct scree_stream *const flow_streams[] = {&flow_stream};
const struct measurement measure_flow = {
    .name = "flow",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct series),
    .streams = flow_streams,
    .stream_count = 1,
    .chunk = flow_chunk,
    .sample = sample,
};

/* ---- the deposit ---- */

static bool wanted(const struct measure_context *context)
{
    return context->site.fall.count > 0;
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    const struct view *view = now->grains;
    double(*rows)[FRAGMENT_COLUMNS] = memory_rows(view->bodies, sizeof *rows);
    uint8_t *in_flow = memory_rows(view->bodies, 1);
    struct mobility deposit;
    enum scree_status status = SCREE_OK;
    if (!rows || !in_flow)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu bodies", view->bodies);
    if (!status && !(status = mobility_measure(view, &context->site.fall, &deposit, in_flow, err))) {
        for (size_t k = 0; k < view->bodies; k++)
            fragment_row(&view->body[k], in_flow[k], rows[view->body[k].id]);
        status = series_put_frame(state, context->sink, view->time_s, rows[0], view->bodies, err);
    }
    free(rows);
    free(in_flow);
    return status;
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    struct mobility d;
    (void)state;
    if (!now->grains || mobility_measure(now->grains, &context->site.fall, &d, NULL, NULL))
        return 0;
    const struct scree_number all[] = {
        {"mobility", "1", "mu_A: drop over way of the centre of mass of the flow proper, from all at release", d.mobility},
        {"mobility_upper", "1", "upper end of its uncertainty: the deposit's front taken 3 cm less far", d.upper},
        {"mobility_lower", "1", "lower end of its uncertainty: all bodies", d.lower},
        {"mobility_trimmed", "1", "mu_A with the flow proper's own bodies at release", d.trimmed},
        {"beta", "mm2/cm2", "scaling parameter: size and cube root of volume in mm over the width in cm squared", d.beta},
        {"bodies", "1", "all that were let go", (double)d.bodies},
        {"in_flow", "1", "bodies of the flow proper: the largest set that touch one another", (double)d.in_flow},
        {"flow_mass", "kg", "of the flow proper", d.mass},
        {"flow_volume", "m3", "of the flow proper", d.volume},
        {"front", "m", "of the flow proper along the chute", d.front},
        {"rear", "m", "of the flow proper along the chute", d.rear},
        {"cube_height_rank", "1", "mean rank of the largest bodies above the floor, 0..1; 0.5: no segregation", d.cube_height},
        {"cube_front_rank", "1", "mean rank of the largest bodies along the chute, 0..1", d.cube_front},
        {"largest_overlap", "1", "of any contact at the end, in grain sizes", d.overlap},
        {"kinetic_energy", "J", "at the end", context->last.kinetic},
        {"speed_rms", "m/s", "at the end", context->last.speed_rms},
    };
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
}

static const struct scree_stream *const fragments_streams[] = {&fragments_stream};
const struct measurement measure_fragments = {
    .kind = SCENARIO_DEM,
    .needs = MEASURE_END_VIEW,
    .size = sizeof(struct series),
    .streams = fragments_streams,
    .stream_count = 1,
    .wanted = wanted,
    .close = close,
    .numbers = numbers,
};

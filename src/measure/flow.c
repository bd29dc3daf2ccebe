/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Flows that are let go and come to rest: samples on the way, the deposit at the
 * end, what it amounts to (mobility.h). Where bodies started follows from the job,
 * so that images need not hold it. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/measure.h"
#include "measure/outline.h"

enum { FLOW_CHUNK = 4 }; // samples: a flow has some twenty

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
    {"overlap_mean", "1"},
    {"overlap_largest", "1"},
    {"still_rear", "m"},
    {"still_front", "m"},
};
static const struct scree_stream flow_stream = {
    "flow",
    "central 5 cm of the flow: place along the chute, variance of velocities across it, energies, energy lost since the release; "
    "overlaps of all contacts, in grain sizes; where bodies lie still",
    flow_columns, FLOW_COLUMNS, false};

static const struct scree_column layer_columns[LAYER_COLUMNS] = {
    {"height", "m"}, {"bodies", "1"}, {"speed", "m/s"}, {"variance_across", "m2/s2"}, {"largest", "1"},
};
static const struct scree_stream layers_stream = {
    "layers",
    "central 5 cm of the flow by height over the floor, in layers a grain size thick: speed along the slope, variance of "
    "velocities across it, share of the largest bodies",
    layer_columns, LAYER_COLUMNS, true};

static const struct scree_column outline_columns[OUTLINE_COLUMNS] = {
    {"along", "m"}, {"bodies", "1"}, {"mass", "kg"}, {"top", "m"}, {"left", "m"}, {"right", "m"}, {"largest", "1"},
};
static const struct scree_stream outline_stream = {
    "outline",
    "the deposit of the flow proper at the end, by centimetre along the chute: height of its top over the floor, its sides",
    outline_columns, OUTLINE_COLUMNS, true};

static const struct scree_column fragment_columns[FRAGMENT_COLUMNS] = {
    {"id", "1"}, {"shape", "1"}, {"in_flow", "1"}, {"mass", "kg"}, {"x", "m"},    {"y", "m"},    {"z", "m"},       {"qw", "1"},
    {"qx", "1"}, {"qy", "1"},    {"qz", "1"},      {"vx", "m/s"},  {"vy", "m/s"}, {"vz", "m/s"}, {"members", "1"}, {"volume", "m3"},
};
static const struct scree_stream fragments_stream = {"fragments", "every body at the end", fragment_columns, FRAGMENT_COLUMNS,
                                                     true};

enum { WALL_COLUMNS = 10 };
static const struct scree_column wall_columns[WALL_COLUMNS] = {
    {"x0", "m"}, {"y0", "m"}, {"z0", "m"}, {"x1", "m"}, {"y1", "m"},
    {"z1", "m"}, {"x2", "m"}, {"y2", "m"}, {"z2", "m"}, {"accelerator", "1"},
};
static const struct scree_stream walls_stream = {"walls", "triangles of accelerator and chute, at the start", wall_columns,
                                                 WALL_COLUMNS, true};

/* What is summed up on the way. */
enum { FLOW, LAYERS, WALLS, FLOW_STREAMS };
struct flow_state {
    double agitation; // integral of the variance across, m2/s
    double overlap;   // the largest, in grain sizes
    struct series series[FLOW_STREAMS];
};

/* Of rows; frames are put whole all the same. */
static size_t flow_chunk(const struct measure_context *context)
{
    (void)context;
    return FLOW_CHUNK;
}

static enum scree_status first(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct flow_state *s = state;
    const struct trimesh *mesh = now->grains->base_mesh;
    double(*rows)[WALL_COLUMNS] = memory_rows(mesh->triangles, sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu triangles", mesh->triangles);
    for (size_t t = 0; t < mesh->triangles; t++) {
        for (int c = 0; c < 3; c++)
            memcpy(&rows[t][3 * c], mesh->vertex[mesh->corner[t][c]], 3 * sizeof(double));
        rows[t][WALL_COLUMNS - 1] = chute_upslope(mesh, t);
    }
    enum scree_status status =
        series_put_frame(&s->series[WALLS], context->sink, now->grains->time_s, rows[0], mesh->triangles, err);
    free(rows);
    return status;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct flow_state *s = state;
    double row[FLOW_COLUMNS], layers[LAYERS_MAX][LAYER_COLUMNS];
    enum scree_status status = flow_measure(now->grains, &context->site.fall, row, err);
    if (status)
        return status;
    s->agitation += row[FLOW_VARIANCE] * (double)now->every * now->grains->step_s;
    s->overlap = row[FLOW_OVERLAP] > s->overlap ? row[FLOW_OVERLAP] : s->overlap;
    if ((status = series_add(&s->series[FLOW], context->sink, context->time_s, row, err)))
        return status;
    size_t count = outline_layers(now->grains, &context->site.fall, row[FLOW_PLACE], layers);
    return series_put_frame(&s->series[LAYERS], context->sink, now->grains->time_s, layers[0], count, err);
}

static size_t flow_numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                           struct scree_number *out, size_t room)
{
    const struct flow_state *s = state;
    (void)context, (void)now;
    const struct scree_number all[] = {
        {"agitation", "m2/s", "variance of velocities across the central 5 cm, summed up over time", s->agitation},
        {"overlap_reached", "1", "largest of any contact at any sample of the flow, in grain sizes", s->overlap},
    };
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
}

static const struct scree_stream *const flow_streams[FLOW_STREAMS] = {&flow_stream, &layers_stream, &walls_stream};
const struct measurement measure_flow = {
    .name = "flow",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct flow_state),
    .plain = offsetof(struct flow_state, series),
    .series = offsetof(struct flow_state, series),
    .streams = flow_streams,
    .stream_count = FLOW_STREAMS,
    .chunk = flow_chunk,
    .first = first,
    .sample = sample,
    .numbers = flow_numbers,
};

/* ---- the deposit ---- */

enum { FRAGMENTS, OUTLINE, DEPOSIT_STREAMS };

static bool wanted(const struct measure_context *context)
{
    return context->site.fall.count > 0;
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    const struct view *view = now->grains;
    struct series *series = state;
    double(*outline)[OUTLINE_COLUMNS] = NULL;
    size_t slices;
    double(*rows)[FRAGMENT_COLUMNS] = memory_rows(view->bodies, sizeof *rows);
    uint8_t *in_flow = memory_rows(view->bodies, 1);
    struct mobility deposit;
    enum scree_status status = SCREE_OK;
    if (!rows || !in_flow)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu bodies", view->bodies);
    if (!status && !(status = mobility_measure(view, &context->site.fall, &deposit, in_flow, err))) {
        for (size_t k = 0; k < view->bodies; k++)
            fragment_row(&view->body[k], in_flow[k], rows[view->body[k].id]);
        status = series_put_frame(&series[FRAGMENTS], context->sink, view->time_s, rows[0], view->bodies, err);
        if (!status && !(status = outline_deposit(view, &context->site.fall, in_flow, &outline, &slices, err)))
            status = series_put_frame(&series[OUTLINE], context->sink, view->time_s, outline[0], slices, err);
    }
    free(outline);
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

static const struct scree_stream *const fragments_streams[DEPOSIT_STREAMS] = {&fragments_stream, &outline_stream};
const struct measurement measure_fragments = {
    .kind = SCENARIO_DEM,
    .needs = MEASURE_END_VIEW,
    .size = DEPOSIT_STREAMS * sizeof(struct series),
    .streams = fragments_streams,
    .stream_count = DEPOSIT_STREAMS,
    .wanted = wanted,
    .close = close,
    .numbers = numbers,
};

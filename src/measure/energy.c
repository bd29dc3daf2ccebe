/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The ledger of energy: what gravity did, what moves, what springs hold, what was lost. */
#include <stddef.h>

#include "measure/measure.h"

static const struct scree_column columns[ENERGY_COLUMNS] = {
    {"time", "s"},
    {"gravity_work", "J"},
    {"kinetic_translation", "J"},
    {"kinetic_rotation", "J"},
    {"elastic", "J"},
    {"dissipated_normal", "J"},
    {"dissipated_tangential", "J"},
    {"dissipated_torsion", "J"},
    {"dissipated_rolling", "J"},
    {"residual", "J"},
};
static const struct scree_stream stream = {"energy", "ledger: work of gravity = kinetic + elastic + dissipated + residual", columns,
                                           ENERGY_COLUMNS, false};
static const struct scree_stream *const streams[] = {&stream};

void energy_row(const struct view *view, const struct bulk *b, double start, double row[ENERGY_COLUMNS])
{
    double dissipated = view->dissipated_normal + view->dissipated_tangential + view->dissipated_torsion + view->dissipated_rolling;
    const double values[ENERGY_COLUMNS] = {view->time_s,
                                           view->gravity_work,
                                           b->kinetic - b->rotation,
                                           b->rotation,
                                           b->elastic,
                                           view->dissipated_normal,
                                           view->dissipated_tangential,
                                           view->dissipated_torsion,
                                           view->dissipated_rolling,
                                           view->gravity_work + start - b->kinetic - b->elastic - dissipated};
    for (int k = 0; k < ENERGY_COLUMNS; k++)
        row[k] = values[k];
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    double row[ENERGY_COLUMNS];
    energy_row(now->grains, &context->last, context->start_energy, row);
    return series_add(state, context->sink, context->time_s, row, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    double row[ENERGY_COLUMNS], lost = 0;
    (void)state;
    if (!now->grains)
        return 0;
    energy_row(now->grains, &context->last, context->start_energy, row);
    for (int k = ENERGY_LOST; k < ENERGY_RESIDUAL; k++)
        lost += row[k];
    const struct scree_number all[] = {
        {"energy_lost", "J", "by damping, sliding, torsion and rolling together", lost},
        {"energy_residual", "1", "what the ledger cannot say where it went, over what was lost", row[ENERGY_RESIDUAL] / lost},
    };
    return lost > 0 ? measure_numbers(out, room, all, sizeof all / sizeof *all) : 0;
}

const struct measurement measure_energy = {
    .name = "energy",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW | MEASURE_END_VIEW,
    .size = sizeof(struct series),
    .streams = streams,
    .stream_count = 1,
    .sample = sample,
    .numbers = numbers,
};

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every measurement, in the order in which those that are due at once are taken;
 * one line each. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/measure.h"

extern const struct measurement measure_basal_force, measure_bulk, measure_energy, measure_spectrum, measure_profiles,
    measure_connectivity, measure_collisions, measure_forces, measure_contact, measure_flow, measure_fragments, measure_snapshots,
    measure_grains, measure_basal_force_continuum, measure_deposit, measure_point_snapshots, measure_points, measure_pile,
    measure_rolling, measure_surface, measure_heap, measure_views, measure_repose, measure_verdict;

const struct measurement *const measurement_list[] = {
    &measure_basal_force,
    &measure_bulk,
    &measure_verdict,
    &measure_energy,
    &measure_spectrum,
    &measure_profiles,
    &measure_connectivity,
    &measure_collisions,
    &measure_forces,
    &measure_contact,
    &measure_flow,
    &measure_fragments,
    &measure_snapshots,
    &measure_grains,
    &measure_basal_force_continuum,
    &measure_deposit,
    &measure_point_snapshots,
    &measure_points,
    &measure_pile,
    &measure_rolling,
    &measure_surface,
    &measure_heap,
    &measure_views,
    &measure_repose,
};
const size_t measurement_count = sizeof measurement_list / sizeof *measurement_list;
_Static_assert(sizeof measurement_list / sizeof *measurement_list <= MEASUREMENTS_MAX, "worlds have room for all");

enum scree_status measure_buffer_resize(struct measure_buffer *buffer, size_t need, struct scree_error *err)
{
    if (need > buffer->most)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "a measurement would keep %zu numbers and may keep %zu", need, buffer->most);
    enum scree_status status = memory_grow((void **)&buffer->values, &buffer->room, need, sizeof *buffer->values, err);
    if (status)
        return status;
    if (need > buffer->count)
        memset(buffer->values + buffer->count, 0, (need - buffer->count) * sizeof *buffer->values);
    buffer->count = need;
    return SCREE_OK;
}

void *measure_scratch(struct measure_buffer *buffer, size_t bytes, struct scree_error *err)
{
    size_t need = (bytes + sizeof *buffer->values - 1) / sizeof *buffer->values;
    return memory_grow((void **)&buffer->values, &buffer->room, need, sizeof *buffer->values, err) ? NULL : buffer->values;
}

size_t measure_numbers(struct scree_number *out, size_t room, const struct scree_number *numbers, size_t count)
{
    size_t kept = count < room ? count : room;
    memcpy(out, numbers, kept * sizeof *out);
    return kept;
}

double measure_window_from(const struct measure_context *context)
{
    double t0 = context->verdict.t0_s, now = context->time_s;
    return t0 >= 0 && t0 < now ? t0 : 0.5 * now;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world keeps for flows that are let go and come to rest: where bodies
 * started, samples on the way, the deposit. Where they started follows from the
 * job, so that images need not hold it. */
#include <stdlib.h>

#include "base/memory.h"
#include "measure/mobility.h"
#include "world/state.h"

enum { FLOW_CHUNK = 16 };

enum scree_status flow_start(struct scree_world *w, struct scree_error *err)
{
    if (!w->scenario->release)
        return SCREE_OK;
    w->site.chute = w->scenario->chute(&w->job);
    w->site.grain_m = w->scenario->grain(&w->job);
    enum scree_status status = w->scenario->release(&w->job, &w->release, &w->site.count, err);
    if (status)
        return status;
    w->site.release = (const double(*)[4])w->release;
    w->streams[w->stream_count++] = &fragments_stream;
    if (!w->flow.on)
        return SCREE_OK;
    w->streams[w->stream_count++] = &flow_stream;
    return series_start(&w->flow_series, &flow_stream, FLOW_CHUNK, (double)w->flow.every * w->job.time.step_s, err);
}

void flow_end(struct scree_world *w)
{
    series_end(&w->flow_series);
    free(w->release);
}

enum scree_status flow_take(struct scree_world *w, const struct view *view, struct scree_error *err)
{
    double row[FLOW_COLUMNS];
    enum scree_status status = flow_measure(view, &w->site, row, err);
    return status ? status : series_add(&w->flow_series, &w->sink, view->time_s, row, err);
}

enum scree_status flow_close(struct scree_world *w, const struct view *view, struct scree_error *err)
{
    if (!w->release)
        return SCREE_OK;
    enum scree_status status = w->flow.on ? series_flush(&w->flow_series, &w->sink, err) : SCREE_OK;
    double(*rows)[FRAGMENT_COLUMNS] = memory_rows(view->bodies, sizeof *rows);
    uint8_t *in_flow = memory_rows(view->bodies, 1);
    if (!status && (!rows || !in_flow))
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu bodies", view->bodies);
    struct mobility deposit;
    if (!status && !(status = mobility_measure(view, &w->site, &deposit, in_flow, err))) {
        for (size_t k = 0; k < view->bodies; k++)
            fragment_row(&view->body[k], in_flow[k], rows[view->body[k].id]);
        const struct scree_chunk chunk = {
            .stream = &fragments_stream, .t0_s = view->time_s, .rows = view->bodies, .values = rows[0]};
        status = w->sink.put(w->sink.context, &chunk, err);
    }
    free(rows);
    free(in_flow);
    return status;
}

size_t flow_numbers(const struct scree_world *w, struct scree_number *out)
{
    struct view view;
    struct mobility d;
    if (!w->release || dem_view(w->dem, &view, NULL) || mobility_measure(&view, &w->site, &d, NULL, NULL))
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
        {"kinetic_energy", "J", "at the end", w->last.kinetic},
        {"speed_rms", "m/s", "at the end", w->last.speed_rms},
    };
    size_t count = sizeof all / sizeof *all;
    for (size_t k = 0; k < count; k++)
        out[k] = all[k];
    return count;
}

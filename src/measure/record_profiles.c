/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Profiles of a flow over its base: sampled at intervals, put as a frame every
 * frame_s and, at the end, as the means over the summary's window. Sums alone are
 * kept, so that frames may be added up again by their weights. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/connect.h"
#include "measure/history.h"
#include "measure/models.h"
#include "measure/profiles.h"

static const struct scree_column columns[PROFILE_COLUMNS] = {
    {"z", "m"},     {"phi", "1"},        {"ux", "m/s"},    {"uy", "m/s"},    {"uz", "m/s"},
    {"T", "m2/s2"}, {"n_I", "1/(m3 s)"}, {"dn2", "m2/s2"}, {"dt2", "m2/s2"}, {"P_C", "1"},
};
#define DOC                                                                                                                        \
    "by height: solid fraction, velocity, granular temperature (shear included), impacts, their mean squared normal and "          \
    "tangential speeds, share joined to the base"
static const struct scree_stream frames = {"profiles", DOC, columns, PROFILE_COLUMNS, true};
static const struct scree_stream means = {"profiles_mean", DOC "; means over the summary's window", columns, PROFILE_COLUMNS, true};
static const struct scree_stream *const streams[] = {&frames, &means};

enum { SUMS, KEPT, FRAME, ROOTS, BUFFERS }; // running sums and instants, sums at the last frame, scratch

struct state {
    struct history history;
    uint64_t samples; // since the last frame
    struct series series[2];
    struct measure_buffer buffers[BUFFERS];
};

static struct coarse_grid grid_of(const struct measure_context *c)
{
    return coarse_grid_of(c->site.base_z, c->site.diameter, c->site.area_z, c->site.layers);
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    struct state *s = state;
    struct coarse_grid grid = grid_of(context);
    size_t width = profiles_width(&grid);
    if (context->site.area_z <= 0 || context->site.layers == 0)
        return scree_fail(err, SCREE_INVALID, "record.profiles",
                          "record.profiles: this scenario has no base to take profiles over");
    s->buffers[FRAME].most = width;
    enum scree_status status = history_start(&s->history, s->buffers, width, err);
    return status ? status : measure_buffer_resize(&s->buffers[FRAME], width, err);
}

static enum scree_status formed(void *state, struct measure_context *context, const struct view_formation *formations, size_t count,
                                struct scree_error *err)
{
    struct state *s = state;
    struct coarse_grid grid = grid_of(context);
    (void)err;
    profiles_add_formations(&grid, context->site.region, formations, count, history_sums(s->buffers));
    return SCREE_OK;
}

static enum scree_status put(struct series *series, const struct measure_context *context, const double *sums,
                             struct scree_error *err)
{
    struct coarse_grid grid = grid_of(context);
    struct profile *profile = NULL;
    size_t room = 0;
    _Static_assert(sizeof *profile == PROFILE_COLUMNS * sizeof(double), "a profile is a row");
    enum scree_status status = memory_grow((void **)&profile, &room, grid.count, sizeof *profile, err);
    if (!status) {
        profiles_of(&grid, sums, profile);
        status = series_put_frame(series, context->sink, context->time_s, (const double *)profile, grid.count, err);
    }
    free(profile);
    return status;
}

/* A frame of what was added since the last one. */
static enum scree_status put_frame(struct state *s, const struct measure_context *context, struct scree_error *err)
{
    double *last = s->buffers[FRAME].values;
    const double *sums = history_sums(s->buffers);
    for (size_t k = 0; k < s->history.width; k++)
        last[k] = sums[k] - last[k];
    enum scree_status status = put(&s->series[0], context, last, err);
    memcpy(last, sums, s->history.width * sizeof *last);
    s->samples = 0;
    return status ? status : history_keep(&s->history, s->buffers, context->time_s, err);
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    struct coarse_grid grid = grid_of(context);
    const struct record_profiles *record = &context->job->record.profiles;
    uint32_t *root = measure_scratch(&s->buffers[ROOTS], connect_rows(now->grains) * sizeof *root, err);
    if (!root)
        return SCREE_NO_MEMORY;
    double *sums = history_sums(s->buffers);
    connect_base(now->grains, CONNECT_OVERLAP, root);
    profiles_add_view(&grid, context->site.region, now->grains, root, sums);
    sums[PROFILES_TIME] += (double)now->every * now->grains->step_s;
    bool whole = (double)++s->samples >= round(record->frame_s / record->every_s);
    return whole ? put_frame(s, context, err) : SCREE_OK;
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct state *s = state;
    double *sums = NULL;
    size_t room = 0;
    (void)now;
    enum scree_status status = memory_grow((void **)&sums, &room, s->history.width, sizeof *sums, err);
    if (!status) {
        history_since(&s->history, s->buffers, measure_window_from(context), sums);
        status = put(&s->series[1], context, sums, err);
    }
    free(sums);
    return status;
}

/* ---- what they amount to ---- */

static size_t write_numbers(const struct measure_context *c, const struct coarse_grid *grid, const struct profile *profile,
                            struct scree_number *out, size_t room)
{
    struct profile_bulk b;
    struct model_power model;
    profiles_bulk(grid, profile, c->site.base_z, c->site.density, -c->gravity[2], &b);
    models_power(grid, profile, &b, c->site.base_z, c->site.density, &model);
    const struct scree_number all[] = {
        {"depth", "m", "twice the height of the centre of mass of the profile of phi over the base", b.h1},
        {"depth_half", "m", "height over the base where phi falls to half its value at mid-depth", b.h2},
        {"mean_fraction", "1", "phi over the depth", b.fraction},
        {"mean_downslope", "m/s", "u_x over the depth", b.velocity},
        {"mean_temperature", "m2/s2", "T over the depth, shear within the kernel included", b.temperature},
        {"base_pressure", "Pa", "weight of the flow over the basal area", b.pressure},
        {"inertial_depth", "1", "inertial number of the depth means, from a Bagnold profile", b.inertial},
        {"inertial_local", "1", "u' d sqrt(rho / p) at mid-depth", b.local},
        {"shear_temperature", "1", "g_T: sqrt(T) over |u'| d, least squares over the depth", b.shear},
        {"model_minimal", "N2/Hz", "P_F^0 predicted: impacts that chains of contacts pass on (this project's formulation)",
         model.minimal},
        {"model_thin", "N2/Hz",
         "P_F^0 predicted: grains that hit the base's bumps at the flow's mean speed (this project's formulation)", model.thin},
        {"model_thick", "N2/Hz",
         "P_F^0 predicted: a basal layer that hits the base's bumps at its own speed (this project's formulation)", model.thick},
        {"model_attenuated", "N2/Hz",
         "P_F^0 predicted: impacts through the depth, attenuated on the way (this project's formulation)", model.attenuated},
        {"model_pressure", "N2/m2",
         "area times pressure squared: a stress-driven P_F^0 is proportional to it, with a free constant", model.pressure},
    };
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    struct coarse_grid grid = grid_of(context);
    double *sums = memory_rows(s->history.width, sizeof *sums);
    struct profile *profile = memory_rows(grid.count, sizeof *profile);
    size_t count = 0;
    (void)now;
    if (sums && profile) {
        history_since(&s->history, s->buffers, measure_window_from(context), sums);
        profiles_of(&grid, sums, profile);
        count = sums[PROFILES_SAMPLES] > 0 ? write_numbers(context, &grid, profile, out, room) : 0;
    }
    free(sums);
    free(profile);
    return count;
}

static bool sound(const void *state, const struct measure_context *context)
{
    const struct state *s = state;
    struct coarse_grid grid = grid_of(context);
    return history_sound(&s->history, s->buffers, profiles_width(&grid)) && s->buffers[FRAME].count == s->history.width;
}

const struct measurement measure_profiles = {
    .name = "profiles",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW | MEASURE_FORMATIONS,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 2,
    .buffers = offsetof(struct state, buffers),
    .buffer_count = BUFFERS,
    .start = start,
    .sample = sample,
    .formed = formed,
    .close = close,
    .numbers = numbers,
    .sound = sound,
};

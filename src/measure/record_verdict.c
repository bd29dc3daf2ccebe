/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Samples for the verdict (verdict.h) and the watch for steps that are too long: at an
 * interval of their own, so that neither depends on what a job records, and how often. */
#include <math.h>

#include "base/vec3.h"
#include "measure/measure.h"

#define INTERVAL 1e-3 // s, a fourteenth of sqrt(d / g) for d = 2 mm

static bool wanted(const struct measure_context *context)
{
    return context->site.area > 0 || context->job->record.bulk.on;
}

/* Energy that nothing supplied: the time step no longer follows the contacts. */
static enum scree_status look_for_explosion(const struct measure_context *context, const struct measure_now *now,
                                            struct scree_error *err)
{
    const struct view *view = now->grains;
    double energy = context->last.kinetic + context->last.elastic, supplied = fabs(view->gravity_work) + context->start_energy;
    if (isfinite(energy) && energy <= 10 * supplied + 1e-12)
        return SCREE_OK;
    size_t fastest = 0;
    double most = -1;
    for (size_t i = 0; i < view->moving; i++) {
        double speed2 = vec3_square(view->velocity[i]);
        if (!(speed2 <= most)) {
            most = speed2;
            fastest = i;
        }
    }
    scree_fail(
        err, SCREE_BLOWUP, NULL,
        "step %llu: the grains hold %.3g J and gravity and the start have supplied %.3g J; fastest is grain %u at %.3g m/s; last "
        "good time %.9g s",
        (unsigned long long)context->step, energy, supplied, view->id[fastest], sqrt(most),
        view->time_s - (double)now->every * view->step_s);
    scree_hint(err, "a shorter time.step_s may help");
    return SCREE_BLOWUP;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct verdict *verdict = &context->verdict;
    const struct bulk *all = &context->last;
    enum scree_status status = look_for_explosion(context, now, err);
    (void)state;
    if (status || context->site.area <= 0 || all->time_s < context->site.gate_s) // behind a gate rest is no verdict
        return status;
    verdict_add(verdict, all->time_s, all->kinetic, all->elastic, all->speed_rms, all->centre_z);
    if (verdict->current != VERDICT_UNDECIDED && (context->job->stop.when >> (verdict->current - 1) & 1))
        context->stop = true;
    return SCREE_OK;
}

const struct measurement measure_verdict = {
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .interval_s = INTERVAL,
    .size = 1, // the verdict is the world's
    .wanted = wanted,
    .sample = sample,
};

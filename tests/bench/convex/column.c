/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Not a test: settles a column of crosses (seed 001, Table I), steps it on from one
 * image on every instruction set, and prints cross-steps per second of processor
 * time; then nanoseconds a pair of boxes of that column for ours, FCL and libccd.
 *
 *     bench_convex [crosses [seconds to settle [steps to time [side of the box, m]]]] */
#include <stdio.h>
#include <stdlib.h>

#include "base/cpu.h"
#include "convex/image.h"
#include "pairs.h"
#include "scenario/rigid.h"
#include "spec/scenarios.h"

enum { ROUNDS = 5 };

static struct scree_error error = {.message = ""};

static int by_size(const void *x, const void *y)
{
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

/* Steps on from the image; prints the median of the rounds. */
static bool time_steps(const struct convex_image *image, struct convex_setup *setup, enum cpu_isa isa, uint64_t steps)
{
    double rate[ROUNDS];
    struct convex_counts before = {0}, after = {0};
    setup->isa = cpu_isa_name(isa);
    for (int k = 0; k < ROUNDS; k++) {
        struct convex *world = NULL;
        if (convex_load(image, setup, &world, &error))
            return false;
        before = convex_counts(world);
        double start = pairs_seconds();
        bool done = !convex_advance(world, steps, &error);
        rate[k] = (double)setup->body_count * (double)steps / (pairs_seconds() - start);
        after = convex_counts(world);
        convex_free(world);
        if (!done)
            return false;
    }
    qsort(rate, ROUNDS, sizeof *rate, by_size);
    double all = (double)setup->body_count * (double)steps;
    printf("%s: %.3g cross-steps a CPU second (%.3g to %.3g); a cross-step: %.2f distances, %.3f searched for; a list every %.0f "
           "steps; %.0f bytes a cross\n",
           setup->isa, rate[ROUNDS / 2], rate[0], rate[ROUNDS - 1], (double)(after.queries - before.queries) / all,
           (double)(after.searches - before.searches) / all,
           (double)steps / (double)(after.rebuilds > before.rebuilds ? after.rebuilds - before.rebuilds : 1),
           (double)after.bytes / (double)setup->body_count);
    return true;
}

static bool settle(const struct convex_setup *setup, double seconds, struct convex **world)
{
    if (convex_create(setup, world, &error) || convex_advance(*world, (uint64_t)(seconds / setup->step_s), &error))
        return false;
    struct convex_sums sums = convex_sums(*world);
    double crosses = (double)setup->body_count;
    printf("%zu crosses after %g s: mean speed %.3g m/s, %.2f touching pairs of boxes a cross, %.1f listed\n", setup->body_count,
           seconds, sums.speed_mean, 2 * (double)sums.contacts / crosses, (double)convex_counts(*world).pairs / crosses);
    return true;
}

int main(int argc, char **argv)
{
    size_t count = argc > 1 ? strtoul(argv[1], NULL, 10) : 300;
    double seconds = argc > 2 ? strtod(argv[2], NULL) : 0.4, side = argc > 4 ? strtod(argv[4], NULL) : 0.07;
    uint64_t steps = argc > 3 ? strtoul(argv[3], NULL, 10) : 2000;
    static struct job_spec job;
    struct rigid_plan plan = {.bodies = NULL};
    struct convex_image image = {.body = NULL};
    struct convex *world = NULL;
    job_defaults(&job, &scenario_settle_fields);
    struct settle_params *p = (struct settle_params *)(void *)job.params;
    p->count = (int64_t)count;
    p->length_m = p->width_m = side;
    int result = 1;
    if (rigid_scenario_find("settle")->plan(&job, &plan, &error) || !settle(&plan.setup, seconds, &world) ||
        convex_save(world, &image, &error))
        goto out;
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++)
        if (cpu_has(isa) && !time_steps(&image, &plan.setup, isa, steps))
            goto out;
    if (pairs_compare(world, &plan.shape, &error))
        goto out;
    result = 0;
out:
    if (result)
        fprintf(stderr, "%s\n", error.message[0] ? error.message : "no memory");
    convex_image_free(&image);
    convex_free(world);
    rigid_plan_free(&plan);
    return result;
}

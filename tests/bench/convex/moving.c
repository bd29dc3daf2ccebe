/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Not a test: bodies that fall, settle, and go where a gate or a hole lets them, and
 * what a step of it costs as it goes on. The last column tells whether two builds
 * did the same.
 *
 *     bench_moving hopper|beads|crosses [bodies [seconds to run [windows [instruction set]]]] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "convex/convex.h"
#include "scenario/rigid.h"
#include "spec/scenarios.h"

static struct scree_error error = {.message = ""};
static struct job_spec job;

/* Table II of seed 001, softened by 1000 (client/examples/repose.json). */
static void soft_beads(void)
{
    job.rigid.stiffness /= 1000;
    job.rigid.stiffness_t /= 1000;
    job.rigid.rate_t /= 32;
    job.time.step_s = 1.58e-5;
}

static const char *hopper(int64_t count)
{
    job_defaults(&job, &scenario_hopper_fields);
    struct hopper_params *p = (struct hopper_params *)(void *)job.params;
    p->count = count;
    p->side_m = 0.03;
    p->height_m = 0.05;
    p->settle_s = 0.15;
    soft_beads();
    return "hopper";
}

static void column(int64_t count, double column_m, double width_m)
{
    job_defaults(&job, &scenario_dam_break_fields);
    struct dam_break_params *p = (struct dam_break_params *)(void *)job.params;
    p->count = count;
    p->column_m = column_m;
    p->width_m = width_m;
    p->length_m = 1;
}

static const char *beads(int64_t count)
{
    column(count, 0.02, 0.02);
    struct dam_break_params *p = (struct dam_break_params *)(void *)job.params;
    p->settle_s = 0.2;
    p->body.shape = BODY_SPHERE;
    p->body.radius_m = 0.001;
    struct job_spec dam = job;
    job_defaults(&job, &scenario_hopper_fields); // whose preset the beads are
    dam.rigid = job.rigid;
    job = dam;
    soft_beads();
    return "dam_break";
}

static const char *crosses(int64_t count)
{
    column(count, 0.08, 0.06);
    struct dam_break_params *p = (struct dam_break_params *)(void *)job.params;
    p->settle_s = 0.6;
    job.rigid.stiffness /= 10;
    job.time.step_s = 8e-6;
    return "dam_break";
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "hopper", *scenario;
    int64_t count = argc > 2 ? strtol(argv[2], NULL, 10) : 1000;
    double seconds = argc > 3 ? strtod(argv[3], NULL) : 0.3;
    int windows = argc > 4 ? (int)strtol(argv[4], NULL, 10) : 6;
    scenario = strcmp(name, "beads") == 0 ? beads(count) : strcmp(name, "crosses") == 0 ? crosses(count) : hopper(count);
    struct rigid_plan plan = {.bodies = NULL};
    struct convex *world = NULL;
    int result = 1;
    if (rigid_scenario_find(scenario)->plan(&job, &plan, &error))
        goto out;
    plan.setup.isa = argc > 5 ? argv[5] : NULL;
    if (convex_create(&plan.setup, &world, &error))
        goto out;
    uint64_t steps = (uint64_t)(seconds / plan.setup.step_s / windows);
    double total = 0;
    for (int w = 0; w < windows; w++) {
        struct convex_counts before = convex_counts(world), after;
        clock_t start = clock();
        if (convex_advance(world, steps, &error))
            goto out;
        double spent = (double)(clock() - start) / CLOCKS_PER_SEC, all = (double)count * (double)steps;
        struct convex_sums sums = convex_sums(world);
        after = convex_counts(world);
        total += spent;
        printf("%.3f s: %.3g body-steps a CPU second; mean speed %.2g m/s, %.2f contacts a body, %.2f distances a body-step, %.4f "
               "searched for, a list every %.1f steps, %.1f pairs and %.0f bytes a body; %016llx\n",
               convex_time(world), all / spent, sums.speed_mean, (double)(sums.contacts + sums.contacts_wall) / (double)count,
               (double)(after.queries - before.queries) / all, (double)(after.searches - before.searches) / all,
               (double)steps / (double)(after.rebuilds - before.rebuilds), (double)after.pairs / (double)count,
               (double)after.bytes / (double)count, (unsigned long long)convex_hash(world));
    }
    printf("%s, %lld bodies: %.3g body-steps a CPU second\n", name, (long long)count,
           (double)count * (double)steps * windows / total);
    result = 0;
out:
    if (result)
        fprintf(stderr, "%s\n", error.message[0] ? error.message : "no memory");
    convex_free(world);
    rigid_plan_free(&plan);
    return result;
}

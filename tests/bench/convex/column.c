/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Not a test: settles a column of crosses (seed 001, Table I) and prints cross-steps per
 * second of processor time, with what they were spent on.
 *
 *     bench_convex [crosses [steps to settle [steps to time]]] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/rng.h"
#include "convex/convex.h"

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Layers of nine in a box of 12 x 12 cm, turned anyhow, too far apart to touch. */
static struct convex_body *column(size_t count)
{
    struct convex_body *bodies = calloc(count, sizeof *bodies);
    struct rng rng = rng_start(1, 1);
    for (size_t k = 0; bodies && k < count; k++) {
        struct quat q;
        do
            q = (struct quat){rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1),
                              rng_uniform(&rng, -1, 1)};
        while (!(quat_norm2(q) > 0.01));
        quat_store(bodies[k].orientation, quat_unit(q));
        const double at[3] = {0.02 + 0.04 * (double)(k % 3), 0.02 + 0.04 * (double)(k / 3 % 3), 0.02 + 0.03 * (double)(k / 9)};
        memcpy(bodies[k].position, at, sizeof at);
    }
    return bodies;
}

int main(int argc, char **argv)
{
    size_t count = argc > 1 ? strtoul(argv[1], NULL, 10) : 200;
    uint64_t settle = argc > 2 ? strtoul(argv[2], NULL, 10) : 200000, timed = argc > 3 ? strtoul(argv[3], NULL, 10) : 5000;
    static const struct convex_wall walls[] = {{{0, 0, 0}, {0, 0, 1}},
                                               {{0, 0, 0}, {1, 0, 0}},
                                               {{0, 0, 0}, {0, 1, 0}},
                                               {{0.12, 0, 0}, {-1, 0, 0}},
                                               {{0, 0.12, 0}, {0, -1, 0}}};
    struct composite cross;
    struct scree_error error = {.message = ""};
    struct convex *world = NULL;
    struct convex_body *bodies = column(count);
    int result = 1;
    if (!bodies || composite_cross(27e-3, 2e-3, 3e-3, 770, 1e-4, &cross, &error))
        goto out;
    struct convex_setup setup = {.step_s = 2.5e-6,
                                 .gravity = {0, 0, -9.81},
                                 .shapes = &cross,
                                 .shape_count = 1,
                                 .bodies = bodies,
                                 .body_count = count,
                                 .walls = walls,
                                 .wall_count = 5,
                                 .average = true};
    setup.between =
        (struct spring_pair){.stiffness = 4.5e5, .damping = 0.76, .stiffness_t = 300, .damping_t = 0.24, .friction = 0.46};
    setup.at_wall =
        (struct spring_pair){.stiffness = 4.5e5, .damping = 1.07, .stiffness_t = 300, .damping_t = 0.48, .friction = 0.62};
    if (convex_create(&setup, &world, &error) || convex_advance(world, settle, &error))
        goto out;
    struct convex_counts before = convex_counts(world);
    double start = seconds();
    if (convex_advance(world, timed, &error))
        goto out;
    double spent = seconds() - start;
    struct convex_counts after = convex_counts(world);
    struct convex_sums sums = convex_sums(world);
    double steps = (double)count * (double)timed;
    printf("%zu crosses, mean speed %.3g m/s, %.2f contacts a cross, %.1f listed pairs of parts a cross\n", count, sums.speed_mean,
           2 * (double)sums.contacts / (double)count, (double)after.pairs / (double)count);
    printf("%.3g cross-steps a CPU second (%s); %.3f distances a cross-step, %.3f of them searched for; a list every %.0f steps; "
           "%.0f bytes a cross\n",
           steps / spent, convex_isa(world), (double)(after.queries - before.queries) / steps,
           (double)(after.searches - before.searches) / steps,
           (double)timed / fmax(1, (double)(after.rebuilds - before.rebuilds)), (double)after.bytes / (double)count);
    result = 0;
out:
    if (result)
        fprintf(stderr, "%s\n", error.message[0] ? error.message : "no memory");
    convex_free(world);
    free(bodies);
    return result;
}

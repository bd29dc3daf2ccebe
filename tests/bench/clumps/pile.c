/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Not a test: goes on with a pile of cubes of eight spheres on a plane, periodic along x and y, and prints one line of
 * JSON: clump-steps per second of processor time. tests/bench/vs_liggghts writes the state and says what it is beside.
 *
 *     pile STATE STEPS [WARM]
 *
 * STATE: `N lx ly edge mass moment step young poisson restitution friction rolling`, then `x y z qw qx qy qz` a cube, SI. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dem/dem.h"
#include "dem/law.h"

struct pile {
    size_t count;
    double length[2], edge, mass, moment, step;
    struct fragment_spec matter;
    struct dem_body *bodies;
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int read_pile(const char *path, struct pile *p)
{
    double young, poisson;
    struct fragment_pair pair;
    FILE *file = fopen(path, "r");
    int whole =
        file && fscanf(file, "%zu %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &p->count, &p->length[0], &p->length[1], &p->edge,
                       &p->mass, &p->moment, &p->step, &young, &poisson, &pair.restitution, &pair.friction, &pair.rolling) == 12;
    p->bodies = whole ? calloc(p->count, sizeof *p->bodies) : NULL;
    for (size_t k = 0; p->bodies && k < p->count && whole; k++) {
        double *x = p->bodies[k].position, *q = p->bodies[k].orientation;
        whole = fscanf(file, "%lf %lf %lf %lf %lf %lf %lf", &x[0], &x[1], &x[2], &q[0], &q[1], &q[2], &q[3]) == 7;
        quat_store(q, quat_unit(quat_load(q)));
    }
    if (file)
        fclose(file);
    const struct fragment_matter matter = {.shear_Pa = young / (2 * (1 + poisson)), .poisson = poisson};
    p->matter = (struct fragment_spec){.clast = matter,
                                       .chute = matter,
                                       .gate = matter,
                                       .clast_clast = pair,
                                       .clast_chute = pair,
                                       .clast_gate = pair,
                                       .softening = 1};
    return whole && p->bodies;
}

static enum scree_status make_cube(const struct pile *p, struct clump *cube, struct scree_error *err)
{
    const double centre[3] = {0}, inertia[6] = {p->moment, p->moment, p->moment};
    double sphere[8][4];
    for (int k = 0; k < 8; k++) {
        for (int a = 0; a < 3; a++)
            sphere[k][a] = (k >> a & 1 ? 0.25 : -0.25) * p->edge;
        sphere[k][3] = 0.25 * p->edge;
    }
    return clump_create((const double(*)[4])sphere, 8, p->mass, centre, inertia, pow(p->edge, 3), cube, NULL, err);
}

static void print_rate(const struct pile *p, const struct view *view, double steps, double spent)
{
    double fastest = 0;
    for (size_t k = 0; k < view->bodies; k++) {
        const double *v = view->body[k].velocity;
        fastest = fmax(fastest, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    }
    printf("{\"clumps\": %zu, \"spheres\": %zu, \"contacts_a_clump\": %.3f, \"fastest_m_s\": %.3g, \"clump_steps_per_s\": %.6g}\n",
           p->count, view->moving, (double)view->contacts / (double)p->count, fastest, (double)p->count * steps / spent);
}

int main(int argc, char **argv)
{
    struct pile p = {0};
    struct scree_error error = {.message = ""};
    struct clump cube;
    struct dem *dem = NULL;
    struct view view;
    uint64_t steps = argc > 2 ? strtoul(argv[2], NULL, 10) : 0, warm = argc > 3 ? strtoul(argv[3], NULL, 10) : 200;
    if (steps == 0 || !read_pile(argv[1], &p)) {
        fprintf(stderr, "usage: pile STATE STEPS [WARM]; STATE is what tests/bench/vs_liggghts writes\n");
        return 2;
    }
    const struct dem_wall floor = {.normal = {0, 0, 1}, .base = true, .partner = FRAGMENT_CHUTE};
    const struct dem_setup setup = {.law = &law_hertz_tsuji,
                                    .matter = &p.matter,
                                    .step_s = p.step,
                                    .gravity = {0, 0, -9.81},
                                    .length = {p.length[0], p.length[1], 0},
                                    .shapes = &cube,
                                    .shape_count = 1,
                                    .bodies = p.bodies,
                                    .body_count = p.count,
                                    .walls = &floor,
                                    .wall_count = 1,
                                    .floor_z = -INFINITY,
                                    .threads = 1,
                                    .overlaps = true};
    enum scree_status status = make_cube(&p, &cube, &error);
    if (!status && !(status = dem_create(&setup, &dem, &error)) && !(status = dem_advance(dem, warm, &error))) {
        double start = seconds();
        status = dem_advance(dem, steps, &error);
        double spent = seconds() - start;
        if (!status && !(status = dem_view(dem, &view, &error)))
            print_rate(&p, &view, (double)steps, spent);
    }
    if (status)
        fprintf(stderr, "%s\n", error.message);
    dem_free(dem);
    free(p.bodies);
    return status != SCREE_OK;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `chute` of seed 003: counts, initial compaction, refusals (targets
 * S3-01, S3-02), its measurements on deposits made by hand (S3-04's unit, S3-12),
 * and a small flow through the whole engine. */
#include "engine.h"

#include "measure/bulk.h"
#include "measure/mobility.h"
#include "measure/outline.h"
#include "scenario/fragments.h"
#include "scenario/scenario.h"

static struct job_spec chute_job(double mass_g, double size_m)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("chute"));
    struct chute_params *p = (struct chute_params *)(void *)job.params;
    p->mass_g = mass_g;
    p->size_m = size_m;
    job.fragments.softening = 1000;
    job.time.step_s = 0.2 * fragment_rayleigh_time(&job.fragments, size_m / 4);
    return job;
}

static struct chute_params *params(struct job_spec *job)
{
    return (struct chute_params *)(void *)job->params;
}

static size_t counts_of(struct job_spec *job, size_t by_shape[3], struct dem_body **bodies)
{
    struct clump shapes[FRAGMENT_SHAPES];
    struct scree_error error = {0};
    size_t count;
    must(job_check(job, 0, &error), &error);
    must(fragments_fill(job, shapes, bodies, &count, &error), &error);
    memset(by_shape, 0, 3 * sizeof *by_shape);
    for (size_t k = 0; k < count; k++)
        by_shape[(*bodies)[k].shape]++;
    return count;
}

/* S3-01: mass fractions 38, 22, 40 % of a^3, a^3 / 2, a^3 / 4. */
static void counts_are_those_of_the_mass_fractions(void **state)
{
    (void)state;
    const struct {
        double mass, size;
        size_t count;
    } flows[] = {{27, 1.5e-3, 7170}, {27, 2e-3, 3025}, {27, 3e-3, 896}, {9, 1e-3, 8067}};
    for (int k = 0; k < 4; k++) {
        struct job_spec job = chute_job(flows[k].mass, flows[k].size);
        struct dem_body *bodies = NULL;
        size_t shapes[3], count = counts_of(&job, shapes, &bodies);
        assert_true(count + 2 > flows[k].count && count < flows[k].count + 2); // each shape is rounded to whole ones
        double cube = 2.7 * pow(100 * flows[k].size, 3);
        assert_true(fabs((double)shapes[0] * cube / flows[k].mass - 0.38) < 2 * cube / flows[k].mass);
        assert_true(fabs((double)shapes[1] * cube / 2 / flows[k].mass - 0.22) < 2 * cube / flows[k].mass);
        free(bodies);
    }
    /* 27 g of 1 mm are counted without being placed: that takes seconds. */
    assert_int_equal((int)(round(27 * .38 / 2.7e-3) + round(27 * .22 / 1.35e-3) + round(27 * .40 / 0.675e-3)), 24200);
}

/* S3-02: the space that fragments are in has the asked density, compact and not, and none leaves it or meets another. */
static void initial_compaction_is_as_asked(void **state)
{
    (void)state;
    const double space[] = {0, 27}, density[] = {731, 731.0 * 9 / 27};
    for (int k = 0; k < 2; k++) {
        struct job_spec job = chute_job(9, 2e-3);
        params(&job)->space_mass_g = space[k];
        struct dem_body *bodies = NULL;
        size_t shapes[3], count = counts_of(&job, shapes, &bodies);
        struct chute c = fragments_chute(&job);
        double low = 0, high = -1, slope = chute_slope(&c, 0);
        for (size_t b = 0; b < count; b++) { // along the accelerator
            const double *x = bodies[b].position;
            double along = x[0] * cos(slope) - (x[2] - c.height) * sin(slope);
            low = fmin(low, along);
            high = fmax(high, along);
            assert_true(fabs(x[1]) < 0.5 * c.width);
        }
        /* Centres fill the space but for about half a grain at either end. */
        double length = high - low + 2e-3, area = 0.5 * (c.floor + c.width) * 0.5 * (c.width - c.floor);
        assert_true(high < -c.gate && high > -c.gate - 3e-3);
        assert_true(fabs(9e-3 / (length * area) / density[k] - 1) < 0.05);
        struct dem *dem = NULL;
        struct scree_error error = {0};
        must(scenario_implementation("chute")->build(&job, &(struct scenario_means){.threads = 1}, &dem, &error),
             &error); // refuses overlaps itself
        dem_free(dem);
        free(bodies);
    }
}

static void refused(struct job_spec *job, const char *path, const char *message)
{
    struct scree_error error = {0};
    struct dem *dem = NULL;
    enum scree_status status = job_check(job, 0, &error);
    if (!status)
        status = scenario_implementation("chute")->build(job, &(struct scenario_means){.threads = 1}, &dem, &error);
    assert_int_equal(status, SCREE_INVALID);
    assert_string_equal(error.path, path);
    if (!strstr(error.message, message))
        fail_msg("\"%s\"", error.message);
}

static void impossible_flows_are_refused(void **state)
{
    (void)state;
    struct job_spec job = chute_job(9, 3e-3);
    params(&job)->space_density_kg_m3 = 2500;
    refused(&job, "params.mass_g", "fit into the space behind the gate without overlap");
    job = chute_job(9, 3e-3);
    params(&job)->space_mass_g = 5;
    refused(&job, "params.space_mass_g", "a space made for 5 g does not hold the flow's mass");
    job = chute_job(9, 3e-3);
    params(&job)->spheres = 3;
    refused(&job, "params.spheres", "3 along an edge leave half a sphere");
    job = chute_job(9, 3e-3);
    params(&job)->halves = 0.7;
    refused(&job, "params.halves", "cubes and halves make up 1.08");
    job = chute_job(9, 3e-3);
    job.time.step_s *= 3;
    refused(&job, "time.step_s", "of the Rayleigh time");
    job = chute_job(1e-3, 3e-3);
    refused(&job, "params.mass_g", "are not one fragment");
}

/* ---- clasts of the user's own ---- */

/* A cube of edge a by its triangles, with the eight spheres of the published one in it. */
static void own_cube(struct job_spec *job, double a)
{
    static const double faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                        {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    struct clast_spec *c = &params(job)->clast;
    c->on = true;
    c->spheres.count = c->vertices.count = 8;
    c->faces.count = 12;
    memcpy(c->faces.row, faces, sizeof faces);
    for (int k = 0; k < 8; k++) {
        for (int i = 0; i < 3; i++) {
            double side = k >> i & 1 ? 0.5 : -0.5;
            c->vertices.row[k][i] = side * a;
            c->spheres.row[k][i] = 0.5 * side * a;
        }
        c->spheres.row[k][3] = 0.25 * a * (1 - 1e-9);
    }
}

static struct clump own_shape(struct job_spec *job, size_t *count)
{
    struct clump shapes[FRAGMENT_SHAPES];
    struct dem_body *bodies = NULL;
    struct scree_error error = {0};
    must(job_check(job, 0, &error), &error);
    must(fragments_fill(job, shapes, &bodies, count, &error), &error);
    free(bodies);
    return shapes[0];
}

/* By polyhedron or in numbers: what comes out is the cube of the paper. */
static void a_clast_of_ones_own_can_be_the_published_cube(void **state)
{
    (void)state;
    const double a = 3e-3, mass = 2700 * a * a * a, moment = mass * a * a / 6;
    struct job_spec job = chute_job(9, a);
    size_t count;
    own_cube(&job, a);
    struct clump by_faces = own_shape(&job, &count);
    assert_int_equal(count, (int)round(9e-3 / mass));
    struct clast_spec *c = &params(&job)->clast;
    c->faces.count = 0;
    c->mass_kg = mass;
    for (int i = 0; i < 3; i++)
        c->moments_kg_m2[i] = moment;
    struct clump by_numbers = own_shape(&job, &count);
    assert_int_equal(count, (int)round(9e-3 / mass));
    assert_true(fabs(by_faces.mass / mass - 1) < 1e-12 && by_numbers.mass == mass);
    assert_true(fabs(by_faces.volume / by_numbers.volume - 1) < 1e-12 && by_faces.spheres == 8);
    for (int i = 0; i < 3; i++)
        assert_true(fabs(by_faces.inertia[i] / moment - 1) < 1e-12 && fabs(by_numbers.inertia[i] / moment - 1) < 1e-12);
    struct dem *dem = NULL;
    struct scree_error error = {0};
    must(scenario_implementation("chute")->build(&job, &(struct scenario_means){.threads = 1}, &dem, &error), &error);
    advance(dem, 100);
    dem_free(dem);
}

static void impossible_clasts_are_refused(void **state)
{
    (void)state;
    struct job_spec job = chute_job(9, 3e-3);
    own_cube(&job, 3e-3);
    struct clast_spec *c = &params(&job)->clast, whole = *c;
    c->spheres.row[5][0] += 1e-5;
    refused(&job, "params.clast", "params.clast: sphere 5 leaves its polyhedron through triangle 10 by 1e-05 m");
    *c = whole;
    c->faces.count = 11;
    refused(&job, "params.clast", "params.clast: the mesh is open: triangle");
    *c = whole;
    c->faces.row[4][1] = 8;
    refused(&job, "params.clast.faces", "triangle 4 has no such vertex");
    *c = whole;
    c->mass_kg = 1e-5;
    refused(&job, "params.clast.mass_kg", "faces give the mass already");
    c->faces.count = 0;
    refused(&job, "params.clast", "moments of inertia must be positive: one is 0");
    c->mass_kg = 0;
    refused(&job, "params.clast", "mass must be positive, not 0");
    c->spheres.row[2][3] = 0;
    refused(&job, "params.clast.spheres", "sphere 2 has no radius");
    c->spheres.count = 0;
    refused(&job, "params.clast.spheres", "needs a sphere");
}

/* ---- measurements on views made by hand ---- */

enum { ROW = 40 };

/* ROW cubes in a row down the chute from x = 0.3, 2 mm apart, touching one
 * another, then 5 loners farther down: all released at one point. */
struct scene {
    struct view view;
    struct view_body body[ROW + 5];
    struct view_contact contact[ROW];
    double release[ROW + 5][4];
    struct mobility_site site;
};

static void scene_make(struct scene *s)
{
    struct job_spec job = chute_job(27, 1e-3);
    memset(s, 0, sizeof *s);
    s->site = (struct mobility_site){
        .chute = fragments_chute(&job), .release = (const double(*)[4])s->release, .count = ROW + 5, .grain_m = 1e-3};
    for (uint32_t k = 0; k < ROW + 5; k++) {
        double x = k < ROW ? 0.3 + 2e-3 * k : 0.6 + 0.05 * (k - ROW);
        s->body[k] = (struct view_body){.id = k, .first = k, .members = 1, .mass = 1e-3, .volume = k % 4 ? 1e-9 : 4e-9};
        s->body[k].position[0] = x;
        s->body[k].position[2] = chute_z(&s->site.chute, x) + 1e-3;
        s->release[k][0] = -0.2;
        s->release[k][2] = 0.5;
        s->release[k][3] = 1e-3;
        if (k + 1 < ROW)
            s->contact[k] = (struct view_contact){.a = k, .b = k + 1, .overlap = 1e-6};
    }
    s->contact[ROW - 1] = (struct view_contact){.a = ROW, .b = VIEW_WALL}; // floors connect nobody
    s->view = (struct view){
        .gravity = {0, 0, -9.81}, .moving = ROW + 5, .bodies = ROW + 5, .body = s->body, .contacts = ROW, .contact = s->contact};
}

/* S3-12 and eqs 14, 16: the flow proper is the connected row, the bar's ends are the shortened row and all bodies. */
static void mobility_is_that_of_the_largest_connected_part(void **state)
{
    (void)state;
    static struct scene s;
    struct mobility d;
    struct scree_error error;
    uint8_t in_flow[ROW + 5];
    scene_make(&s);
    must(mobility_measure(&s.view, &s.site, &d, in_flow, &error), &error);
    assert_int_equal(d.bodies, ROW + 5);
    assert_int_equal(d.in_flow, ROW);
    for (int k = 0; k < ROW + 5; k++)
        assert_int_equal(in_flow[k], k < ROW);
    double z[3] = {0}, x[3] = {0};
    int n[3] = {0};
    double front = chute_arc(&s.site.chute, s.body[ROW - 1].position[0]);
    for (int k = 0; k < ROW + 5; k++) {
        const double *p = s.body[k].position;
        const bool belongs[3] = {k < ROW, k < ROW && chute_arc(&s.site.chute, p[0]) <= front - 0.03, true};
        for (int w = 0; w < 3; w++)
            if (belongs[w])
                x[w] += p[0], z[w] += p[2], n[w]++;
    }
    const double have[3] = {d.mobility, d.upper, d.lower};
    for (int w = 0; w < 3; w++)
        assert_true(fabs(have[w] - (0.5 - z[w] / n[w]) / (x[w] / n[w] + 0.2)) < 1e-12);
    assert_true(d.lower < d.mobility && d.mobility < d.upper && fabs(d.trimmed - d.mobility) < 1e-12);
    /* 27 g of 1 mm: beta 0.739 in the paper's unit (10 cm3). */
    for (int k = 0; k < ROW; k++)
        s.body[k].volume = 10e-6 / ROW;
    must(mobility_measure(&s.view, &s.site, &d, NULL, &error), &error);
    assert_true(fabs(d.beta - 0.739) < 5e-4);
}

/* Ranks: 0.5 where the big ones are spread evenly, 1 - 1/8 where they are the farther quarter. */
static void ranks_tell_where_the_largest_are(void **state)
{
    (void)state;
    static struct scene s;
    struct mobility d;
    struct scree_error error;
    scene_make(&s);
    for (int k = 0; k < ROW; k++)
        s.body[k].volume = k >= 3 * ROW / 4 ? 2e-9 : 1e-9;
    must(mobility_measure(&s.view, &s.site, &d, NULL, &error), &error);
    assert_true(fabs(d.cube_front - 0.875) < 1e-12);
    for (int k = 0; k < ROW; k++) {
        s.body[k].volume = k % 2 ? 1e-9 : 2e-9;
        s.body[k].position[2] += (k % 2 ? -1e-4 : 1e-4);
    }
    must(mobility_measure(&s.view, &s.site, &d, NULL, &error), &error);
    assert_true(fabs(d.cube_front - 0.5) < 0.02 && fabs(d.cube_height - 0.75) < 1e-12);
}

/* Eq. of 3.4: variance across, and what was lost is g times the drop less the energy of motion. */
static void agitation_and_losses_of_the_central_part(void **state)
{
    (void)state;
    static struct scene s;
    struct scree_error error;
    double row[FLOW_COLUMNS], drop = 0;
    int inside = 0;
    scene_make(&s);
    double median = chute_arc(&s.site.chute, s.body[22].position[0]); // of 45 masses the 23rd
    for (int k = 0; k < ROW + 5; k++) {
        s.body[k].velocity[1] = k % 2 ? 0.3 : -0.1;
        s.body[k].velocity[0] = 1;
        if (fabs(chute_arc(&s.site.chute, s.body[k].position[0]) - median) <= 0.025) {
            drop += 0.5 - s.body[k].position[2];
            inside++;
        }
    }
    must(flow_measure(&s.view, &s.site, row, &error), &error);
    assert_true(fabs(row[1] - median) < 1e-12 && row[2] == inside);
    double odd = floor(inside / 2.0) / inside, p = odd < 0.5 && 22 % 2 ? 1 - odd : odd, mean = 0.3 * p - 0.1 * (1 - p);
    double variance = 0.09 * p + 0.01 * (1 - p) - mean * mean, v2 = 1 + 0.09 * p + 0.01 * (1 - p);
    assert_true(fabs(row[3] - variance) < 2e-3 && fabs(row[5] - 0.5 * v2) < 2e-3);
    assert_true(fabs(row[8] - (9.81 * drop / inside - row[5])) < 1e-12);
}

/* S3-08: the deposit by centimetre, the flow by height: two layers, the upper faster and without scatter across. */
static void slices_of_the_deposit_and_layers_of_the_flow(void **state)
{
    (void)state;
    static struct scene s;
    struct mobility d;
    struct scree_error error;
    uint8_t in_flow[ROW + 5];
    double(*outline)[OUTLINE_COLUMNS], layers[LAYERS_MAX][LAYER_COLUMNS], bodies = 0, mass = 0, left = 0, right = 0;
    size_t slices;
    scene_make(&s);
    for (int k = 0; k < ROW + 5; k++) { // every other one lies 0.5 mm, the rest 1.5 mm above the floor
        double x = s.body[k].position[0], slope = chute_slope(&s.site.chute, x), lift = k % 2 ? 1.5e-3 : 0.5e-3;
        s.body[k].position[2] = chute_z(&s.site.chute, x) + lift / cos(slope);
        s.body[k].velocity[0] = (k % 2 ? 2 : 1) * cos(slope);
        s.body[k].velocity[2] = -(k % 2 ? 2 : 1) * sin(slope);
        s.body[k].velocity[1] = k % 2 ? 0.1 : k % 4 ? 0.2 : -0.2;
        s.body[k].position[1] = k == 3 ? 0.01 : k == 4 ? -0.02 : 0;
    }
    must(mobility_measure(&s.view, &s.site, &d, in_flow, &error), &error);
    must(outline_deposit(&s.view, &s.site, in_flow, &outline, &slices, &error), &error);
    assert_true(fabs((double)slices * 0.01 - (d.front - d.rear)) < 0.02);
    for (size_t k = 0; k < slices; k++) {
        bodies += outline[k][1];
        mass += outline[k][2];
        left = fmin(left, outline[k][4]);
        right = fmax(right, outline[k][5]);
        assert_true(outline[k][0] > d.rear - 0.01 && outline[k][0] < d.front + 0.01);
        assert_true(outline[k][1] < 2 || fabs(outline[k][3] - 1.5e-3) < 1e-12);
    }
    assert_true(bodies == ROW && fabs(mass - 1e-3 * ROW) < 1e-12);
    assert_true(left == -0.02 && right == 0.01 && outline[slices - 1][4] == 0);
    free(outline);
    assert_int_equal(outline_layers(&s.view, &s.site, chute_arc(&s.site.chute, s.body[20].position[0]), layers), 2);
    for (int k = 0; k < 2; k++) {
        assert_true(fabs(layers[k][0] - (k + 0.5) * 1e-3) < 1e-15 && layers[k][1] > 10);
        assert_true(fabs(layers[k][2] - (k + 1)) < 1e-12);
        assert_true(fabs(layers[k][3] - (k ? 0 : 0.04)) < 1e-3);
    }
    assert_true(layers[0][4] > 0.4 && layers[1][4] == 0); // every fourth is of the largest
}

/* Where bodies lie still, and how deep contacts are. */
static void what_lies_still_and_how_deep_contacts_are(void **state)
{
    (void)state;
    static struct scene s;
    struct scree_error error;
    double row[FLOW_COLUMNS];
    scene_make(&s);
    s.contact[7].overlap = 3e-5;
    for (int k = 20; k < ROW + 5; k++)
        s.body[k].velocity[0] = 1;
    must(flow_measure(&s.view, &s.site, row, &error), &error);
    assert_true(fabs(row[FLOW_OVERLAP] - 0.03) < 1e-15 && row[FLOW_OVERLAP - 1] > 1e-3 && row[FLOW_OVERLAP - 1] < 2e-3);
    assert_true(row[11] == chute_arc(&s.site.chute, s.body[1].position[0])); // of twenty the second and the last but one
    assert_true(row[12] == chute_arc(&s.site.chute, s.body[18].position[0]));
}

/* ---- a small flow ---- */

/* 3 g of 3 mm run 0.7 s: they leave the gate, come onto the chute, stay in it,
 * and what gravity did is found again as motion, springs and losses. */
static void a_small_flow_runs_and_its_budget_closes(void **state)
{
    (void)state;
    struct job_spec job = chute_job(3, 3e-3);
    struct dem *dem = NULL;
    struct scree_error error = {0};
    job.record.energy.on = true;
    must(job_check(&job, 0, &error), &error);
    must(scenario_implementation("chute")->build(&job, &(struct scenario_means){.threads = 1}, &dem, &error), &error);
    advance(dem, (uint64_t)(0.7 / job.time.step_s));
    struct view view;
    struct bulk bulk;
    must(dem_view(dem, &view, &error), &error);
    bulk_measure(&view, &bulk);
    double lost = view.dissipated_normal + view.dissipated_tangential + view.dissipated_rolling, mean = 0;
    for (size_t k = 0; k < view.bodies; k++)
        mean += view.body[k].position[0] / (double)view.bodies;
    assert_true(mean > 0.1);
    assert_true(view.dissipated_normal > 0 && view.dissipated_tangential > 0 && view.dissipated_rolling > 0);
    double residual = (view.gravity_work - bulk.kinetic - bulk.elastic - lost) / view.gravity_work;
    if (!(fabs(residual) < 1e-2)) // S3-07: 1 %
        fail_msg("residual %g", residual);
    dem_free(dem);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_those_of_the_mass_fractions),
        cmocka_unit_test(initial_compaction_is_as_asked),
        cmocka_unit_test(impossible_flows_are_refused),
        cmocka_unit_test(a_clast_of_ones_own_can_be_the_published_cube),
        cmocka_unit_test(impossible_clasts_are_refused),
        cmocka_unit_test(mobility_is_that_of_the_largest_connected_part),
        cmocka_unit_test(ranks_tell_where_the_largest_are),
        cmocka_unit_test(agitation_and_losses_of_the_central_part),
        cmocka_unit_test(slices_of_the_deposit_and_layers_of_the_flow),
        cmocka_unit_test(what_lies_still_and_how_deep_contacts_are),
        cmocka_unit_test(a_small_flow_runs_and_its_budget_closes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

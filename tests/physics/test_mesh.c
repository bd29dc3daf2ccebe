/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walls of triangles in the engine: as a plane where they are flat, each contact
 * once on faces, edges and corners, springs that slide from triangle to triangle,
 * the chute of seed 003 (targets S3-03), bits. */
#include "engine.h"

#include "base/cpu.h"
#include "base/rng.h"
#include "dem/image.h"
#include "dem/law.h"
#include "geom/chute.h"

static struct trimesh *mesh_of(const double (*vertex)[3], size_t vertices, const uint32_t (*corner)[3], size_t triangles)
{
    struct scree_error error = {0};
    struct trimesh *mesh = NULL;
    must(trimesh_create(vertex, vertices, corner, triangles, false, &mesh, &error), &error);
    return mesh;
}

/* A sheet of n x n cells of irregular triangles; its height is `z` of x. */
static struct trimesh *sheet(int n, double cell, double (*z)(double x))
{
    double(*vertex)[3] = calloc((size_t)(n + 1) * (size_t)(n + 1), sizeof *vertex);
    uint32_t(*corner)[3] = calloc(2 * (size_t)n * (size_t)n, sizeof *corner);
    struct rng rng = rng_start(9, 9);
    size_t v = 0, t = 0;
    for (int j = 0; j <= n; j++)
        for (int i = 0; i <= n; i++, v++) {
            vertex[v][0] = (i + rng_uniform(&rng, -0.3, 0.3)) * cell;
            vertex[v][1] = (j - n / 2 + rng_uniform(&rng, -0.3, 0.3)) * cell;
            vertex[v][2] = z(vertex[v][0]);
        }
    for (uint32_t j = 0; j < (uint32_t)n; j++)
        for (uint32_t i = 0; i < (uint32_t)n; i++) {
            uint32_t a = j * (uint32_t)(n + 1) + i, b = a + 1, c = a + (uint32_t)n + 1, d = c + 1;
            memcpy(corner[t++], ((uint32_t[3]){a, b, d}), 12);
            memcpy(corner[t++], ((uint32_t[3]){a, d, c}), 12);
        }
    struct trimesh *mesh = mesh_of((const double(*)[3])vertex, v, (const uint32_t(*)[3])corner, t);
    free(vertex);
    free(corner);
    return mesh;
}

static double flat(double x)
{
    (void)x;
    return 0;
}

static const double R = 2e-3;

static struct dem *sphere_world(const struct fragment_spec *m, const struct dem_grain *grain, const double gravity[3],
                                const struct trimesh *mesh, double step_s)
{
    uint8_t *partner = mesh ? malloc(mesh->triangles) : NULL;
    if (mesh)
        memset(partner, FRAGMENT_CHUTE, mesh->triangles);
    const struct dem_wall floor = {.normal = {0, 0, 1}, .base = true, .partner = FRAGMENT_CHUTE};
    const struct dem_surface surface = {.mesh = mesh, .partner = partner, .until_s = INFINITY, .base = true};
    struct dem_setup setup = {.law = &law_hertz_tsuji,
                              .matter = m,
                              .step_s = step_s,
                              .grains = grain,
                              .grain_count = 1,
                              .walls = &floor,
                              .wall_count = mesh ? 0 : 1,
                              .surfaces = &surface,
                              .surface_count = mesh ? 1 : 0,
                              .floor_z = -1,
                              .threads = 1,
                              .overlaps = true,
                              .ledger = true};
    memcpy(setup.gravity, gravity, sizeof setup.gravity);
    struct dem *dem = NULL;
    struct scree_error error = {0};
    must(dem_create(&setup, &dem, &error), &error);
    free(partner);
    return dem;
}

/* A sphere that slides, then rolls down over hundreds of triangles moves as on a
 * plane: no contact counted twice, no spring lost or jumping at an edge. */
static void a_flat_of_triangles_is_a_plane(void **state)
{
    (void)state;
    struct fragment_spec m = fragment_igneous;
    m.softening = 1e3;
    const double gravity[3] = {2, 0.3, -9.81}, step = 2e-6;
    struct dem_grain grain = {
        .position = {0.02, 0, R}, .velocity = {0.3, 0.05, -0.01}, .spin = {0, -50, 30}, .radius = R, .density = 2700};
    struct trimesh *mesh = sheet(40, 6e-3, flat);
    struct dem *plane = sphere_world(&m, &grain, gravity, NULL, step), *many = sphere_world(&m, &grain, gravity, mesh, step);
    for (int k = 0; k < 40; k++) {
        advance(plane, 4000);
        advance(many, 4000);
        struct view a = look(plane), b = look(many);
        for (int i = 0; i < 3; i++) {
            assert_true(fabs(a.position[0][i] - b.position[0][i]) < 1e-9 * 0.1);
            assert_true(fabs(a.velocity[0][i] - b.velocity[0][i]) < 1e-9);
            assert_true(fabs(a.spin[0][i] - b.spin[0][i]) * R < 1e-9);
        }
        assert_true(b.contacts <= 1 && a.contacts == b.contacts);
        assert_true(fabs(a.dissipated_tangential - b.dissipated_tangential) < 1e-9 * a.dissipated_tangential);
    }
    assert_true(look(many).position[0][0] > 0.1); // many triangles were crossed
    dem_free(plane);
    dem_free(many);
    trimesh_free(mesh);
}

/* How many contacts a sphere has whose centre is here, and their largest overlap. */
static size_t contacts_at(const struct trimesh *mesh, double x, double y, double z, double *overlap)
{
    const double none[3] = {0};
    struct dem_grain grain = {.position = {x, y, z}, .radius = R, .density = 2700};
    struct dem *dem = sphere_world(&fragment_igneous, &grain, none, mesh, 1e-12);
    advance(dem, 1);
    struct view view = look(dem);
    size_t count = view.contacts;
    *overlap = 0;
    for (size_t k = 0; k < count; k++)
        *overlap = fmax(*overlap, view.contact[k].overlap);
    dem_free(dem);
    return count;
}

/* The corner of a room: floor and two walls of two triangles each; and a lone block's corner seen from outside. */
static void faces_edges_and_corners_count_once(void **state)
{
    (void)state;
    const double s = 0.02, e = 1e-6, room[7][3] = {{0, 0, 0}, {s, 0, 0}, {s, s, 0}, {0, s, 0}, {0, 0, s}, {s, 0, s}, {0, s, s}};
    const uint32_t inner[6][3] = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}, {1, 4, 5}, {0, 3, 4}, {3, 6, 4}};
    struct trimesh *mesh = mesh_of(room, 7, inner, 6);
    double overlap;
    assert_int_equal(contacts_at(mesh, s / 2, s / 2, R - e, &overlap), 1); // on the diagonal that two triangles share
    assert_true(fabs(overlap - e) < 1e-12);
    assert_int_equal(contacts_at(mesh, s / 3, s / 2, R - e, &overlap), 1);
    /* Deep, and 0.3 R beside the diagonal: the other triangle offers that, 18 degrees off the normal, as a rim. */
    assert_int_equal(contacts_at(mesh, s / 2 + 0.21 * R, s / 2 - 0.21 * R, 0.9 * R, &overlap), 1);
    assert_int_equal(contacts_at(mesh, R - e, s / 2, R - e, &overlap), 2);
    assert_int_equal(contacts_at(mesh, R - e, R - e, R - e, &overlap), 3);
    assert_true(fabs(overlap - e) < 1e-12);
    assert_int_equal(contacts_at(mesh, R - e, R - e, s / 2, &overlap), 2);
    /* From below: past the floor's rim the sphere hangs on an edge of it, past its corner on that. */
    assert_int_equal(contacts_at(mesh, s + 0.5 * R, s / 2, -0.5 * R, &overlap), 1);
    assert_true(fabs(overlap - R * (1 - sqrt(0.5))) < 1e-12);
    assert_int_equal(contacts_at(mesh, s + 0.5 * R, s + 0.5 * R, -0.5 * R, &overlap), 1);
    assert_true(fabs(overlap - R * (1 - sqrt(0.75))) < 1e-12);
    assert_int_equal(contacts_at(mesh, s + 0.8 * R, s + 0.8 * R, -0.5 * R, &overlap), 0);
    trimesh_free(mesh);
}

static double bowl(double x)
{
    return 2 * (x - 0.12) * (x - 0.12);
}

/* On a curved wall of flat pieces a grain touches one at a time, its weight is
 * carried at every instant, and energy is only ever lost. */
static void a_bowl_of_pieces_is_smooth(void **state)
{
    (void)state;
    struct fragment_spec m = fragment_igneous;
    m.softening = 1e3;
    m.clast_chute.friction = 0;
    m.clast_chute.rolling = 0;
    m.clast_chute.restitution = 0.9;
    const double gravity[3] = {0, 0, -9.81}, step = 1e-6;
    struct trimesh *mesh = sheet(60, 4e-3, bowl);
    double x = 0.08, slope = atan(4 * (x - 0.12));
    struct dem_grain grain = {
        .position = {x - (R + 1e-5) * sin(slope), 0, bowl(x) + (R + 1e-5) * cos(slope)}, .radius = R, .density = 2700};
    struct dem *dem = sphere_world(&m, &grain, gravity, mesh, step);
    double mass = 2700 * 4.0 / 3 * M_PI * R * R * R, start = 0, last = 0, lowest = 1;
    for (int k = 0; k < 400; k++) {
        advance(dem, 1000);
        struct view view = look(dem);
        const double *v = view.velocity[0];
        double energy = 0.5 * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + mass * 9.81 * view.position[0][2];
        for (size_t c = 0; c < view.contacts; c++)
            energy += view.contact[c].elastic;
        start = k == 0 ? energy : start;
        last = energy;
        lowest = fmin(lowest, view.position[0][2]);
        assert_true(view.contacts <= 1);
        assert_true(energy < start * (1 + 1e-6));
    }
    assert_true(lowest < R + bowl(0.124)); // it went through the bottom
    assert_true(last > 0.9 * start);       // a few thousand facets did not brake it
    dem_free(dem);
    trimesh_free(mesh);
}

static const struct chute published = {.height = 0.3,
                                       .drop = 0.085,
                                       .steepness = 11.765,
                                       .run = 1.4,
                                       .accelerator = 0.35,
                                       .floor = 0.03,
                                       .width = 0.054,
                                       .side_rad = M_PI / 4,
                                       .guard = 0.05,
                                       .gate = 0.223,
                                       .flatness = 2e-6};

/* S3-03: slopes, height at the end, length along the curve; the mesh is nowhere off the profile by more than asked. */
static void the_chute_is_that_of_equation_1(void **state)
{
    (void)state;
    const double x[] = {0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.4}, slope[] = {45.0, 40.8, 32.9, 21.4, 15.3, 9.5, 3.5};
    for (int k = 0; k < 7; k++)
        assert_true(fabs(chute_slope(&published, x[k]) * 180 / M_PI - slope[k]) < 0.06);
    assert_true(fabs(chute_z(&published, 1.4) - 0.0029) < 5e-5);
    assert_true(fabs(chute_arc(&published, 1.4) - 1.458) < 5e-4);
    assert_true(fabs(chute_arc(&published, -0.1) + 0.1 * sqrt(1 + pow(0.085 * 11.765, 2))) < 1e-9);
    struct trimesh *mesh = NULL;
    uint8_t *accelerator = NULL;
    struct scree_error error;
    must(chute_mesh(&published, &mesh, &accelerator, &error), &error);
    double worst = 0;
    for (double at = -0.2; at < 1.39; at += 1.7e-3) {
        uint32_t found[256];
        double p[3] = {at, 0.004, chute_z(&published, at)}, nearest = 1;
        size_t count = trimesh_near(mesh, p, 1e-3, found, 256);
        assert_true(count < 256);
        for (size_t f = 0; f < count; f++) {
            struct nearest n = trimesh_nearest(mesh, found[f], p);
            nearest = fmin(nearest, hypot(hypot(n.point[0] - p[0], n.point[1] - p[1]), n.point[2] - p[2]));
        }
        worst = fmax(worst, nearest);
    }
    assert_true(worst < 1.5 * published.flatness && worst > 0.1 * published.flatness);
    assert_true(accelerator[0] == 1 && accelerator[mesh->triangles / 2] == 0);
    trimesh_free(mesh);
    free(accelerator);
}

/* Fragments behind a gate that lifts: a small release, for bits and images. */
static struct dem *release(int threads, const char *isa)
{
    static struct fragment_spec m;
    static struct clump shapes[3];
    static struct dem_body bodies[60];
    const double a = 3e-3, size[3][3] = {{a, a, a}, {a, a, a / 2}, {a, a / 2, a / 2}};
    struct trimesh *mesh = NULL, *gate = NULL;
    uint8_t *partner = NULL, gate_partner[4] = {FRAGMENT_GATE, FRAGMENT_GATE, FRAGMENT_GATE, FRAGMENT_GATE};
    struct scree_error error;
    struct chute chute = published;
    chute.flatness = 2e-5;
    m = fragment_igneous;
    m.softening = 1e4;
    must(chute_mesh(&chute, &mesh, &partner, &error), &error);
    must(chute_gate(&chute, &gate, &error), &error);
    for (size_t t = 0; t < mesh->triangles; t++)
        partner[t] = partner[t] ? FRAGMENT_GATE : FRAGMENT_CHUTE;
    for (int k = 0; k < 3; k++)
        must(clump_block(size[k], a / 4, 2700, &shapes[k], &error), &error);
    struct rng rng = rng_start(2, 2);
    for (int k = 0; k < 60; k++) {
        bodies[k] = (struct dem_body){.shape = (uint32_t)(k % 3)};
        chute_accelerator_point(&chute, -chute.gate - 3.2e-3 - 5.5e-3 * (k / 12), -0.0125 + 0.0082 * (k % 4),
                                3.2e-3 + 5.5e-3 * (k / 4 % 3), bodies[k].position);
        struct quat q = quat_unit((struct quat){rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1), 0.3});
        quat_store(bodies[k].orientation, q);
    }
    double lift = 2 * sqrt(0.5);
    const struct dem_surface surfaces[2] = {
        {.mesh = gate, .partner = gate_partner, .velocity = {lift, 0, lift}, .from_s = 0.05, .until_s = 0.1},
        {.mesh = mesh, .partner = partner, .until_s = INFINITY, .base = true}};
    struct dem_setup setup = {.law = &law_hertz_tsuji,
                              .matter = &m,
                              .step_s = 0.15 * fragment_rayleigh_time(&m, a / 4),
                              .gravity = {0, 0, -9.81},
                              .shapes = shapes,
                              .shape_count = 3,
                              .bodies = bodies,
                              .body_count = 60,
                              .surfaces = surfaces,
                              .surface_count = 2,
                              .floor_z = -0.1,
                              .threads = threads,
                              .isa = isa,
                              .ledger = true};
    struct dem *dem = NULL;
    must(dem_create(&setup, &dem, &error), &error);
    trimesh_free(mesh);
    trimesh_free(gate);
    free(partner);
    return dem;
}

/* A gate must stand clear of what it holds: said by grain, triangle and surface. */
static void a_gate_inside_a_grain_is_refused(void **state)
{
    (void)state;
    const double vertex[4][3] = {{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}};
    const uint32_t corner[2][3] = {{0, 1, 2}, {0, 2, 3}};
    struct trimesh *gate = NULL;
    struct scree_error error = {0};
    struct dem *dem = NULL;
    must(trimesh_create(vertex, 4, corner, 2, false, &gate, &error), &error);
    const struct dem_surface surface = {.mesh = gate, .until_s = INFINITY};
    struct dem_grain grain = {.position = {-0.9e-3, 0.5, 0}, .radius = 1e-3, .density = 2700};
    struct dem_setup setup = {.law = &law_hertz_tsuji,
                              .matter = &fragment_igneous,
                              .step_s = 1e-8,
                              .grains = &grain,
                              .grain_count = 1,
                              .surfaces = &surface,
                              .surface_count = 1,
                              .floor_z = -INFINITY,
                              .threads = 1};
    assert_int_equal(dem_create(&setup, &dem, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "grain 0 starts 0.0001 m deep in triangle 0 of surface 0"));
    grain.position[0] = -1e-3; // touches
    must(dem_create(&setup, &dem, &error), &error);
    dem_free(dem);
    trimesh_free(gate);
}

static void a_gate_holds_then_lifts(void **state)
{
    (void)state;
    struct dem *dem = release(1, NULL);
    double step = look(dem).step_s, furthest = -1;
    advance(dem, (uint64_t)(0.05 / step));
    struct view view = look(dem);
    for (size_t k = 0; k < view.bodies; k++)
        furthest = fmax(furthest, (view.body[k].position[0] - view.body[k].position[2] + published.height) * sqrt(0.5));
    assert_true(furthest < -published.gate); // along the accelerator: behind the gate
    advance(dem, (uint64_t)(0.25 / step));
    view = look(dem);
    double mean = 0, lowest = 1;
    for (size_t k = 0; k < view.bodies; k++) {
        const double *x = view.body[k].position;
        mean += x[0] / (double)view.bodies;
        lowest = fmin(lowest, x[2] - chute_z(&published, x[0]));
    }
    assert_true(mean > -0.16);  // on its way
    assert_true(lowest > 2e-4); // nothing under the floor
    assert_true(view.contacts > 0);
    dem_free(dem);
}

/* Whether and how deep each sphere touches, by every triangle there is: lists, budgets and the tree miss none. */
static void contacts_agree_with_brute_force(void **state)
{
    (void)state;
    struct dem *dem = release(1, NULL);
    struct trimesh *mesh = NULL;
    struct scree_error error = {0};
    struct chute chute = published;
    uint8_t *partner = NULL;
    size_t touching = 0;
    chute.flatness = 2e-5;
    must(chute_mesh(&chute, &mesh, &partner, &error), &error);
    double step = look(dem).step_s;
    advance(dem, (uint64_t)(0.12 / step)); // the gate is gone
    for (int k = 0; k < 20; k++) {
        advance(dem, 173);
        struct view view = look(dem);
        double deepest[512] = {0};
        assert_true(view.moving <= 512);
        for (size_t c = 0; c < view.contacts; c++)
            if (view.contact[c].b >= VIEW_WALL)
                deepest[view.contact[c].a] = fmax(deepest[view.contact[c].a], view.contact[c].overlap);
        for (size_t i = 0; i < view.moving; i++) {
            double nearest = INFINITY, radius = view.position[i][3];
            for (uint32_t t = 0; t < mesh->triangles; t++) {
                struct nearest at = trimesh_nearest(mesh, t, view.position[i]);
                struct vec3 d = vec3_sub(vec3_load(at.point), vec3_load(view.position[i]));
                nearest = fmin(nearest, sqrt(vec3_dot(d, d)));
            }
            assert_true(fabs(fmax(0, radius - nearest) - deepest[i]) < 1e-12 * radius + 1e-15);
            touching += deepest[i] > 0;
        }
    }
    assert_true(touching > 100);
    trimesh_free(mesh);
    free(partner);
    dem_free(dem);
}

/* The force of the surfaces is what the fragments are short of: F_base + weight = dP/dt at every step, gate gone. */
static void momentum_balances_on_a_mesh(void **state)
{
    (void)state;
    struct dem *dem = release(1, NULL);
    double step = look(dem).step_s, was[3] = {0}, force[3] = {0}, worst = 0, largest = 0, mass = 0;
    advance(dem, (uint64_t)(0.15 / step));
    for (int k = 0; k < 400; k++) {
        struct view view = look(dem);
        double p[3] = {0};
        mass = 0;
        for (size_t b = 0; b < view.bodies; b++) {
            mass += view.body[b].mass;
            for (int a = 0; a < 3; a++)
                p[a] += view.body[b].mass * view.body[b].velocity[a];
        }
        for (int a = 0; a < 3; a++) {
            double expect = step * (mass * view.gravity[a] - 0.5 * (force[a] + view.base_force[a]));
            if (k > 0)
                worst = fmax(worst, fabs(p[a] - was[a] - expect));
            largest = fmax(largest, fabs(p[a]));
            was[a] = p[a];
            force[a] = view.base_force[a];
        }
        advance(dem, 1);
    }
    assert_true(largest > 0 && worst < 1e-13 * largest);
    dem_free(dem);
}

static uint64_t hash_after(int threads, const char *isa, uint64_t slice)
{
    struct dem *dem = release(threads, isa);
    for (uint64_t done = 0; done < 16000; done += slice)
        advance(dem, done + slice > 16000 ? 16000 - done : slice);
    uint64_t hash = dem_hash(dem);
    dem_free(dem);
    return hash;
}

static void threads_instruction_sets_and_slices_do_not_show(void **state)
{
    (void)state;
    uint64_t hash = hash_after(1, NULL, 16000);
    assert_true(hash_after(2, NULL, 16000) == hash);
    assert_true(hash_after(5, NULL, 16000) == hash);
    assert_true(hash_after(1, cpu_isa_name(CPU_V2), 16000) == hash);
    assert_true(hash_after(1, NULL, 977) == hash);
}

static void an_image_goes_on_to_the_bit(void **state)
{
    (void)state;
    struct scree_error error = {0};
    struct fragment_spec m = fragment_igneous;
    m.softening = 1e4;
    struct dem *dem = release(1, NULL), *other = NULL;
    advance(dem, 9001);
    struct dem_image image;
    must(dem_save(dem, &image, &error), &error);
    must(dem_load(&image, &law_hertz_tsuji, &m, NULL, 3, &other, &error), &error);
    dem_image_free(&image);
    assert_true(look(dem).contacts > 5 && dem_hash(dem) == dem_hash(other));
    advance(dem, 5000);
    advance(other, 5000);
    assert_true(dem_hash(dem) == dem_hash(other));
    dem_free(dem);
    dem_free(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flat_of_triangles_is_a_plane),
        cmocka_unit_test(faces_edges_and_corners_count_once),
        cmocka_unit_test(a_bowl_of_pieces_is_smooth),
        cmocka_unit_test(the_chute_is_that_of_equation_1),
        cmocka_unit_test(a_gate_inside_a_grain_is_refused),
        cmocka_unit_test(a_gate_holds_then_lifts),
        cmocka_unit_test(contacts_agree_with_brute_force),
        cmocka_unit_test(momentum_balances_on_a_mesh),
        cmocka_unit_test(threads_instruction_sets_and_slices_do_not_show),
        cmocka_unit_test(an_image_goes_on_to_the_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

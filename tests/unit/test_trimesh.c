/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes: what is refused and how it is named, files in each format, the tree
 * and the nearest point against brute force. */
#include "unit.h"

#include <math.h>
#include <stdio.h>

#include "base/rng.h"
#include "base/vec3.h"
#include "geom/trimesh.h"

static const double tetra_vertex[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const uint32_t tetra_corner[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

static void refused(const double (*vertex)[3], size_t vertices, const uint32_t (*corner)[3], size_t triangles, bool closed,
                    const char *message)
{
    struct trimesh *mesh = NULL;
    struct scree_error error;
    assert_int_equal(trimesh_create(vertex, vertices, corner, triangles, closed, &mesh, &error), SCREE_INVALID);
    if (!strstr(error.message, message))
        fail_msg("\"%s\" instead of \"%s\"", error.message, message);
}

/* Whoever holds a mesh relies on what is refused here. */
static void bad_meshes_are_refused_with_the_triangle(void **state)
{
    (void)state;
    struct trimesh *mesh = NULL;
    struct scree_error error;
    assert_int_equal(trimesh_create(tetra_vertex, 4, tetra_corner, 4, true, &mesh, &error), SCREE_OK);
    struct solid solid = trimesh_solid(mesh);
    assert_true(fabs(solid.volume - 1.0 / 6) < 1e-15);
    for (int a = 0; a < 3; a++) // of a corner tetrahedron: centre 1/4, int x2 = 1/60, about the centre 1/60 - 1/96 each
        assert_true(fabs(solid.centre[a] - 0.25) < 1e-15 && fabs(solid.inertia[a] - 2 * (1.0 / 60 - 1.0 / 96)) < 1e-15 &&
                    fabs(solid.inertia[3 + a] + (1.0 / 120 - 1.0 / 96)) < 1e-15);
    trimesh_free(mesh);
    refused(tetra_vertex, 4, tetra_corner, 3, true, "the mesh is open: triangle ");
    const uint32_t flipped[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 3, 2}, {0, 3, 2}};
    refused(tetra_vertex, 4, flipped, 4, true, "triangle 2 is turned the other way round than its neighbour 0");
    const uint32_t flat[1][3] = {{0, 1, 1}}, far[1][3] = {{0, 1, 9}};
    refused(tetra_vertex, 4, flat, 1, false, "triangle 0 is degenerate");
    refused(tetra_vertex, 4, far, 1, false, "triangle 0 names vertex 9 of 4");
    const double fan_vertex[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}};
    const uint32_t fan[3][3] = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
    refused(fan_vertex, 5, fan, 3, false, "shares its edge");
    const double nan_vertex[3][3] = {{0, 0, 0}, {1, NAN, 0}, {0, 1, 0}};
    const uint32_t one[1][3] = {{0, 1, 2}};
    refused(nan_vertex, 3, one, 1, false, "vertex 1 of the mesh is not a number");
    refused(tetra_vertex, 4, one, 0, false, "no triangle");
}

static const char obj[] = "# a tetrahedron\no it\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nf 1 3 2\nf 1//1 2//1 4//1\n"
                          "f -3 -2 -1\nf 1 4 3\n";

static enum scree_status parse(const char *bytes, size_t size, struct trimesh **mesh, struct scree_error *error)
{
    return trimesh_parse(bytes, size, 1e-3, true, mesh, error);
}

/* The same body out of OBJ, ASCII STL and binary STL. */
static void formats_give_the_same_body(void **state)
{
    (void)state;
    char text[4096] = "solid x\n", binary[84 + 4 * 50] = "solid of four";
    size_t n = strlen(text);
    uint32_t count = 4;
    memcpy(binary + 80, &count, 4);
    for (int t = 0; t < 4; t++) {
        n += (size_t)snprintf(text + n, sizeof text - n, "facet normal 0 0 0\nouter loop\n");
        for (int k = 0; k < 3; k++) {
            const double *v = tetra_vertex[tetra_corner[t][k]];
            n += (size_t)snprintf(text + n, sizeof text - n, "vertex %g %g %g\n", v[0], v[1], v[2]);
            for (int a = 0; a < 3; a++) {
                float x = (float)v[a];
                memcpy(binary + 84 + 50 * t + 12 + 12 * k + 4 * a, &x, 4);
            }
        }
        n += (size_t)snprintf(text + n, sizeof text - n, "endloop\nendfacet\n");
    }
    n += (size_t)snprintf(text + n, sizeof text - n, "endsolid x\n");
    const struct {
        const char *bytes;
        size_t size;
    } files[] = {{obj, sizeof obj - 1}, {text, n}, {binary, sizeof binary}};
    for (int k = 0; k < 3; k++) {
        struct trimesh *mesh = NULL;
        struct scree_error error;
        if (parse(files[k].bytes, files[k].size, &mesh, &error))
            fail_msg("file %d: %s", k, error.message);
        assert_int_equal(mesh->vertices, 4);
        assert_int_equal(mesh->triangles, 4);
        assert_true(fabs(trimesh_solid(mesh).volume - 1e-9 / 6) < 1e-22);
        trimesh_free(mesh);
    }
}

static void bad_files_are_refused_with_the_line(void **state)
{
    (void)state;
    const struct {
        const char *text, *message;
    } files[] = {
        {"", "no triangle"},
        {"hello\n", "line 1 of the mesh: not a statement of an OBJ file"},
        {"v 0 0 0\nv 1 0\n", "line 2 of the mesh: expected three finite numbers"},
        {"v 0 0 0\nv 1 0 nan\n", "line 2 of the mesh: expected three finite numbers"},
        {"v 0 0 0\nv 1e999 0 0\n", "line 2 of the mesh: expected three finite numbers"},
        {"v 0 0 0\nf 1 2 3\n", "line 2 of the mesh: a face names a vertex that is not there"},
        {"v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3 of the mesh: a face needs three vertices"},
        {"v 0 0 0\nf 1 99999999999999999999 3\n", "line 2 of the mesh: a face names a vertex that is not there"},
        {"solid\nvertex 0 0 0\n", "line 2 of the mesh: a facet has three vertices"},
        {"solid\nouter loop\nvertex 0 0 0\nendloop\n", "line 4 of the mesh: a facet has three vertices"},
        {"solid\nouter loop\nvertex 0 0 0\n", "the file ends within a facet"},
        {"solid\nnonsense\n", "line 2 of the mesh: not a statement of an STL file"},
    };
    for (size_t k = 0; k < COUNT(files); k++) {
        struct trimesh *mesh = NULL;
        struct scree_error error;
        assert_int_equal(parse(files[k].text, strlen(files[k].text), &mesh, &error), SCREE_INVALID);
        if (!strstr(error.message, files[k].message))
            fail_msg("file %zu: \"%s\"", k, error.message);
    }
}

/* Every cut and every flipped byte of a good file: refused or read, never a crash (sanitizers look on). */
static void damaged_files_do_no_harm(void **state)
{
    (void)state;
    for (size_t size = 0; size < sizeof obj; size++)
        for (int bit = 0; bit < 8; bit++) {
            char copy[sizeof obj];
            memcpy(copy, obj, sizeof obj);
            copy[size] = (char)(copy[size] ^ (1 << bit));
            struct trimesh *mesh = NULL;
            struct scree_error error;
            if (parse(copy, bit ? sizeof obj - 1 : size, &mesh, &error) == SCREE_OK)
                trimesh_free(mesh);
        }
}

/* A crumpled sheet of triangles. */
static struct trimesh *sheet(struct rng *rng, int n)
{
    double(*vertex)[3] = calloc((size_t)(n + 1) * (size_t)(n + 1), sizeof *vertex);
    uint32_t(*corner)[3] = calloc(2 * (size_t)n * (size_t)n, sizeof *corner);
    size_t v = 0, t = 0;
    for (int j = 0; j <= n; j++)
        for (int i = 0; i <= n; i++, v++) {
            vertex[v][0] = i + rng_uniform(rng, -0.3, 0.3);
            vertex[v][1] = j + rng_uniform(rng, -0.3, 0.3);
            vertex[v][2] = rng_uniform(rng, -0.5, 0.5);
        }
    for (uint32_t j = 0; j < (uint32_t)n; j++)
        for (uint32_t i = 0; i < (uint32_t)n; i++) {
            uint32_t a = j * (uint32_t)(n + 1) + i, b = a + 1, c = a + (uint32_t)n + 1, d = c + 1;
            memcpy(corner[t++], ((uint32_t[3]){a, b, d}), 12);
            memcpy(corner[t++], ((uint32_t[3]){a, d, c}), 12);
        }
    struct trimesh *mesh = NULL;
    struct scree_error error;
    if (trimesh_create((const double(*)[3])vertex, v, (const uint32_t(*)[3])corner, t, false, &mesh, &error))
        fail_msg("%s", error.message);
    free(vertex);
    free(corner);
    return mesh;
}

/* Distance to a triangle by descent over barycentric weights on a fine grid, refined: slow, but another way. */
static double slow_distance(const struct trimesh *mesh, uint32_t t, const double p[3])
{
    struct vec3 a = vec3_load(mesh->vertex[mesh->corner[t][0]]), b = vec3_load(mesh->vertex[mesh->corner[t][1]]),
                c = vec3_load(mesh->vertex[mesh->corner[t][2]]);
    double u0 = 0, v0 = 0, bu = 0, bv = 0, width = 1, best = INFINITY;
    for (int level = 0; level < 60; level++) {
        for (int i = 0; i <= 8; i++)
            for (int j = 0; j <= 8; j++) {
                double u = fmin(1, fmax(0, u0 + width * (i / 8.0))), v = fmin(1 - u, fmax(0, v0 + width * (j / 8.0)));
                struct vec3 x = vec3_add(a, vec3_add(vec3_scale(vec3_sub(b, a), u), vec3_scale(vec3_sub(c, a), v)));
                x = vec3_sub(x, vec3_load(p));
                double d = sqrt(vec3_dot(x, x));
                if (d < best)
                    best = d, bu = u, bv = v;
            }
        width *= 0.75;
        u0 = bu - width / 2;
        v0 = bv - width / 2;
    }
    return best;
}

static void the_tree_and_nearest_points_agree_with_brute_force(void **state)
{
    (void)state;
    struct rng rng = rng_start(5, 1);
    struct trimesh *mesh = sheet(&rng, 12);
    uint32_t found[1024];
    int features = 0;
    for (int k = 0; k < 400; k++) {
        double p[3] = {rng_uniform(&rng, -1, 13), rng_uniform(&rng, -1, 13), rng_uniform(&rng, -1, 1)};
        double radius = rng_uniform(&rng, 0, 2);
        size_t count = trimesh_near(mesh, p, radius, found, 1024), at = 0;
        for (uint32_t t = 0; t < mesh->triangles; t++) {
            struct nearest near = trimesh_nearest(mesh, t, p);
            struct vec3 d = vec3_sub(vec3_load(near.point), vec3_load(p));
            double distance = sqrt(vec3_dot(d, d));
            if (t % 24 == (uint32_t)k % 24) { // no farther than any point tried, and on the triangle
                assert_true(distance <= slow_distance(mesh, t, p) + 1e-12);
                assert_true(slow_distance(mesh, t, near.point) < 1e-3);
            }
            features |= 1 << near.feature;
            while (at < count && found[at] < t)
                at++;
            if (distance <= radius)
                assert_true(at < count && found[at] == t);
        }
    }
    assert_int_equal(features, 127); // face, three edges, three corners were all met
    trimesh_free(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_meshes_are_refused_with_the_triangle),
        cmocka_unit_test(formats_give_the_same_body),
        cmocka_unit_test(bad_files_are_refused_with_the_line),
        cmocka_unit_test(damaged_files_do_no_harm),
        cmocka_unit_test(the_tree_and_nearest_points_agree_with_brute_force),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

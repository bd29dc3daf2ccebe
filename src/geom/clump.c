/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See clump.h. */
#include "geom/clump.h"

#include <math.h>
#include <string.h>

/* A sphere may stick out of its polyhedron by this share of its radius: rounding of tangent spheres. */
#define TANGENT 1e-9

/* ---- principal axes ---- */

/* Jacobi's rotations: a symmetric tensor becomes diagonal, its columns' axes are
 * collected in `axes` (columns). Converges quadratically; 20 sweeps are plenty. */
static void diagonalise(double m[3][3], double axes[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            axes[i][j] = i == j;
    for (int sweep = 0; sweep < 20; sweep++)
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) {
                if (fabs(m[p][q]) <= 1e-16 * (fabs(m[p][p]) + fabs(m[q][q])))
                    continue;
                double t = (m[q][q] - m[p][p]) / (2 * m[p][q]);
                t = (t >= 0 ? 1 : -1) / (fabs(t) + sqrt(t * t + 1));
                double c = 1 / sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < 3; k++) {
                    double kp = m[k][p], kq = m[k][q];
                    m[k][p] = c * kp - s * kq;
                    m[k][q] = s * kp + c * kq;
                }
                for (int k = 0; k < 3; k++) {
                    double pk = m[p][k], qk = m[q][k];
                    m[p][k] = c * pk - s * qk;
                    m[q][k] = s * pk + c * qk;
                    double kp = axes[k][p], kq = axes[k][q];
                    axes[k][p] = c * kp - s * kq;
                    axes[k][q] = s * kp + c * kq;
                }
            }
}

/* The quaternion of a rotation matrix, by its largest component. */
static struct quat quat_of(double m[3][3])
{
    double w2 = 1 + m[0][0] + m[1][1] + m[2][2], x2 = 1 + m[0][0] - m[1][1] - m[2][2], y2 = 1 - m[0][0] + m[1][1] - m[2][2],
           z2 = 1 - m[0][0] - m[1][1] + m[2][2];
    struct quat q;
    if (w2 >= x2 && w2 >= y2 && w2 >= z2)
        q = (struct quat){w2, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
    else if (x2 >= y2 && x2 >= z2)
        q = (struct quat){m[2][1] - m[1][2], x2, m[0][1] + m[1][0], m[0][2] + m[2][0]};
    else if (y2 >= z2)
        q = (struct quat){m[0][2] - m[2][0], m[0][1] + m[1][0], y2, m[1][2] + m[2][1]};
    else
        q = (struct quat){m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], z2};
    return quat_unit(q);
}

static void measure_reach(struct clump *clump)
{
    clump->reach = 0;
    for (size_t k = 0; k < clump->spheres; k++) {
        struct vec3 x = vec3_load(clump->sphere[k]);
        clump->reach = fmax(clump->reach, sqrt(vec3_dot(x, x)) + clump->sphere[k][3]);
    }
}

static enum scree_status check_spheres(const double (*sphere)[4], size_t count, struct scree_error *err)
{
    if (count < 1 || count > CLUMP_SPHERES_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "a clump of %zu spheres: 1 to %d are taken", count, CLUMP_SPHERES_MAX);
    for (size_t k = 0; k < count; k++)
        if (!isfinite(sphere[k][0] + sphere[k][1] + sphere[k][2]) || !(sphere[k][3] > 0 && isfinite(sphere[k][3])))
            return scree_fail(err, SCREE_INVALID, NULL, "sphere %zu of the clump has no place or no radius", k);
    return SCREE_OK;
}

enum scree_status clump_create(const double (*sphere)[4], size_t spheres, double mass, const double centre[3],
                               const double inertia[6], double volume, struct clump *out, struct quat *axes,
                               struct scree_error *err)
{
    enum scree_status status = check_spheres(sphere, spheres, err);
    if (status)
        return status;
    if (!(mass > 0 && isfinite(mass)))
        return scree_fail(err, SCREE_INVALID, NULL, "a clump's mass must be positive, not %.6g kg", mass);
    double m[3][3] = {
        {inertia[0], inertia[3], inertia[4]}, {inertia[3], inertia[1], inertia[5]}, {inertia[4], inertia[5], inertia[2]}};
    double turn[3][3];
    diagonalise(m, turn);
    double largest = fmax(m[0][0], fmax(m[1][1], m[2][2])), sum = m[0][0] + m[1][1] + m[2][2];
    for (int a = 0; a < 3; a++)
        if (!(m[a][a] > 0) || !isfinite(m[a][a]))
            return scree_fail(err, SCREE_INVALID, NULL, "a clump's moments of inertia must be positive: one is %.6g kg m2",
                              m[a][a]);
    if (largest > (sum - largest) * (1 + 1e-9)) // int y2 + z2 <= int x2 + z2 + int x2 + y2
        return scree_fail(err, SCREE_INVALID, NULL,
                          "no body has moments of inertia %.6g, %.6g, %.6g kg m2: one is above the others' sum", m[0][0], m[1][1],
                          m[2][2]);
    double handed = turn[0][0] * (turn[1][1] * turn[2][2] - turn[1][2] * turn[2][1]) -
                    turn[0][1] * (turn[1][0] * turn[2][2] - turn[1][2] * turn[2][0]) +
                    turn[0][2] * (turn[1][0] * turn[2][1] - turn[1][1] * turn[2][0]);
    for (int k = 0; k < 3 && handed < 0; k++)
        turn[k][2] = -turn[k][2];
    struct quat q = quat_of(turn);
    struct turn own = quat_turn(q);
    *out = (struct clump){.mass = mass, .volume = volume, .inertia = {m[0][0], m[1][1], m[2][2]}, .spheres = spheres};
    for (size_t k = 0; k < spheres; k++) {
        vec3_store3(out->sphere[k], turn_in(&own, vec3_sub(vec3_load(sphere[k]), vec3_load(centre))));
        out->sphere[k][3] = sphere[k][3];
    }
    measure_reach(out);
    if (axes)
        *axes = q;
    return SCREE_OK;
}

/* ---- blocks ---- */

enum scree_status clump_block(const double size[3], double radius, double density, struct clump *out, struct scree_error *err)
{
    int count[3];
    double volume = size[0] * size[1] * size[2];
    if (!(radius > 0 && density > 0 && isfinite(volume * density)))
        return scree_fail(err, SCREE_INVALID, NULL, "a block needs a positive size, sphere radius and density");
    for (int a = 0; a < 3; a++) {
        double n = size[a] / (2 * radius);
        if (!(n >= 1 - 1e-6 && n < CLUMP_SPHERES_MAX + 1) || fabs(n - round(n)) > 1e-6)
            return scree_fail(err, SCREE_INVALID, NULL,
                              "spheres of radius %.6g m do not fill a block's edge of %.6g m: %.6g of them stand along it", radius,
                              size[a], n);
        count[a] = (int)round(n);
    }
    *out = (struct clump){.mass = density * volume, .volume = volume};
    for (int a = 0; a < 3; a++) {
        double b = size[(a + 1) % 3], c = size[(a + 2) % 3];
        out->inertia[a] = out->mass / 12 * (b * b + c * c);
    }
    int at[3];
    for (at[2] = 0; at[2] < count[2]; at[2]++)
        for (at[1] = 0; at[1] < count[1]; at[1]++)
            for (at[0] = 0; at[0] < count[0]; at[0]++) {
                int inner = 0;
                for (int a = 0; a < 3; a++)
                    inner += at[a] > 0 && at[a] < count[a] - 1;
                if (inner == 3)
                    continue;
                if (out->spheres == CLUMP_SPHERES_MAX)
                    return scree_fail(err, SCREE_INVALID, NULL, "a block of %d x %d x %d spheres: at most %d are taken", count[0],
                                      count[1], count[2], CLUMP_SPHERES_MAX);
                double *sphere = out->sphere[out->spheres++];
                for (int a = 0; a < 3; a++)
                    sphere[a] = (at[a] - 0.5 * (count[a] - 1)) * (size[a] / count[a]);
                sphere[3] = radius;
            }
    measure_reach(out);
    return SCREE_OK;
}

enum scree_status clump_add_corners(const double size[3], double radius, struct clump *clump, struct scree_error *err)
{
    double shortest = fmin(size[0], fmin(size[1], size[2]));
    if (!(radius > 0 && 2 * radius <= shortest))
        return scree_fail(err, SCREE_INVALID, NULL, "two spheres of radius %.6g m do not stand along a block's edge of %.6g m",
                          radius, shortest);
    if (clump->spheres + 8 > CLUMP_SPHERES_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "a block of %zu spheres and eight corners: at most %d are taken",
                          clump->spheres, CLUMP_SPHERES_MAX);
    for (int k = 0; k < 8; k++) {
        double *sphere = clump->sphere[clump->spheres++];
        for (int a = 0; a < 3; a++)
            sphere[a] = (k >> a & 1 ? 1 : -1) * (0.5 * size[a] - radius);
        sphere[3] = radius;
    }
    measure_reach(clump);
    return SCREE_OK;
}

/* ---- polyhedra ---- */

enum scree_status clump_inscribe(const struct trimesh *mesh, const double (*sphere)[4], size_t spheres, double density,
                                 struct clump *out, struct quat *axes, struct scree_error *err)
{
    enum scree_status status = check_spheres(sphere, spheres, err);
    if (status)
        return status;
    double low[3], high[3], size = 0;
    trimesh_bounds(mesh, low, high);
    for (int a = 0; a < 3; a++)
        size = fmax(size, high[a] - low[a]);
    struct solid solid = trimesh_solid(mesh);
    if (!(solid.volume > 1e-12 * size * size * size))
        return scree_fail(err, SCREE_INVALID, NULL, "the polyhedron has a volume of %.6g m3: its triangles must turn outwards",
                          solid.volume);
    for (size_t t = 0; t < mesh->triangles; t++) {
        struct vec3 a = vec3_load(mesh->vertex[mesh->corner[t][0]]), b = vec3_load(mesh->vertex[mesh->corner[t][1]]),
                    c = vec3_load(mesh->vertex[mesh->corner[t][2]]), n = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
        n = vec3_scale(n, 1 / sqrt(vec3_dot(n, n)));
        for (size_t v = 0; v < mesh->vertices; v++)
            if (vec3_dot(n, vec3_sub(vec3_load(mesh->vertex[v]), a)) > 1e-9 * size)
                return scree_fail(err, SCREE_INVALID, NULL, "the polyhedron is not convex: vertex %zu stands out over triangle %zu",
                                  v, t);
        for (size_t k = 0; k < spheres; k++) {
            double out_by = vec3_dot(n, vec3_sub(vec3_load(sphere[k]), a)) + sphere[k][3];
            if (out_by > TANGENT * sphere[k][3])
                return scree_fail(err, SCREE_INVALID, NULL, "sphere %zu leaves its polyhedron through triangle %zu by %.3g m", k, t,
                                  out_by);
        }
    }
    double inertia[6];
    for (int k = 0; k < 6; k++)
        inertia[k] = density * solid.inertia[k];
    return clump_create(sphere, spheres, density * solid.volume, solid.centre, inertia, solid.volume, out, axes, err);
}

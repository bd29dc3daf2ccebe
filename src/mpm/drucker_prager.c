/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The plain functions of the rheology: see drucker_prager.h. */
#include "mpm/drucker_prager.h"

#include <math.h>
#include <string.h>

#include "mpm/local.h"

static double dimension(bool plane)
{
    return plane ? 2 : 3;
}

double tensor_trace(const double t[TENSOR])
{
    return t[0] + t[1] + t[2];
}

/* t + a I, where I is the identity of the plane or of space. */
static void add_identity(double t[TENSOR], double a, bool plane)
{
    t[0] += a;
    t[1] += plane ? 0 : a;
    t[2] += a;
}

void tensor_deviator(const double t[TENSOR], bool plane, double dev[TENSOR])
{
    double mean = tensor_trace(t) / dimension(plane);
    memmove(dev, t, TENSOR * sizeof *t);
    add_identity(dev, -mean, plane);
}

double tensor_norm(const double t[TENSOR])
{
    return sqrt(0.5 * (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) + t[3] * t[3] + t[4] * t[4] + t[5] * t[5]);
}

/* Eq. A9, written as printed. */
static void fischer_burmeister(const double g[TENSOR], const double l[TENSOR], bool plane, double f[TENSOR])
{
    double d = dimension(plane), trace_g = tensor_trace(g), trace_l = tensor_trace(l);
    double dev_g[TENSOR], dev_l[TENSOR], mix[TENSOR];
    tensor_deviator(g, plane, dev_g);
    tensor_deviator(l, plane, dev_l);
    for (int k = 0; k < TENSOR; k++)
        mix[k] = trace_g * dev_g[k] + trace_l * dev_l[k];
    double square = pow(tensor_norm(g), 2) + pow(tensor_norm(l), 2);
    double root = sqrt(fmax(0, square * square - 2 / d * pow(tensor_norm(mix), 2)));
    double s = sqrt(d * (square + root));
    memset(f, 0, TENSOR * sizeof *f);
    if (s == 0)
        return;
    for (int k = 0; k < TENSOR; k++)
        f[k] = (1 - trace_g / s) * dev_g[k] + (1 - trace_l / s) * dev_l[k];
    add_identity(f, (trace_g + trace_l - s) / d, plane);
}

void drucker_prager_root(const double gamma[TENSOR], const double lambda[TENSOR], double mu, bool plane, double f[TENSOR])
{
    double d = dimension(plane), cone = sqrt(2 / d) * mu; // eq. A3
    double g[TENSOR], l[TENSOR];
    tensor_deviator(gamma, plane, g);
    tensor_deviator(lambda, plane, l);
    double opening = cone * sqrt(2 / d) * tensor_norm(g); // eq. A4: what dilatancy adds to each diagonal part
    for (int k = 0; k < TENSOR; k++)
        g[k] *= cone; // eq. A5
    add_identity(g, tensor_trace(gamma) / d + opening, plane);
    add_identity(l, cone * tensor_trace(lambda) / d, plane);
    fischer_burmeister(g, l, plane, f);
}

void cone_project(const double t[TENSOR], double aperture, bool plane, double nearest[TENSOR])
{
    /* In the orthonormal split of eq. A1 a tensor is (x0, |x1|) = (Tr / sqrt(2d), ||Dev||); the cone is |x1| <= c x0. */
    double d = dimension(plane), x0 = tensor_trace(t) / sqrt(2 * d), dev[TENSOR];
    tensor_deviator(t, plane, dev);
    double x1 = tensor_norm(dev);
    if (x1 <= aperture * x0) {
        memmove(nearest, t, TENSOR * sizeof *t);
        return;
    }
    memset(nearest, 0, TENSOR * sizeof *nearest);
    if (aperture * x1 <= -x0)
        return; // in the polar cone: the tip is nearest
    double along = (x0 + aperture * x1) / (1 + aperture * aperture);
    for (int k = 0; k < TENSOR; k++)
        nearest[k] = x1 > 0 ? aperture * along * dev[k] / x1 : 0;
    add_identity(nearest, along * sqrt(2 / d), plane);
}

/* One rotation in the plane (a, b) that makes m[a][b] zero. */
static void jacobi_rotate(double m[3][3], double q[3][3], int a, int b)
{
    double theta = (m[b][b] - m[a][a]) / (2 * m[a][b]);
    double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    double c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < 3; k++) {
        double u = m[k][a], v = m[k][b];
        m[k][a] = c * u - s * v;
        m[k][b] = s * u + c * v;
    }
    for (int k = 0; k < 3; k++) {
        double u = m[a][k], v = m[b][k];
        m[a][k] = c * u - s * v;
        m[b][k] = s * u + c * v;
        double x = q[k][a], y = q[k][b];
        q[k][a] = c * x - s * y;
        q[k][b] = s * x + c * y;
    }
}

void tensor_eigen(const double t[TENSOR], double q[3][3], double value[3])
{
    enum { SWEEPS = 12 };
    double m[3][3] = {{t[0], t[5], t[4]}, {t[5], t[1], t[3]}, {t[4], t[3], t[2]}};
    double scale = fabs(t[0]) + fabs(t[1]) + fabs(t[2]);
    memcpy(q, (double[3][3]){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 9 * sizeof(double));
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double left = fabs(m[0][1]) + fabs(m[0][2]) + fabs(m[1][2]);
        if (left <= 1e-16 * scale)
            break;
        for (int a = 0; a < 2; a++)
            for (int b = a + 1; b < 3; b++)
                if (fabs(m[a][b]) > 1e-18 * scale)
                    jacobi_rotate(m, q, a, b);
    }
    for (int k = 0; k < 3; k++)
        value[k] = m[k][k];
}

static void unpack(const double t[TENSOR], double m[3][3])
{
    memcpy(m, (double[3][3]){{t[0], t[5], t[4]}, {t[5], t[1], t[3]}, {t[4], t[3], t[2]}}, 9 * sizeof(double));
}

static void rotate(const double t[TENSOR], const double q[3][3], bool transposed, double r[TENSOR])
{
    double m[3][3], half[3][3], full[3][3];
    unpack(t, m);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            half[a][b] = 0;
            for (int k = 0; k < 3; k++)
                half[a][b] += m[a][k] * (transposed ? q[b][k] : q[k][b]);
        }
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            full[a][b] = 0;
            for (int k = 0; k < 3; k++)
                full[a][b] += (transposed ? q[a][k] : q[k][a]) * half[k][b];
        }
    double parts[TENSOR] = {full[0][0],
                            full[1][1],
                            full[2][2],
                            0.5 * (full[1][2] + full[2][1]),
                            0.5 * (full[0][2] + full[2][0]),
                            0.5 * (full[0][1] + full[1][0])};
    memcpy(r, parts, sizeof parts);
}

void tensor_rotate(const double t[TENSOR], const double q[3][3], double r[TENSOR])
{
    rotate(t, q, false, r);
}

void tensor_rotate_back(const double r[TENSOR], const double q[3][3], double t[TENSOR])
{
    rotate(r, q, true, t);
}

enum phase drucker_prager_solve(const double k[TENSOR], const double b[TENSOR], double mu, bool plane, double lambda[TENSOR])
{
    double q[3][3], e[3], r[TENSOR], out[TENSOR], alpha = 0;
    unsigned stalls = 0;
    tensor_eigen(k, q, e);
    tensor_rotate(b, (const double(*)[3])q, r);
    v4 kd = v4_set(e[0], plane ? 1 : e[1], e[2], 1);
    v4 ko = v4_set(0.5 * (kd[1] + kd[2]), 0.5 * (kd[2] + kd[0]), 0.5 * (kd[0] + kd[1]), 1);
    v4 diagonal, off;
    int state = local_solve(local_axes(plane), kd, ko, v4_set(r[0], r[1], r[2], 0), v4_set(r[3], r[4], r[5], 0), mu, 0, &alpha,
                            &diagonal, &off, &stalls);
    for (int a = 0; a < 3; a++) {
        out[a] = diagonal[a];
        out[3 + a] = off[a];
    }
    tensor_rotate_back(out, (const double(*)[3])q, lambda);
    return (enum phase)state;
}

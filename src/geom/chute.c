/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See chute.h. */
#include "geom/chute.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

double chute_z(const struct chute *c, double x)
{
    if (x < 0)
        return c->height - c->drop * c->steepness * x;
    return c->height - c->drop * asinh(c->steepness * x);
}

static double fall(const struct chute *c, double x) // -dz/dx
{
    double s = x < 0 ? 0 : c->steepness * x;
    return c->drop * c->steepness / sqrt(1 + s * s);
}

double chute_slope(const struct chute *c, double x)
{
    return atan(fall(c, x));
}

/* Cosine and sine of the slope, written out: compilers may or may not see sin(atan(f)) as this, and the last bit would be theirs.
 */
struct lean {
    double cosine, sine;
};
static struct lean lean_at(const struct chute *c, double x)
{
    double f = fall(c, x), secant = sqrt(f * f + 1);
    return (struct lean){1 / secant, f / secant};
}

/* Simpson's rule; the integrand sqrt(1 + z'^2) is smooth. */
double chute_arc(const struct chute *c, double x)
{
    enum { PANELS = 200 };
    double sum = 0, h = x / PANELS;
    if (x < 0)
        return x * sqrt(1 + fall(c, 0) * fall(c, 0));
    for (int k = 0; k <= PANELS; k++) {
        double f = fall(c, k * h);
        sum += sqrt(1 + f * f) * (k == 0 || k == PANELS ? 1 : k % 2 ? 4 : 2);
    }
    return sum * h / 3;
}

double chute_height(const struct chute *c, const double point[3])
{
    return (point[2] - chute_z(c, point[0])) * lean_at(c, point[0]).cosine;
}

void chute_accelerator_point(const struct chute *c, double along, double across, double normal, double out[3])
{
    const struct lean lean = lean_at(c, 0);
    out[0] = along * lean.cosine + normal * lean.sine;
    out[1] = across;
    out[2] = c->height - along * lean.sine + normal * lean.cosine;
}

enum { CORNERS = 6 };

/* A corner of the section: top of the guard, top of the side, edge of the floor, and the same on the other side. */
static void section(const struct chute *c, size_t corner, double *across, double *normal)
{
    size_t height = corner < 3 ? 2 - corner : corner - 3; // 0: floor, 1: side, 2: guard
    double half = 0.5 * (height > 0 ? c->width : c->floor), side = 0.5 * (c->width - c->floor) * tan(c->side_rad);
    *across = corner < 3 ? -half : half;
    *normal = (height > 0 ? side : 0) + (height > 1 ? c->guard : 0);
}

/* Where the profile is cut: upslope end, join, then steps whose chords stay within `flatness`. */
static enum scree_status cuts(const struct chute *c, double **out, size_t *count, struct scree_error *err)
{
    size_t room = 0;
    *out = NULL;
    *count = 0;
    for (double x = -c->accelerator * lean_at(c, 0).cosine;;) {
        enum scree_status status = memory_grow((void **)out, &room, *count + 1, sizeof **out, err);
        if (status)
            return status;
        (*out)[(*count)++] = x;
        if (x >= c->run)
            return SCREE_OK;
        if (*count > 100000)
            return scree_fail(err, SCREE_INVALID, NULL, "the chute's curve would need more than 100000 pieces");
        /* A chord of length s under curvature k sags by k s^2 / 8. */
        double s = c->steepness * fmax(x, 0), f = fall(c, x);
        double bend = c->drop * c->steepness * c->steepness * fmax(s, 0.3) / pow(1 + s * s, 1.5) / pow(1 + f * f, 1.5);
        double step = sqrt(8 * c->flatness / bend) / sqrt(1 + f * f);
        x = x < 0 ? 0 : fmin(c->run, x + fmin(step, 0.1 * c->run));
    }
}

enum scree_status chute_mesh(const struct chute *c, struct trimesh **out, uint8_t **is_accelerator, struct scree_error *err)
{
    double *x = NULL;
    size_t count;
    double(*vertex)[3] = NULL;
    uint32_t(*corner)[3] = NULL;
    *is_accelerator = NULL;
    enum scree_status status = cuts(c, &x, &count, err);
    if (status)
        goto out;
    size_t triangles = 2 * (CORNERS - 1) * (count - 1) + 2 * (CORNERS - 2), t = 0;
    vertex = memory_rows(CORNERS * count, sizeof *vertex);
    corner = memory_rows(triangles, sizeof *corner);
    *is_accelerator = memory_rows(triangles, 1);
    if (!vertex || !corner || !*is_accelerator) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a chute of %zu pieces", count);
        goto out;
    }
    for (size_t k = 0; k < count; k++) {
        const struct lean lean = lean_at(c, x[k]);
        for (size_t s = 0; s < CORNERS; s++) {
            double across, normal;
            section(c, s, &across, &normal);
            double *v = vertex[CORNERS * k + s];
            v[0] = x[k] + normal * lean.sine;
            v[1] = across;
            v[2] = chute_z(c, x[k]) + normal * lean.cosine;
        }
    }
    for (size_t k = 0; k + 1 < count; k++)
        for (uint32_t s = 0; s < CORNERS - 1; s++) { // turned so that normals point into the channel
            uint32_t a = (uint32_t)(CORNERS * k) + s, b = a + 1, d = a + CORNERS, e = d + 1;
            (*is_accelerator)[t] = (*is_accelerator)[t + 1] = x[k] < 0;
            memcpy(corner[t++], ((uint32_t[3]){a, d, b}), sizeof *corner);
            memcpy(corner[t++], ((uint32_t[3]){b, d, e}), sizeof *corner);
        }
    for (uint32_t s = 1; s < CORNERS - 1; s++) { // the plates at both ends
        uint32_t last = (uint32_t)(CORNERS * (count - 1));
        (*is_accelerator)[t] = 1;
        memcpy(corner[t++], ((uint32_t[3]){0, s, s + 1}), sizeof *corner);
        memcpy(corner[t++], ((uint32_t[3]){last, last + s + 1, last + s}), sizeof *corner);
    }
    status = trimesh_create((const double(*)[3])vertex, CORNERS * count, (const uint32_t(*)[3])corner, t, false, out, err);
out:
    free(x);
    free(vertex);
    free(corner);
    if (status) {
        free(*is_accelerator);
        *is_accelerator = NULL;
    }
    return status;
}

bool chute_upslope(const struct trimesh *mesh, size_t triangle)
{
    const uint32_t *c = mesh->corner[triangle];
    return mesh->vertex[c[0]][0] + mesh->vertex[c[1]][0] + mesh->vertex[c[2]][0] < 0;
}

enum scree_status chute_gate(const struct chute *c, struct trimesh **out, struct scree_error *err)
{
    uint32_t corner[CORNERS - 2][3];
    double vertex[CORNERS][3];
    for (size_t s = 0; s < CORNERS; s++) {
        double across, normal;
        section(c, s, &across, &normal);
        chute_accelerator_point(c, -c->gate, across, normal, vertex[s]);
    }
    for (uint32_t s = 1; s < CORNERS - 1; s++)
        memcpy(corner[s - 1], ((uint32_t[3]){0, s, s + 1}), sizeof *corner);
    return trimesh_create((const double(*)[3])vertex, CORNERS, (const uint32_t(*)[3])corner, CORNERS - 2, false, out, err);
}

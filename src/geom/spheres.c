/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Spheres glued together. Any number may share any place, so their union is
 * integrated along chords: exactly along z, by the midpoints of a grid across. */
#include <math.h>
#include <stdbool.h>

#include "geom/composite.h"

enum { GRID = 500 }; // chords each way

/* Adds the part of a chord from a to b. */
static void add_chord(double x, double y, double a, double b, double cell, struct moments *m)
{
    double one = cell * (b - a), z = cell * (b * b - a * a) / 2, zz = cell * (b * b * b - a * a * a) / 3;
    const double first[3] = {one * x, one * y, z}, second[6] = {one * x * x, one * y * y, zz, one * x * y, z * x, z * y};
    m->volume += one;
    for (int k = 0; k < 3; k++)
        m->first[k] += first[k];
    for (int k = 0; k < 6; k++)
        m->second[k] += second[k];
}

/* Chords of all spheres over (x, y), from below, each from where those before it ended. */
static void add_line(const double (*sphere)[4], size_t spheres, double x, double y, double cell, struct moments *m)
{
    double from[COMPOSITE_PARTS_MAX], to[COMPOSITE_PARTS_MAX], top = -INFINITY;
    size_t count = 0;
    for (size_t k = 0; k < spheres; k++) {
        const double *s = sphere[k];
        double half2 = s[3] * s[3] - (x - s[0]) * (x - s[0]) - (y - s[1]) * (y - s[1]);
        if (!(half2 > 0))
            continue;
        size_t at = count++;
        for (; at > 0 && from[at - 1] > s[2] - sqrt(half2); at--) {
            from[at] = from[at - 1];
            to[at] = to[at - 1];
        }
        from[at] = s[2] - sqrt(half2);
        to[at] = s[2] + sqrt(half2);
    }
    for (size_t k = 0; k < count; k++) {
        double low = fmax(from[k], top);
        if (to[k] > low)
            add_chord(x, y, low, to[k], cell, m);
        top = fmax(top, to[k]);
    }
}

static enum scree_status check_glued(const double (*sphere)[4], size_t spheres, struct scree_error *err)
{
    bool glued[COMPOSITE_PARTS_MAX] = {true};
    for (size_t round = 1; round < spheres; round++)
        for (size_t a = 0; a < spheres; a++)
            for (size_t b = 0; b < spheres; b++) {
                struct vec3 d = vec3_sub(vec3_load(sphere[a]), vec3_load(sphere[b]));
                double reach = sphere[a][3] + sphere[b][3];
                glued[b] = glued[b] || (glued[a] && vec3_dot(d, d) < reach * reach);
            }
    for (size_t k = 0; k < spheres; k++)
        if (!glued[k])
            return scree_fail(err, SCREE_INVALID, NULL, "sphere %zu of the body meets none of the others", k);
    return SCREE_OK;
}

enum scree_status composite_spheres(const double (*sphere)[4], size_t spheres, double density, struct composite *out,
                                    struct scree_error *err)
{
    struct moments m = {0};
    struct vec3 centre;
    struct quat axes;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    if (spheres < 1 || spheres > COMPOSITE_PARTS_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "a body of %zu spheres: 1 to %d are taken", spheres, COMPOSITE_PARTS_MAX);
    enum scree_status status = check_glued(sphere, spheres, err);
    if (status)
        return status;
    for (size_t k = 0; k < spheres; k++)
        for (int i = 0; i < 2; i++) {
            low[i] = fmin(low[i], sphere[k][i] - sphere[k][3]);
            high[i] = fmax(high[i], sphere[k][i] + sphere[k][3]);
        }
    const double step[2] = {(high[0] - low[0]) / GRID, (high[1] - low[1]) / GRID};
    for (int i = 0; i < GRID; i++)
        for (int k = 0; k < GRID; k++)
            add_line(sphere, spheres, low[0] + (i + 0.5) * step[0], low[1] + (k + 0.5) * step[1], step[0] * step[1], &m);
    *out = (struct composite){.parts = spheres};
    if ((status = composite_weigh(&m, density, out, &centre, &axes, err)))
        return status;
    const struct turn own = quat_turn(axes);
    for (size_t k = 0; k < spheres; k++) {
        struct vec3 x = turn_in(&own, vec3_sub(vec3_load(sphere[k]), centre));
        out->part[k] = (struct composite_part){.vertices = 1, .radius = sphere[k][3]};
        vec3_store3(out->part[k].vertex[0], x);
        out->reach = fmax(out->reach, sqrt(vec3_dot(x, x)) + sphere[k][3]);
    }
    return SCREE_OK;
}

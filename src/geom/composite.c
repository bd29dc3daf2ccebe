/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Composites: |A u B u ...| = sum over subsets of (-1)^(n + 1) |what they share|,
 * and the same for every integral over the body, so that second moments are as
 * exact as the volume. What convex parts share is convex, and known by its planes. */
#include "geom/composite.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "geom/clump.h"

static void add_moments(struct moments *sum, const struct moments *m, double sign)
{
    sum->volume += sign * m->volume;
    for (int k = 0; k < 3; k++)
        sum->first[k] += sign * m->first[k];
    for (int k = 0; k < 6; k++)
        sum->second[k] += sign * m->second[k];
}

/* Adds what `shared` gives, and every deeper intersection with parts from `from` on. */
static enum scree_status add_shared(const struct polyhedron *part, size_t parts, size_t from, const struct polyhedron *shared,
                                    double sign, struct moments *sum, struct scree_error *err)
{
    struct moments m;
    polyhedron_moments(shared, &m);
    add_moments(sum, &m, sign);
    for (size_t k = from; k < parts; k++) {
        struct polyhedron deeper;
        enum scree_status status = polyhedron_intersect(shared, &part[k], &deeper, err);
        if (!status && deeper.vertices > 0)
            status = add_shared(part, parts, k + 1, &deeper, -sign, sum, err);
        if (status)
            return status;
    }
    return SCREE_OK;
}

/* Refuses parts that share no volume with those that chains of shared volume join to part 0. */
static enum scree_status check_joined(const struct polyhedron *part, size_t parts, struct scree_error *err)
{
    bool joined[COMPOSITE_PARTS_MAX] = {true};
    for (size_t round = 1; round < parts; round++)
        for (size_t a = 0; a < parts; a++)
            for (size_t b = 0; b < parts; b++) {
                struct polyhedron both;
                if (!joined[a] || joined[b])
                    continue;
                enum scree_status status = polyhedron_intersect(&part[a], &part[b], &both, err);
                if (status)
                    return status;
                joined[b] = both.vertices > 0;
            }
    for (size_t k = 0; k < parts; k++)
        if (!joined[k])
            return scree_fail(err, SCREE_INVALID, NULL, "part %zu of the body shares no volume with the others", k);
    return SCREE_OK;
}

/* The axes come from the code that clumps have for it, which wants a sphere to carry along. */
enum scree_status composite_weigh(const struct moments *m, double density, struct composite *out, struct vec3 *centre,
                                  struct quat *axes, struct scree_error *err)
{
    double c[3], s[6];
    if (!(m->volume > 0))
        return scree_fail(err, SCREE_INVALID, NULL, "the body has no volume");
    for (int k = 0; k < 3; k++)
        c[k] = m->first[k] / m->volume;
    for (int k = 0; k < 3; k++)
        s[k] = m->second[k] - m->volume * c[k] * c[k];
    s[3] = m->second[3] - m->volume * c[0] * c[1];
    s[4] = m->second[4] - m->volume * c[0] * c[2];
    s[5] = m->second[5] - m->volume * c[1] * c[2];
    const double inertia[6] = {density * (s[1] + s[2]), density * (s[0] + s[2]), density * (s[0] + s[1]),
                               -density * s[3],         -density * s[4],         -density * s[5]};
    const double carried[1][4] = {{c[0], c[1], c[2], 1}};
    struct clump clump;
    enum scree_status status = clump_create(carried, 1, density * m->volume, c, inertia, m->volume, &clump, axes, err);
    if (status)
        return status;
    out->mass = clump.mass;
    out->volume = m->volume;
    for (int k = 0; k < 3; k++)
        out->inertia[k] = clump.inertia[k];
    *centre = vec3_load(c);
    return SCREE_OK;
}

/* Vertices and faces of a core, in the axes of the body. */
static void keep_core(const struct polyhedron *core, const struct turn *own, struct vec3 centre, double crust,
                      struct composite_part *out)
{
    uint8_t corner[POLYHEDRON_VERTICES_MAX];
    *out = (struct composite_part){.vertices = core->vertices, .radius = crust};
    for (size_t v = 0; v < core->vertices; v++)
        vec3_store3(out->vertex[v], turn_in(own, vec3_sub(vec3_load(core->vertex[v]), centre)));
    for (size_t k = 0; k < core->faces; k++) {
        size_t count = polyhedron_face(core, k, corner), at = out->first[out->faces];
        if (count < 3 || at + count > COMPOSITE_LOOP_MAX)
            continue;
        memcpy(out->loop + at, corner, count);
        vec3_store3(out->normal[out->faces++], turn_in(own, vec3_load(core->plane[k])));
        out->first[out->faces] = (uint16_t)(at + count);
    }
}

enum scree_status composite_create(const struct polyhedron *part, size_t parts, double density, double crust, struct composite *out,
                                   struct quat *axes, struct scree_error *err)
{
    if (parts < 1 || parts > COMPOSITE_PARTS_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "a body of %zu parts: 1 to %d are taken", parts, COMPOSITE_PARTS_MAX);
    if (!(density > 0 && isfinite(density) && crust >= 0 && isfinite(crust)))
        return scree_fail(err, SCREE_INVALID, NULL, "a body of density %g kg/m3 under a crust of %g m", density, crust);
    struct moments sum = {0};
    struct vec3 centre;
    struct quat q;
    enum scree_status status = check_joined(part, parts, err);
    for (size_t k = 0; k < parts && !status; k++)
        status = add_shared(part, parts, k + 1, &part[k], 1, &sum, err);
    *out = (struct composite){.parts = parts};
    if (status || (status = composite_weigh(&sum, density, out, &centre, &q, err)))
        return status;
    struct turn own = quat_turn(q);
    for (size_t k = 0; k < parts; k++) {
        struct polyhedron core;
        if ((status = polyhedron_shrink(&part[k], crust, &core, err)))
            return status;
        keep_core(&core, &own, centre, crust, &out->part[k]);
        for (size_t v = 0; v < core.vertices; v++) {
            struct vec3 x = vec3_load(out->part[k].vertex[v]);
            out->reach = fmax(out->reach, sqrt(vec3_dot(x, x)) + crust);
        }
    }
    if (axes)
        *axes = q;
    return SCREE_OK;
}

enum scree_status composite_cross(double length, double width, double thickness, double density, double crust,
                                  struct composite *out, struct scree_error *err)
{
    struct polyhedron arm[2];
    enum scree_status status = polyhedron_box((const double[3]){length, width, thickness}, &arm[0], err);
    if (!status)
        status = polyhedron_box((const double[3]){width, length, thickness}, &arm[1], err);
    return status ? status : composite_create(arm, 2, density, crust, out, NULL, err);
}

enum scree_status composite_tetrapod(double leg, double radius, double density, double crust, struct composite *out,
                                     struct scree_error *err)
{
    static const double towards[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    struct polyhedron prism, legs[4];
    enum scree_status status = polyhedron_prism(6, radius, leg, &prism, err);
    if (status)
        return status;
    for (int k = 0; k < 4; k++) { // the turn of z onto u: q = (1 + u_z, z x u), made a unit
        struct vec3 u = vec3_scale(vec3_load(towards[k]), 1 / sqrt(3));
        struct quat q = quat_unit((struct quat){1 + u.z, -u.y, u.x, 0});
        polyhedron_place(&prism, q, vec3_scale(u, 0.5 * leg), &legs[k]);
    }
    return composite_create(legs, 4, density, crust, out, NULL, err);
}

enum scree_status composite_sphere(double radius, double density, struct composite *out, struct scree_error *err)
{
    if (!(radius > 0 && density > 0 && isfinite(radius) && isfinite(density)))
        return scree_fail(err, SCREE_INVALID, NULL, "a sphere of radius %g m and density %g kg/m3", radius, density);
    double volume = 4 * M_PI / 3 * radius * radius * radius, inertia = 0.4 * density * volume * radius * radius;
    *out = (struct composite){
        .mass = density * volume, .volume = volume, .inertia = {inertia, inertia, inertia}, .reach = radius, .parts = 1};
    out->part[0] = (struct composite_part){.vertices = 1, .radius = radius};
    return SCREE_OK;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See profiles.h. */
#include "measure/profiles.h"

#include <math.h>
#include <string.h>

static bool inside(const double region[2], double y)
{
    return y >= region[0] && y < region[1];
}

void profiles_add_view(const struct coarse_grid *grid, const double region[2], const struct view *view, const uint32_t *root,
                       double *sums)
{
    double *at = sums + PROFILES_HEAD;
    uint32_t rows = (uint32_t)(view->moving + view->fixed);
    sums[PROFILES_SAMPLES] += 1;
    for (uint32_t i = 0; i < rows; i++) {
        const double *x = view->position[i], *u = view->velocity[i];
        if (!inside(region, x[1]))
            continue;
        double volume = 4.0 / 3.0 * M_PI * x[3] * x[3] * x[3];
        const double kinematic[] = {volume, volume * u[0], volume * u[1], volume * u[2],
                                    volume * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2])};
        const double joined[] = {1, root[i] == root[rows]};
        if (i < view->moving)
            coarse_add(grid, x[2], true, kinematic, 5, at + PROFILES_VOLUME, PROFILES_SUMS);
        coarse_add(grid, x[2], false, joined, 2, at + PROFILES_ALL, PROFILES_SUMS);
    }
}

void profiles_add_formations(const struct coarse_grid *grid, const double region[2], const struct view_formation *formations,
                             size_t count, double *sums)
{
    for (size_t k = 0; k < count; k++) {
        const struct view_formation *f = &formations[k];
        const double *t = f->tangential;
        if (!inside(region, f->place[1]) || (f->b >= VIEW_WALL && !f->fixed)) // side walls are no particles
            continue;
        const double values[] = {1, f->approach * f->approach, t[0] * t[0] + t[1] * t[1] + t[2] * t[2]};
        coarse_add(grid, f->place[2], false, values, 3, sums + PROFILES_HEAD + PROFILES_IMPACTS, PROFILES_SUMS);
    }
}

static double ratio(double over, double under)
{
    return under > 0 ? over / under : 0;
}

void profiles_of(const struct coarse_grid *grid, const double *sums, struct profile *out)
{
    for (size_t k = 0; k < grid->count; k++) {
        const double *s = sums + PROFILES_HEAD + k * PROFILES_SUMS;
        struct profile *p = &out[k];
        double speed2 = 0;
        p->z = coarse_height(grid, k);
        p->fraction = ratio(s[PROFILES_VOLUME], sums[PROFILES_SAMPLES]);
        for (int a = 0; a < 3; a++) {
            p->velocity[a] = ratio(s[PROFILES_VX + a], s[PROFILES_VOLUME]);
            speed2 += p->velocity[a] * p->velocity[a];
        }
        p->temperature = fmax(0, (ratio(s[PROFILES_SPEED2], s[PROFILES_VOLUME]) - speed2) / 3);
        p->impacts = ratio(s[PROFILES_IMPACTS], sums[PROFILES_TIME]);
        p->normal2 = ratio(s[PROFILES_NORMAL2], s[PROFILES_IMPACTS]);
        p->tangential2 = ratio(s[PROFILES_TANGENTIAL2], s[PROFILES_IMPACTS]);
        p->joined = ratio(s[PROFILES_JOINED], s[PROFILES_ALL]);
    }
}

double profiles_at(const struct coarse_grid *grid, const struct profile *profile, size_t offset, double z)
{
    double place = fmin(fmax((z - grid->first) / grid->step, 0), (double)(grid->count - 1));
    size_t k = (size_t)fmin(place, (double)(grid->count - 2));
    double low, high;
    memcpy(&low, (const char *)&profile[k] + offset, sizeof low);
    memcpy(&high, (const char *)&profile[k + 1] + offset, sizeof high);
    return low + (place - (double)k) * (high - low);
}

/* Where phi falls to half its value at mid-depth, from above; linear between heights. */
static double half_height(const struct coarse_grid *grid, const struct profile *p, double middle)
{
    double half = 0.5 * profiles_at(grid, p, offsetof(struct profile, fraction), middle);
    for (size_t k = grid->count - 1; k > 0; k--)
        if (p[k].fraction <= half && p[k - 1].fraction > half)
            return p[k].z - grid->step * (half - p[k].fraction) / (p[k - 1].fraction - p[k].fraction);
    return p[0].z;
}

/* Slope of u_x at height k, 1/s. */
static double slope(const struct coarse_grid *grid, const struct profile *p, size_t k)
{
    size_t low = k > 0 ? k - 1 : k, high = k + 1 < grid->count ? k + 1 : k;
    return (p[high].velocity[0] - p[low].velocity[0]) / (grid->step * (double)(high - low));
}

void profiles_bulk(const struct coarse_grid *grid, const struct profile *p, double base_z, double density, double gravity_normal,
                   struct profile_bulk *out)
{
    double mass = 0, moment = 0, depth = 0, shear_t = 0, shear2 = 0;
    *out = (struct profile_bulk){0};
    for (size_t k = 0; k < grid->count; k++) {
        mass += p[k].fraction * grid->step;
        moment += p[k].fraction * p[k].z * grid->step;
    }
    out->pressure = density * gravity_normal * mass;
    out->h1 = mass > 0 ? 2 * (moment / mass - base_z) : 0;
    if (!(out->h1 > grid->step) || grid->count < 2)
        return;
    double middle = base_z + 0.5 * out->h1;
    out->h2 = half_height(grid, p, middle) - base_z;
    for (size_t k = 0; k < grid->count; k++) {
        if (p[k].z <= base_z || p[k].z >= base_z + out->h1)
            continue;
        double rate = fabs(slope(grid, p, k)) * grid->diameter;
        depth += grid->step;
        out->fraction += p[k].fraction * grid->step;
        out->velocity += p[k].velocity[0] * grid->step;
        out->temperature += p[k].temperature * grid->step;
        shear_t += sqrt(p[k].temperature) * rate;
        shear2 += rate * rate;
    }
    out->fraction /= depth;
    out->velocity /= depth;
    out->temperature /= depth;
    out->shear = shear2 > 0 ? shear_t / shear2 : 0;
    if (gravity_normal > 0)
        out->inertial = 2.5 * out->velocity * grid->diameter / (out->h1 * sqrt(out->fraction * gravity_normal * out->h1));
    size_t k = (size_t)fmin(fmax(round((middle - grid->first) / grid->step), 0), (double)(grid->count - 1));
    double above = 0.5 * p[k].fraction * grid->step; // trapezoid: what weighs on height k
    for (size_t j = k + 1; j < grid->count; j++)
        above += p[j].fraction * grid->step;
    if (above > 0 && gravity_normal > 0)
        out->local = fabs(slope(grid, p, k)) * grid->diameter * sqrt(1 / (gravity_normal * above));
}

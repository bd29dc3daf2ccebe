/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See deposit.h. Lines are found between nodes by linear interpolation. */
#include "measure/deposit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/line.h"

static const struct scree_column columns[DEPOSIT_COLUMNS] = {
    {"since_gate", "s"},      {"run_out", "m"},          {"front_speed", "m/s"}, {"furthest", "m"},         {"height_back", "m"},
    {"fastest", "m/s"},       {"flowing_share", "1"},    {"inertial_q30", "1"},  {"inertial_q50", "1"},     {"inertial_q70", "1"},
    {"surface_volume", "m3"}, {"overfull_volume", "m3"}, {"kinetic", "J"},       {"potential", "J"},        {"inclination", "deg"},
    {"surface_angle", "deg"}, {"sweeps_per_step", "1"},  {"residual_mean", "1"}, {"residual_largest", "1"},
};
const struct scree_stream deposit_stream = {
    "deposit", "front, height, speed, inertial numbers, volume and slope of a collapse, and how well the law was solved", columns,
    DEPOSIT_COLUMNS, false};

static const struct scree_column surface_columns[SURFACE_COLUMNS] = {
    {"x", "m"}, {"surface", "m"}, {"static", "m"}, {"speed", "m/s"}};
const struct scree_stream surface_stream = {
    "surface", "heights of the free surface and of the line below which nothing flows, at the side wall, a chunk an instant",
    surface_columns, SURFACE_COLUMNS, true};

enum scree_status deposit_lines_start(struct deposit_lines *lines, const struct continuum_view *view, struct scree_error *err)
{
    lines->layers = (size_t)continuum_layers(view, 0);
    lines->surface = memory_rows(lines->layers, sizeof *lines->surface);
    lines->still = memory_rows(lines->layers, sizeof *lines->still);
    lines->inertial = memory_rows(view->nodes, sizeof *lines->inertial);
    if (lines->surface && lines->still && lines->inertial)
        return SCREE_OK;
    deposit_lines_free(lines);
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to measure %zu nodes", view->nodes);
}

void deposit_lines_free(struct deposit_lines *lines)
{
    free(lines->surface);
    free(lines->still);
    free(lines->inertial);
    memset(lines, 0, sizeof *lines);
}

static double speed_of(const double u[4])
{
    return sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
}

/* Height at which a quantity known at nodes falls through `level`, between layers z and z + 1. */
static double crossing(double below, double above, double level, int z, double spacing)
{
    return (z + (below - level) / (below - above)) * spacing;
}

/* Topmost place where phi falls through 0.5. */
static double surface_at(const struct continuum_view *view, int x, int y)
{
    for (int z = view->cells[2] - 1; z >= 0; z--) {
        double below = view->fraction[continuum_node(view, x, y, z)], above = view->fraction[continuum_node(view, x, y, z + 1)];
        if (below > 0.5 && above <= 0.5)
            return crossing(below, above, 0.5, z, view->spacing[2]);
    }
    return view->fraction[continuum_node(view, x, y, view->cells[2])] > 0.5 ? view->length[2] : 0;
}

/* Lowest place where the speed rises through the threshold, at most the surface. */
static double still_at(const struct continuum_view *view, int x, int y, double surface)
{
    double below = speed_of(view->node_velocity[continuum_node(view, x, y, 0)]);
    if (below >= DEPOSIT_REST)
        return 0;
    for (int z = 0; z < view->cells[2] && z * view->spacing[2] < surface; z++) {
        double above = speed_of(view->node_velocity[continuum_node(view, x, y, z + 1)]);
        if (above >= DEPOSIT_REST)
            return fmin(surface, crossing(below, above, DEPOSIT_REST, z, view->spacing[2]));
        below = above;
    }
    return surface;
}

void deposit_trace(const struct continuum_view *view, int layer_y, struct deposit_lines *lines)
{
    for (int x = 0; x < (int)lines->layers; x++) {
        lines->surface[x] = surface_at(view, x, layer_y);
        lines->still[x] = still_at(view, x, layer_y, lines->surface[x]);
    }
}

/* From the gate outwards while the deposit is deep enough; the end is found between nodes. */
static double run_out(const struct continuum_view *view, const struct deposit_site *site, const struct deposit_lines *lines)
{
    double level = site->bed + DEPOSIT_THRESHOLD, end = 0;
    for (size_t x = 0; x + 1 < lines->layers; x++) {
        double here = (double)x * view->spacing[0], a = lines->surface[x], b = lines->surface[x + 1];
        if (here + view->spacing[0] <= site->gate)
            continue;
        if (a <= level)
            break;
        end = here + (b > level ? 1 : (a - level) / (a - b)) * view->spacing[0] - site->gate;
        if (b <= level)
            break;
    }
    return fmax(end, 0);
}

static void look_at_points(const struct continuum_view *view, const struct deposit_site *site, struct deposit *out)
{
    double flowing = 0;
    for (size_t p = 0; p < view->points; p++) {
        const double *x = view->position[p], speed = speed_of(view->velocity[p]);
        out->fastest = fmax(out->fastest, speed);
        flowing += speed >= DEPOSIT_REST ? x[3] : 0;
        if (x[2] > site->bed + DEPOSIT_THRESHOLD) // the bed itself stirs by less
            out->furthest = fmax(out->furthest, x[0]);
    }
    out->flowing = flowing / view->volume;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Quantiles of I over nodes that are dense, bear pressure and flow. */
static void look_at_nodes(const struct continuum_view *view, struct deposit_lines *lines, struct deposit *out)
{
    static const double shares[3] = {0.3, 0.5, 0.7};
    size_t count = 0;
    for (size_t n = 0; n < view->nodes; n++) {
        const double *l = view->stress[n];
        if (view->fraction[n] > 0.5 && l[0] + l[1] + l[2] > 0 && l[6] >= DEPOSIT_INERTIAL)
            lines->inertial[count++] = l[6];
        if (view->fraction[n] > 1)
            out->overfull += view->node_velocity[n][3] * (1 - 1 / view->fraction[n]);
    }
    qsort(lines->inertial, count, sizeof *lines->inertial, ascending);
    for (int k = 0; k < 3; k++)
        out->inertial[k] = count ? lines->inertial[(size_t)(shares[k] * (double)(count - 1) + 0.5)] : 0;
}

/* Trapezoids over the surface, layer by layer across the channel. */
static double volume_under(const struct continuum_view *view)
{
    double sum = 0;
    int along = continuum_layers(view, 0), across = continuum_layers(view, 1);
    for (int x = 0; x < along; x++)
        for (int y = 0; y < across; y++) {
            double weight = along > 1 && (x == 0 || x == along - 1) ? 0.5 : 1;
            if (across > 1 && (y == 0 || y == across - 1))
                weight *= 0.5;
            sum += weight * surface_at(view, x, y);
        }
    return sum * view->spacing[0] * (view->plane ? view->length[1] : view->spacing[1]);
}

/* Slope of a line through the surface over the middle of the box (seed 002, section 2.4: 0.3 to 0.7 of its length), rad. */
static double slope_of(const struct continuum_view *view, const struct deposit_lines *lines)
{
    struct line line = {0};
    for (size_t k = 0; k < lines->layers; k++) {
        double x = (double)k * view->spacing[0], z = lines->surface[k];
        if (x < 0.3 * view->length[0] || x > 0.7 * view->length[0])
            continue;
        line_add(&line, 1, x, z);
    }
    return atan(line_slope(&line));
}

void deposit_measure(const struct continuum_view *view, const struct deposit_site *site, struct deposit_lines *lines,
                     struct deposit *out)
{
    *out = (struct deposit){.time_s = view->time_s - site->start, .kinetic = view->kinetic, .potential = view->potential};
    deposit_trace(view, 0, lines);
    out->run_out = run_out(view, site, lines);
    out->height_back = fmax(lines->surface[0] - site->bed, 0);
    out->surface_volume = volume_under(view);
    look_at_points(view, site, out);
    look_at_nodes(view, lines, out);
    out->inclination = atan2(view->gravity[0], -view->gravity[2]) * 180 / M_PI;
    out->surface_angle = out->inclination - slope_of(view, lines) * 180 / M_PI;
    out->residual_mean = view->residual_mean;
    out->residual_largest = view->residual_largest;
}

void deposit_surface(const struct continuum_view *view, const struct deposit_lines *lines, double (*rows)[SURFACE_COLUMNS])
{
    for (size_t x = 0; x < lines->layers; x++) {
        int z = (int)(lines->surface[x] / view->spacing[2]); // the node under the surface
        rows[x][0] = (double)x * view->spacing[0];
        rows[x][1] = lines->surface[x];
        rows[x][2] = lines->still[x];
        rows[x][3] = speed_of(view->node_velocity[continuum_node(view, (int)x, 0, z)]);
    }
}

void deposit_row(const struct deposit *d, double row[DEPOSIT_COLUMNS])
{
    const double values[DEPOSIT_COLUMNS] = {d->time_s,         d->run_out,  d->front_speed,   d->furthest,        d->height_back,
                                            d->fastest,        d->flowing,  d->inertial[0],   d->inertial[1],     d->inertial[2],
                                            d->surface_volume, d->overfull, d->kinetic,       d->potential,       d->inclination,
                                            d->surface_angle,  d->sweeps,   d->residual_mean, d->residual_largest};
    memcpy(row, values, sizeof values);
}

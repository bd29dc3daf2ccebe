/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the world shows: points with the velocities that the grid gives them, and
 * the grid's own fields without its ghosts. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "mpm/state.h"

static enum scree_status make_arrays(struct mpm *mpm, size_t nodes, struct scree_error *err)
{
    if (mpm->view_velocity)
        return SCREE_OK;
    mpm->view_fraction = memory_rows(nodes, sizeof *mpm->view_fraction);
    mpm->view_node_velocity = memory_rows(nodes, sizeof *mpm->view_node_velocity);
    mpm->view_stress = memory_rows(nodes, sizeof *mpm->view_stress);
    mpm->view_velocity = memory_rows(mpm->points, sizeof *mpm->view_velocity);
    if (mpm->view_fraction && mpm->view_node_velocity && mpm->view_stress && mpm->view_velocity)
        return SCREE_OK;
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to show %zu points and %zu nodes", mpm->points, nodes);
}

/* Corner t of a cell deposited volume and momentum: summed over a node's cells they are its mass and momentum. */
static void show_node(struct mpm *mpm, const int place[3], size_t at)
{
    const struct grid *g = &mpm->grid;
    double volume = 0, momentum[3] = {0, 0, 0};
    for (int k = 0; k < CORNERS; k++) {
        int s[3] = {k >> 2, k >> 1 & 1, k & 1}, c[3];
        bool inside = !(g->flat[0] && s[0]) && !(g->flat[1] && s[1]);
        for (int a = 0; a < 3; a++) {
            c[a] = place[a] - s[a];
            inside &= c[a] >= 0 && c[a] < g->cells[a];
        }
        if (!inside)
            continue;
        size_t cell = grid_cell(g, c[0], c[1], c[2]);
        const double *m = mpm->moment[cell];
        for (int i = s[0]; i <= s[0] + 1; i++)
            for (int j = s[1]; j <= s[1] + 1; j++)
                for (int l = s[2]; l <= s[2] + 1; l++)
                    volume += m[9 * i + 3 * j + l];
        for (int a = 0; a < 3; a++)
            momentum[a] += mpm->momentum[cell][3 * k + a];
    }
    size_t n = grid_node(g, place[0], place[1], place[2]);
    double room = rigid_room(mpm, place);
    mpm->view_fraction[at] = room > 1e-9 * g->cell_volume ? volume / room : 0;
    for (int a = 0; a < 3; a++)
        mpm->view_node_velocity[at][a] = volume > 0 ? momentum[a] / volume : 0;
    mpm->view_node_velocity[at][3] = volume;
    memcpy(mpm->view_stress[at], mpm->stress[n], sizeof *mpm->view_stress);
    mpm->view_stress[at][6] = mpm->stress[n][7];
    mpm->view_stress[at][7] = mpm->friction[n];
}

/* A point's velocity from the momenta that points have left on the nodes. */
static void show_points(struct mpm *mpm)
{
    const struct grid *g = &mpm->grid;
    int layers[3] = {grid_layers(g, 0), grid_layers(g, 1), grid_layers(g, 2)};
    for (size_t p = 0; p < mpm->points; p++) {
        const double *x = mpm->position[p];
        int cell[3];
        double n[3][2], u[3] = {0, 0, 0};
        for (int a = 0; a < 3; a++) {
            cell[a] = grid_cell_along(g, a, x[a]);
            n[a][1] = x[a] * g->inverse[a] - cell[a];
            n[a][0] = 1 - n[a][1];
        }
        for (int k = 0; k < CORNERS; k++) {
            int c[3] = {k >> 2, k >> 1 & 1, k & 1};
            if ((g->flat[0] && c[0]) || (g->flat[1] && c[1]))
                continue;
            double weight = n[0][c[0]] * n[1][c[1]] * n[2][c[2]];
            size_t at = ((size_t)(cell[0] + c[0]) * (size_t)layers[1] + (size_t)(cell[1] + c[1])) * (size_t)layers[2] +
                        (size_t)(cell[2] + c[2]);
            for (int a = 0; a < 3; a++)
                u[a] += weight * mpm->view_node_velocity[at][a];
        }
        memcpy(mpm->view_velocity[p], u, sizeof u);
    }
}

static void show_sums(const struct mpm *mpm, struct continuum_view *view)
{
    for (size_t n = 0; n < view->nodes; n++) {
        const double *u = view->node_velocity[n];
        view->kinetic += 0.5 * mpm->density * u[3] * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    }
    for (size_t p = 0; p < mpm->points; p++) {
        const double *x = mpm->position[p];
        view->potential -= mpm->density * x[3] * (x[0] * mpm->gravity[0] + x[1] * mpm->gravity[1] + x[2] * mpm->gravity[2]);
    }
}

enum scree_status mpm_view(struct mpm *mpm, struct continuum_view *view, struct scree_error *err)
{
    const struct grid *g = &mpm->grid;
    size_t nodes = (size_t)grid_layers(g, 0) * (size_t)grid_layers(g, 1) * (size_t)grid_layers(g, 2), at = 0;
    enum scree_status status = make_arrays(mpm, nodes, err);
    if (status)
        return status;
    for (int x = 0; x < grid_layers(g, 0); x++)
        for (int y = 0; y < grid_layers(g, 1); y++)
            for (int z = 0; z < grid_layers(g, 2); z++)
                show_node(mpm, (int[3]){x, y, z}, at++);
    show_points(mpm);
    *view = (struct continuum_view){.time_s = mpm_time(mpm),
                                    .step_s = mpm->step_s,
                                    .step = mpm->step,
                                    .density = mpm->density,
                                    .plane = g->plane,
                                    .endless = g->flat[0],
                                    .points = mpm->points,
                                    .id = mpm->id,
                                    .position = (const double(*)[4])mpm->position,
                                    .velocity = (const double(*)[4])mpm->view_velocity,
                                    .nodes = nodes,
                                    .fraction = mpm->view_fraction,
                                    .node_velocity = (const double(*)[4])mpm->view_node_velocity,
                                    .stress = (const double(*)[8])mpm->view_stress,
                                    .volume = mpm->total_volume,
                                    .rows = mpm->report.rows,
                                    .sweeps = mpm->report.sweeps_total,
                                    .unconverged = mpm->report.unconverged,
                                    .residual_mean = mpm->report.residual.mean,
                                    .residual_largest = mpm->report.residual.largest};
    memcpy(view->gravity, mpm->gravity, sizeof view->gravity);
    memcpy(view->length, g->length, sizeof view->length);
    memcpy(view->spacing, g->spacing, sizeof view->spacing);
    memcpy(view->cells, g->cells, sizeof view->cells);
    memcpy(view->base_force, mpm->base_last, sizeof view->base_force);
    show_sums(mpm, view);
    return SCREE_OK;
}

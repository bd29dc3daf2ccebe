/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See outline.h. */
#include "measure/outline.h"

#include <math.h>

#include "base/memory.h"

#define SLICE 0.01 // m along the chute

static double largest_volume(const struct view *view)
{
    double largest = 0;
    for (size_t k = 0; k < view->bodies; k++)
        largest = fmax(largest, view->body[k].volume);
    return largest;
}

/* ---- by height ---- */

size_t outline_layers(const struct view *view, const struct mobility_site *site, double place,
                      double rows[LAYERS_MAX][LAYER_COLUMNS])
{
    struct layer {
        double bodies, cubes, mass, speed, across, across2;
    } layer[LAYERS_MAX] = {{0}};
    size_t count = 0;
    double largest = largest_volume(view);
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        if (fabs(chute_arc(&site->chute, b->position[0]) - place) > FLOW_CENTRAL_HALF)
            continue;
        double height = chute_height(&site->chute, b->position) / site->grain_m, slope = chute_slope(&site->chute, b->position[0]);
        size_t at = height > 0 ? (size_t)fmin(height, LAYERS_MAX - 1) : 0;
        struct layer *l = &layer[at];
        l->bodies += 1;
        l->cubes += b->volume > 0.99 * largest;
        l->mass += b->mass;
        l->speed += b->mass * (b->velocity[0] * cos(slope) - b->velocity[2] * sin(slope));
        l->across += b->velocity[1];
        l->across2 += b->velocity[1] * b->velocity[1];
        count = at + 1 > count ? at + 1 : count;
    }
    for (size_t k = 0; k < count; k++) {
        const struct layer *l = &layer[k];
        double n = fmax(1, l->bodies), mean = l->across / n;
        rows[k][0] = ((double)k + 0.5) * site->grain_m;
        rows[k][1] = l->bodies;
        rows[k][2] = l->mass > 0 ? l->speed / l->mass : 0;
        rows[k][3] = fmax(0, l->across2 / n - mean * mean);
        rows[k][4] = l->cubes / n;
    }
    return count;
}

/* ---- along the chute ---- */

static void add_body(const struct mobility_site *site, const struct view_body *b, double largest, double row[OUTLINE_COLUMNS])
{
    bool first = row[1] == 0;
    double height = chute_height(&site->chute, b->position);
    row[1] += 1;
    row[2] += b->mass;
    row[3] = first ? height : fmax(row[3], height);
    row[4] = first ? b->position[1] : fmin(row[4], b->position[1]);
    row[5] = first ? b->position[1] : fmax(row[5], b->position[1]);
    row[6] += b->volume > 0.99 * largest;
}

enum scree_status outline_deposit(const struct view *view, const struct mobility_site *site, const uint8_t *in_flow,
                                  double (**rows)[OUTLINE_COLUMNS], size_t *count, struct scree_error *err)
{
    double rear = INFINITY, front = -INFINITY, largest = largest_volume(view);
    for (size_t k = 0; k < view->bodies; k++)
        if (in_flow[k]) {
            double along = chute_arc(&site->chute, view->body[k].position[0]);
            rear = fmin(rear, along);
            front = fmax(front, along);
        }
    double from = floor(rear / SLICE), slices = floor(front / SLICE) - from + 1;
    *count = slices >= 1 ? (size_t)slices : 0;
    if (!(*rows = memory_rows(*count, sizeof **rows)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the outline of a deposit");
    for (size_t k = 0; k < view->bodies; k++)
        if (in_flow[k]) {
            double at = floor(chute_arc(&site->chute, view->body[k].position[0]) / SLICE) - from;
            add_body(site, &view->body[k], largest, (*rows)[(size_t)at]);
        }
    for (size_t k = 0; k < *count; k++) {
        (*rows)[k][0] = SLICE * (from + (double)k + 0.5);
        (*rows)[k][6] /= fmax(1, (*rows)[k][1]);
    }
    return SCREE_OK;
}

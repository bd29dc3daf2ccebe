/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See window.h: when the instants are full every second one is dropped. */
#include "measure/window.h"

#include <string.h>

void window_start(struct window *w)
{
    memset(w, 0, sizeof *w);
    w->every = 1;
    w->count = 1; // the start, at which all sums are 0
}

void window_add(struct window *w, double time_s, double weight, const double values[WINDOW_VALUES])
{
    w->weight += weight;
    for (int k = 0; k < WINDOW_VALUES; k++)
        w->sum[k] += weight * values[k];
    if (++w->added % w->every)
        return;
    if (w->count == WINDOW_INSTANTS) {
        for (size_t k = 1; k < WINDOW_INSTANTS / 2; k++)
            w->instants[k] = w->instants[2 * k];
        w->count = WINDOW_INSTANTS / 2;
        w->every *= 2;
        if (w->added % w->every)
            return;
    }
    w->instants[w->count].time_s = time_s;
    w->instants[w->count].weight = w->weight;
    memcpy(w->instants[w->count++].sum, w->sum, sizeof w->sum);
}

double window_means(const struct window *w, double from_s, double means[WINDOW_VALUES])
{
    size_t k = 0;
    while (k + 1 < w->count && w->instants[k + 1].time_s <= from_s && w->instants[k + 1].weight < w->weight)
        k++;
    double weight = w->weight - w->instants[k].weight;
    for (int v = 0; v < WINDOW_VALUES; v++)
        means[v] = weight > 0 ? (w->sum[v] - w->instants[k].sum[v]) / weight : 0;
    return w->instants[k].time_s;
}

size_t window_bytes(const struct window *w)
{
    return offsetof(struct window, instants) + (w->count < WINDOW_INSTANTS ? w->count : WINDOW_INSTANTS) * sizeof *w->instants;
}

bool window_sound(const struct window *w)
{
    return w->count >= 1 && w->count <= WINDOW_INSTANTS && w->every > 0;
}

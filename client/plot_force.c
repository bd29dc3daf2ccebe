/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_force.h. */
#include "plot_force.h"

#include <math.h>

void plot_force_take(void *context, const struct reader_chunk *chunk)
{
    struct plot_force *f = context;
    for (size_t r = 0; r < chunk->rows && chunk->columns >= PLOT_FORCE_COMPONENTS; r++) {
        double at = (chunk->t0_s + (double)r * chunk->dt_s - f->begin) / (f->end - f->begin) * PLOT_FORCE_BINS;
        struct plot_force_bin *b = &f->bins[at < 0 ? 0 : at >= PLOT_FORCE_BINS ? PLOT_FORCE_BINS - 1 : (int)at];
        for (int c = 0; c < PLOT_FORCE_COMPONENTS; c++) {
            double value = chunk->values[r * chunk->columns + (size_t)c];
            b->sum[c] += value;
            b->least[c] = b->count == 0 ? value : fmin(b->least[c], value);
            b->most[c] = b->count == 0 ? value : fmax(b->most[c], value);
        }
        b->count++;
    }
}

void plot_force_write(struct picture *p, const char *name, const struct plot_force *f)
{
    fprintf(p->script, "%s << EOD\n", name);
    for (int k = 0; k < PLOT_FORCE_BINS; k++) {
        const struct plot_force_bin *b = &f->bins[k];
        if (b->count == 0)
            continue;
        fprintf(p->script, "%.9g", f->begin + (k + 0.5) / PLOT_FORCE_BINS * (f->end - f->begin));
        for (int c = 0; c < PLOT_FORCE_COMPONENTS; c++)
            fprintf(p->script, " %.9g %.9g %.9g", b->sum[c] / b->count, b->least[c], b->most[c]);
        putc('\n', p->script);
    }
    fprintf(p->script, "EOD\n");
}

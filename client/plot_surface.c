/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_surface.h. Every frame becomes a block of data, named by its number:
 * they are small, and which of them are drawn is known only once all are read. */
#include "plot_surface.h"

#include <math.h>

void plot_surface_take(void *context, const struct reader_chunk *chunk)
{
    struct plot_surface *s = context;
    int x = reader_column(chunk, "x"), surface = reader_column(chunk, "surface"), still = reader_column(chunk, "static");
    if (x < 0 || surface < 0 || still < 0)
        return;
    size_t frame = s->frames < PLOT_SURFACE_FRAMES ? s->frames++ : PLOT_SURFACE_FRAMES - 1;
    s->time[frame] = chunk->t0_s;
    fprintf(s->script, "$surface%zu << EOD\n", frame);
    for (size_t r = 0; r < chunk->rows; r++) {
        const double *row = chunk->values + r * chunk->columns;
        fprintf(s->script, "%.9g %.9g %.9g\n", row[x], 1e3 * row[surface], 1e3 * row[still]);
    }
    fprintf(s->script, "EOD\n");
}

static size_t nearest(const struct plot_surface *s, double time)
{
    size_t best = 0;
    for (size_t k = 1; k < s->frames; k++)
        if (fabs(s->time[k] - time) < fabs(s->time[best] - time))
            best = k;
    return best;
}

void plot_surface_draw(struct picture *p, const struct plot_surface *s, double gate_s)
{
    static const char *const colours[] = {"#999999", "#0072b2", "#009e73", "#d55e00"};
    const double after = s->time[s->frames - 1] - gate_s;
    const double times[] = {0, gate_s + (after > 0.6 ? 0.2 : after / 3), gate_s + (after > 0.6 ? 0.6 : 2 * after / 3),
                            gate_s + after};
    fprintf(p->script, "set xlabel 'along the channel (m); lines: free surface, dots: below them nothing flows at 0.01 m/s'\n"
                       "set ylabel 'height over the floor (mm)'\nset xrange [0:*] noextend\nset yrange [0:*]\nplot ");
    for (size_t k = 0; k < sizeof times / sizeof *times; k++) {
        size_t frame = nearest(s, times[k]);
        fprintf(p->script, "$surface%zu using 1:2 with lines lw 1.8 lc rgb '%s' title '%.3g s%s', ", frame, colours[k],
                s->time[frame] - gate_s,
                k == 0       ? ", the start"
                : gate_s > 0 ? " after the gate"
                             : "");
        if (k > 0)
            fprintf(p->script, "$surface%zu using 1:3 with lines lw 2 dt 3 lc rgb '%s' notitle, ", frame, colours[k]);
    }
    fprintf(p->script, "NaN notitle\nset xrange [*:*] extend\nset yrange [*:*]\n");
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_heap.h: speeds over sqrt(g H_0) against t / tau_c with the peaks of seed 001
 * (Fig. 12), heights, and the run-out with its bars against the aspect ratio (Fig. 10).
 * Of the laws of run-out only the exponents are published: their lines start at 1. */
#include "plot_heap.h"

#include <math.h>

#include "output.h"
#include "plot_read.h"

enum { TIME, SPEED, RATIO, CENTRE_X, CENTRE_Z, CORE_TOP, COLUMNS };

/* What a collapse is measured in; NaN where there is no gate, or it has not gone. */
struct plot_heap_scales {
    double gate_s, length, height, gravity; // L_0, H_0, m, m/s2
    double runout, runout_least, runout_most, final_height;
};

static struct plot_heap_scales scales_of(const cJSON *record)
{
    const cJSON *params = json_get(json_get(record, "spec"), "params");
    return (struct plot_heap_scales){.gate_s = json_number(params, "settle_s", NAN),
                                     .length = json_number(params, "column_m", NAN),
                                     .gravity = json_number(params, "gravity_m_s2", NAN),
                                     .height = json_get(params, "column_m") ? plot_number_of(record, "column_height") : NAN,
                                     .runout = plot_number_of(record, "runout"),
                                     .runout_least = plot_number_of(record, "runout_least"),
                                     .runout_most = plot_number_of(record, "runout_most"),
                                     .final_height = plot_number_of(record, "pile_height")};
}

void plot_heap_take(void *context, const struct reader_chunk *chunk)
{
    struct plot_heap *h = context;
    if (chunk->columns < COLUMNS)
        return;
    if (h->rows == 0)
        fprintf(h->script, "$heap << EOD\n");
    for (size_t r = 0; r < chunk->rows; r++, h->rows++) {
        const double *row = chunk->values + r * chunk->columns;
        fprintf(h->script, "%.9g %.9g %.9g %.9g %.9g\n", row[TIME], row[SPEED], row[RATIO], row[CENTRE_Z], row[CORE_TOP]);
    }
}

void plot_heap_end(const struct plot_heap *h)
{
    if (h->rows > 0)
        fprintf(h->script, "EOD\n");
}

static void panel(FILE *script, int k, double low, double high)
{
    fprintf(script,
            "unset label\nunset arrow\nunset logscale\nset format xy '%%g'\nset key inside right top font ',9' samplen 1\nset "
            "xtics font ',9'\nset xrange [*:*]\nset yrange "
            "[0:*]\nset lmargin at screen %.3f\nset rmargin at screen %.3f\nset origin 0,%.6g\nset size 1,%.6g\n",
            0.07 + 0.33 * k, 0.3 + 0.33 * k, low, high);
}

static void draw_speed(FILE *script, const struct plot_heap_scales *s)
{
    double tau = sqrt(s->height / s->gravity);
    if (!isfinite(tau)) {
        fprintf(script, "set xlabel 'time (s)'\nset ylabel 'mean speed (m/s)'\nplot $heap using 1:2 with lines lw 1.5 lc rgb "
                        "'#0072b2' notitle\n");
        return;
    }
    fprintf(script,
            "set xlabel 'time since the gate went over sqrt(H0 / g)'\nset ylabel 'mean speed over sqrt(g H0)'\nset xrange "
            "[0:*]\nset yrange [0:0.6]\nplot $heap using (($1-%.9g)/%.9g):3 with lines lw 1.5 lc rgb '#0072b2' title 'here', 0.37 "
            "with lines dt 2 lc rgb '#444444' title 'peak: spheres, few crosses', 0.20 with lines dt 3 lc rgb '#444444' title "
            "'peak: many crosses'\n",
            s->gate_s, tau);
}

static void draw_runout(FILE *script, const struct plot_heap_scales *s)
{
    double l = s->length;
    if (!(s->height > 0 && s->runout > l))
        return;
    fprintf(script,
            "set logscale xy\nset xlabel 'H0 / L0'\nset ylabel '(L - L0) / L0'\nset xrange [0.3:12]\nset yrange [0.1:20]\nset key "
            "inside left top\nplot (x<3 ? x : 3**(1.0/3)*x**(2.0/3)) with lines dt 2 lc rgb '#444444' title 'slopes 1, 2/3', '-' "
            "using 1:2:3:4 with yerrorbars pt 7 lc rgb '#d55e00' title 'here'\n%.9g %.9g %.9g %.9g\ne\n",
            s->height / l, s->runout / l - 1, fmax(s->runout_least / l - 1, 1e-3), s->runout_most / l - 1);
}

void plot_heap_draw(const struct plot_heap *h, const cJSON *record, double low, double high)
{
    const struct plot_heap_scales scales = scales_of(record), *s = &scales;
    panel(h->script, 0, low, high);
    draw_speed(h->script, s);
    panel(h->script, 1, low, high);
    fprintf(h->script,
            "set xlabel 'time (s)'\nset ylabel 'height (m)'\nplot $heap using 1:5 with lines lw 1.5 lc rgb '#0072b2' title "
            "'highest body of the core', $heap using 1:4 with lines lw 1.5 lc rgb '#009e73' title 'centre of mass'");
    if (isfinite(s->final_height) && s->height > 0)
        fprintf(h->script, ", %.9g with lines dt 2 lc rgb '#444444' title 'H', %.9g with lines dt 3 lc rgb '#444444' title 'H0'",
                s->final_height, s->height);
    fprintf(h->script, "\n");
    panel(h->script, 2, low, high);
    draw_runout(h->script, s);
}

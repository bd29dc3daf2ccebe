/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Profiles side by side, heights upwards; see plot_profiles.h. Columns are found
 * by name, so that another order of them shows nothing wrong. */
#include "plot_profiles.h"

#include <math.h>

#include "calibrate/digits.h"

static const struct curve {
    int panel;
    double scale; // of the value as shown
    const char *column, *title, *colour;
} curves[] = {
    {0, 1, "phi", "solid fraction", "#0072b2"},
    {0, 1, "P_C", "joined to the base", "#d55e00"},
    {1, 1, "ux", "", "#0072b2"},
    {2, 1, "T", "T", "#0072b2"},
    {2, 1, "dn2", "normal speed", "#d55e00"},
    {2, 1, "dt2", "tangential speed", "#009e73"},
    {3, 1e-12, "n_I", "", "#0072b2"},
};
enum { CURVES = sizeof curves / sizeof *curves, PANELS = PLOT_PROFILE_PANELS };
static const char *const axes[PANELS] = {"share", "u_x (m/s)", "T, impact speed squared (m2/s2)", "impacts (1/(mm3 ms))"};

void plot_profiles_take(void *context, const struct reader_chunk *chunk)
{
    struct plot_profiles *p = context;
    int z = reader_column(chunk, "z"), phi = reader_column(chunk, "phi");
    if (z < 0 || phi < 0)
        return;
    fprintf(p->script, "$profiles << EOD\n");
    for (size_t r = 0; r < chunk->rows; r++) {
        const double *row = chunk->values + r * chunk->columns;
        fprintf(p->script, "%.9g", 1e3 * row[z]);
        for (size_t k = 0; k < CURVES; k++) { // what nothing was seen of has no value
            int c = reader_column(chunk, curves[k].column);
            bool there = c >= 0 && (row[c] != 0 || curves[k].panel == 0);
            double *largest = &p->largest[curves[k].panel];
            *largest = there ? fmax(*largest, row[c] * curves[k].scale) : *largest;
            fprintf(p->script, there ? " %.9g" : " ?", there ? row[c] * curves[k].scale : 0);
        }
        putc('\n', p->script);
        if (row[phi] > 1e-3)
            p->top = fmax(p->top, 1e3 * row[z]);
        p->rows++;
    }
    fprintf(p->script, "EOD\n");
}

void plot_profiles_draw(const struct plot_profiles *p, double low, double high)
{
    fprintf(p->script,
            "unset lmargin\nunset rmargin\nset bmargin 4.5\nset yrange [*:%.6g]\nset ylabel 'height over the base (mm)'\n",
            p->top > 0 ? p->top : 1);
    fprintf(p->script, "set tmargin 5\nset key at graph 1,graph 1.3 right top Right noreverse samplen 1.5 spacing 0.9\n");
    for (int panel = 0; panel < PANELS; panel++) {
        fprintf(p->script, "set origin %.6g,%.6g\nset size %.6g,%.6g\nset xlabel '%s'\n", panel / (double)PANELS, low, 1.0 / PANELS,
                high, axes[panel]);
        fprintf(p->script, panel == 2 ? "set logscale x\nset format x '%%.0e'\n" : panel == 0 ? "set xrange [0:1]\n" : "");
        if (panel % 2 && p->largest[panel] > 0) // linear, and narrow: gnuplot's own tics would run into each other
            fprintf(p->script, "set xtics 0,%.9g\n", digits_round(p->largest[panel] / 3, 1));
        else
            fprintf(p->script, "set xtics autofreq\n");
        fprintf(p->script, "plot ");
        for (int k = 0; k < (int)CURVES; k++)
            if (curves[k].panel == panel)
                fprintf(p->script, "$profiles using %d:1 with lines lw 1.5 lc rgb '%s' %s '%s', ", k + 2, curves[k].colour,
                        *curves[k].title ? "title" : "notitle", curves[k].title);
        fprintf(p->script, "NaN notitle\nunset logscale\nset format x '%%g'\nset xrange [*:*]\nset ylabel ' '\n");
    }
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_chute.h. Lengths are drawn in mm where a deposit is, else in m. */
#include "plot_chute.h"

#include <math.h>

/* Columns of a chunk by name, one block of the script; returns how many rows, 0 where a column is missing. */
static size_t write_block(FILE *script, const char *block, const struct reader_chunk *chunk, const char *const *names)
{
    int column[16], count = 0;
    for (; names[count]; count++)
        if ((column[count] = reader_column(chunk, names[count])) < 0)
            return 0;
    fprintf(script, "$%s << EOD\n", block);
    for (size_t r = 0; r < chunk->rows; r++) {
        for (int c = 0; c < count; c++)
            fprintf(script, " %.9g", chunk->values[r * chunk->columns + (size_t)column[c]]);
        putc('\n', script);
    }
    fprintf(script, "EOD\n");
    return chunk->rows;
}

/* Each triangle as a closed line of its own. The floor is where corners are nearest to the middle. */
void plot_chute_take_walls(void *context, const struct reader_chunk *chunk)
{
    struct plot_chute *p = context;
    if (reader_column(chunk, "z2") != 8)
        return;
    p->floor = INFINITY;
    fprintf(p->script, "$walls << EOD\n");
    for (size_t r = 0; r < chunk->rows; r++) {
        const double *t = chunk->values + r * chunk->columns;
        for (int c = 0; c < 4; c++) {
            const double *corner = t + 3 * (c % 3);
            fprintf(p->script, "%.9g %.9g %.9g\n", corner[0], corner[1], corner[2]);
            p->floor = fmin(p->floor, fabs(corner[1]));
        }
        fprintf(p->script, "\n\n");
    }
    fprintf(p->script, "EOD\n");
    p->walls = chunk->rows;
}

void plot_chute_take_snapshot(void *context, const struct reader_chunk *chunk)
{
    static const char *const names[] = {"x", "y", "z", "radius", "vx", "vz", NULL};
    struct plot_chute *p = context;
    char block[16];
    if (p->frames == PLOT_CHUTE_FRAMES)
        return;
    snprintf(block, sizeof block, "snapshot%zu", p->frames);
    if (write_block(p->script, block, chunk, names) > 0)
        p->time[p->frames++] = chunk->t0_s;
}

void plot_chute_take_bodies(void *context, const struct reader_chunk *chunk)
{
    static const char *const names[] = {"x", "y", "z", "shape", "in_flow", NULL};
    struct plot_chute *p = context;
    p->bodies = write_block(p->script, "bodies", chunk, names);
}

void plot_chute_take_flow(void *context, const struct reader_chunk *chunk)
{
    static const char *const names[] = {"time", "place", "variance_across", "speed", "dissipated", NULL};
    struct plot_chute *p = context;
    char block[16];
    snprintf(block, sizeof block, "flow%zu", p->flow);
    p->flow += write_block(p->script, block, chunk, names) > 0;
}

void plot_chute_take_layers(void *context, const struct reader_chunk *chunk)
{
    static const char *const names[] = {"height", "bodies", "speed", NULL};
    struct plot_chute *p = context;
    p->layers = write_block(p->script, "layers", chunk, names);
    p->layers_s = chunk->t0_s;
}

/* ---- drawing ---- */

static void place(FILE *script, double left, double width, double low, double high)
{
    fprintf(script, "set origin %.6g,%.6g\nset size %.6g,%.6g\n", left, low, width, high);
}

/* The apparatus from above and aside, with the last snapshot in it. */
static void draw_apparatus(const struct plot_chute *p, double low, double high)
{
    place(p->script, 0, 1, low, high);
    fprintf(p->script, "set view 72,22,3.2\nset view equal xyz\nunset key\nunset border\nunset tics\nset xlabel ''\nset ylabel ''\n"
                       "set xrange [*:*]\nset yrange [*:*]\nunset colorbox\n"
                       "splot $walls using 1:2:3 with lines lw 0.4 lc rgb '#999999' notitle");
    for (size_t k = 0; k < p->frames; k++)
        fprintf(p->script, ", $snapshot%zu using 1:2:3:(sqrt($5**2+$6**2)) with points pt 7 ps 0.25 lc palette notitle", k);
    fprintf(p->script, "\nset border 31\nset tics\nset colorbox\nunset view\n");
}

/* The profile with every snapshot in it, grains in their size, coloured by speed (Fig. 4). */
static void draw_section(const struct plot_chute *p, double low, double high)
{
    place(p->script, 0, 1, low, high);
    fprintf(p->script, "set lmargin at screen 0.09\nset rmargin at screen 0.86\nset size ratio -1\nset xlabel 'x (m), at");
    for (size_t k = 0; k < p->frames; k++)
        fprintf(p->script, "%s %.3g", k ? "," : "", p->time[k]);
    fprintf(p->script,
            " s'\nset ylabel 'z (m)'\nset cblabel 'speed (m/s)'\nset cbrange [0:*]\n"
            "plot $walls using 1:(abs($2) < %.9g ? $3 : NaN) with lines lw 0.6 lc rgb '#888888' notitle",
            1.001 * p->floor);
    for (size_t k = 0; k < p->frames; k++)
        fprintf(p->script, ", $snapshot%zu using 1:3:4:(sqrt($5**2+$6**2)) with circles lc palette fs solid 1 noborder notitle", k);
    fprintf(p->script, "\nset size noratio\nunset lmargin\nunset rmargin\nset cbrange [*:*]\nunset colorbox\n");
}

/* From above: the largest in red, the others in grey, what is not of the flow proper hollow (Figs 7 and 16). */
static void draw_deposit(const struct plot_chute *p, double low, double high)
{
    place(p->script, 0, 1, low, high);
    fprintf(p->script,
            "set lmargin at screen 0.09\nset rmargin at screen 0.86\nset xlabel 'x (m)'\nset ylabel 'y (mm)'\n"
            "set yrange [-35:35]\nset key outside right top reverse Left samplen 1\n"
            "plot $bodies using 1:($4 > 0 && $5 > 0 ? 1e3*$2 : NaN) with points pt 7 ps 0.3 lc rgb '#888888' title 'other shapes', "
            "$bodies using 1:($4 == 0 && $5 > 0 ? 1e3*$2 : NaN) with points pt 7 ps 0.4 lc rgb '#d00000' title 'cubes', "
            "$bodies using 1:($5 == 0 ? 1e3*$2 : NaN) with points pt 6 ps 0.4 lc rgb '#0072b2' title 'came alone'\n"
            "set yrange [*:*]\nunset lmargin\nunset rmargin\n");
}

static void draw_flow(const struct plot_chute *p, double low, double high)
{
    static const struct {
        const char *x, *y, *columns;
    } panels[] = {{"time (s)", "variance across (m2/s2)", "1:3"}, {"place along the chute (m)", "dissipated (J/kg)", "2:5"}};
    fprintf(p->script, "unset key\nset xtics rotate by 45 right\n");
    for (int k = 0; k < 2; k++) {
        place(p->script, k / 3.0, 1 / 3.0, low, high);
        fprintf(p->script, "set xlabel '%s'\nset ylabel '%s'\nplot ", panels[k].x, panels[k].y);
        for (size_t c = 0; c < p->flow; c++)
            fprintf(p->script, "$flow%zu using %s with linespoints pt 7 ps 0.5 lc rgb '#0072b2' notitle, ", c, panels[k].columns);
        fprintf(p->script, "NaN notitle\n");
    }
    place(p->script, 2 / 3.0, 1 / 3.0, low, high);
    fprintf(p->script,
            "set xlabel 'speed along the slope (m/s), %.3g s'\nset ylabel 'height (mm)'\nset xrange [0:*]\n"
            "plot $layers using ($2 > 2 ? $3 : NaN):(1e3*$1) with linespoints pt 7 ps 0.5 lc rgb '#d55e00' notitle\n"
            "set xrange [*:*]\nset xtics norotate autojustify\n",
            p->layers_s);
}

void plot_chute_draw(const struct plot_chute *p, int row, double low, double high)
{
    static void (*const rows[PLOT_CHUTE_ROWS])(const struct plot_chute *, double, double) = {draw_apparatus, draw_section,
                                                                                             draw_deposit, draw_flow};
    const bool there[PLOT_CHUTE_ROWS] = {p->walls > 0, p->walls > 0 && p->frames > 0, p->bodies > 0, p->flow > 0};
    if (there[row])
        rows[row](p, low, high);
}

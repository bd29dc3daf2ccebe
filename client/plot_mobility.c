/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_mobility.h. A line is fitted, as in the paper, through the flows of all
 * three shapes that had the full compaction before release; flows of smaller
 * initial compaction and of cubes only are drawn beside it. */
#include "plot_mobility.h"

#include <math.h>
#include <string.h>

static const struct panel {
    const char *title, *accelerator, *mobility;
    bool bars;
    double a, b; // published, eq. 15
} panels[] = {
    {"Fig. 8: accelerator as the chute", "chute", "mobility", true, 0.029, 0.8154},
    {"Fig. 9: distal fragments left out at release, too", "chute", "mobility_trimmed", false, 0.025, 0.8165},
    {"Fig. 10: accelerator as the gate", "gate", "mobility", true, 0.0348, 0.7119},
};
enum { PANELS = sizeof panels / sizeof *panels };

enum kind { COMPACT, LOOSE, CUBES, KINDS };
static const struct {
    const char *title, *style;
} kinds[KINDS] = {{"3 clasts", "pt 5 ps 1.3 lc rgb '#0072b2'"},
                  {"3 clasts, SIC", "pt 6 ps 1.5 lw 2 lc rgb '#d55e00'"},
                  {"cubes only", "pt 4 ps 1.4 lw 2 lc rgb '#009e73'"}};

static int column_of(const cJSON *table, const char *name)
{
    int k = 0;
    const cJSON *head;
    cJSON_ArrayForEach(head, json_get(table, "columns"))
    {
        const char *here = json_text(head, "name");
        if (here && strcmp(here, name) == 0)
            return k;
        k++;
    }
    return -1;
}

static double cell(const cJSON *table, const cJSON *row, const char *name, double missing)
{
    int column = column_of(table, name);
    const cJSON *value = column >= 0 ? cJSON_GetArrayItem(row, column) : NULL;
    return cJSON_IsNumber(value) ? value->valuedouble : missing;
}

/* A trial that still runs has numbers, but they are not of a deposit. */
static bool is_done(const cJSON *table, const cJSON *row)
{
    int column = column_of(table, "state");
    const char *word = column >= 0 ? cJSON_GetStringValue(cJSON_GetArrayItem(row, column)) : NULL;
    return !word || strcmp(word, "done") == 0;
}

static const char *accelerator_of(const cJSON *table, const cJSON *row)
{
    int column = column_of(table, "params.accelerator");
    const char *word = column >= 0 ? cJSON_GetStringValue(cJSON_GetArrayItem(row, column)) : NULL;
    return word ? word : "chute";
}

static enum kind kind_of(const cJSON *table, const cJSON *row)
{
    if (cell(table, row, "params.cubes", 0) > 0.99)
        return CUBES;
    return cell(table, row, "params.space_mass_g", 0) > 1.001 * cell(table, row, "params.mass_g", INFINITY) ? LOOSE : COMPACT;
}

bool plot_mobility_fit(const cJSON *table)
{
    const cJSON *row;
    int count = 0;
    cJSON_ArrayForEach(row, json_get(table, "rows")) count +=
        is_done(table, row) && isfinite(cell(table, row, "mobility", NAN) + cell(table, row, "beta", NAN));
    return count >= 2;
}

/* Least squares. */
struct line {
    double n, x, y, xx, xy;
};

static void line_add(struct line *l, double x, double y)
{
    l->n += 1, l->x += x, l->y += y, l->xx += x * x, l->xy += x * y;
}

static double line_slope(const struct line *l)
{
    double scatter = l->n * l->xx - l->x * l->x;
    return scatter > 1e-12 * l->n * l->xx ? (l->n * l->xy - l->x * l->y) / scatter : NAN;
}

/* Blocks "$pPK" of panel P and kind K: beta, mobility, ends of the bar. Returns the line through the compact ones, none
 * where all are of one size and mass: the scatter of one flow's realisations is no line. */
static struct line write_panel(struct picture *p, const cJSON *table, int which, int counts[KINDS])
{
    const struct panel *panel = &panels[which];
    struct line line = {0};
    double first[2] = {NAN, NAN};
    bool several = false;
    for (int k = 0; k < KINDS; k++) {
        const cJSON *row;
        fprintf(p->script, "$p%d%d << EOD\n", which, k);
        counts[k] = 0;
        cJSON_ArrayForEach(row, json_get(table, "rows"))
        {
            double beta = cell(table, row, "beta", NAN), mobility = cell(table, row, panel->mobility, NAN);
            if (!is_done(table, row) || !isfinite(beta + mobility) || kind_of(table, row) != (enum kind)k ||
                strcmp(accelerator_of(table, row), panel->accelerator) != 0)
                continue;
            fprintf(p->script, "%.9g %.9g %.9g %.9g\n", beta, mobility, cell(table, row, "mobility_lower", mobility),
                    cell(table, row, "mobility_upper", mobility));
            counts[k]++;
            if (k != COMPACT)
                continue;
            double size = cell(table, row, "params.size_m", 0), mass = cell(table, row, "params.mass_g", 0);
            several |= line.n > 0 && (size != first[0] || mass != first[1]);
            first[0] = size, first[1] = mass;
            line_add(&line, beta, mobility);
        }
        fprintf(p->script, "EOD\n");
    }
    return several ? line : (struct line){0};
}

void plot_mobility_draw(struct picture *p, const cJSON *table)
{
    fprintf(p->script, "set key top left reverse Left samplen 2\nset xlabel 'beta (mm2/cm2)'\n");
    for (int which = 0; which < PANELS; which++) {
        const struct panel *panel = &panels[which];
        int counts[KINDS];
        struct line line = write_panel(p, table, which, counts);
        double a = line_slope(&line), b = (line.y - a * line.x) / line.n;
        fprintf(p->script, "set origin %.6g,0\nset size %.6g,0.92\nset title ", which / (double)PANELS, 1.0 / PANELS);
        picture_quote(p, panel->title);
        fprintf(p->script,
                "\nset xrange [0:%s]\nset ylabel 'mobility mu_A'\nset offsets 0, graph 0.05, graph 0.3, graph 0.05\n"
                "plot %.9g*x+%.9g with lines lw 1.5 dt 2 lc rgb '#000000' title 'published: %.4g beta + %.4g'",
                counts[COMPACT] + counts[LOOSE] + counts[CUBES] > 0 ? "*" : "2.5", panel->a, panel->b, panel->a, panel->b);
        if (isfinite(a))
            fprintf(p->script, ", %.9g*x+%.9g with lines lw 1.5 lc rgb '#0072b2' title 'fitted: %.3g beta + %.4g'", a, b, a, b);
        for (int k = 0; k < KINDS; k++) {
            if (counts[k] > 0 && panel->bars)
                fprintf(p->script, ", $p%d%d using 1:2:3:4 with yerrorbars %s title '%s'", which, k, kinds[k].style,
                        kinds[k].title);
            else if (counts[k] > 0)
                fprintf(p->script, ", $p%d%d using 1:2 with points %s title '%s'", which, k, kinds[k].style, kinds[k].title);
        }
        fprintf(p->script, "\n");
    }
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_pair.h. Forces are drawn over the weight of the flow, so that a box of
 * grains and a square metre of continuum can be compared. */
#include "plot_pair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "follow.h"
#include "output.h"
#include "plot_force.h"
#include "plot_read.h"

enum { SIDES = 2, GRAINS = 0, CONTINUUM = 1 };

static const struct kind {
    const char *name, *heights, *shown; // the stream that the surface's height is from, and how
    const char *says[2];
} kinds[SIDES] = {
    {"grains",
     "bulk",
     "twice the height of the centre of mass",
     {"Grains: every impact is there, so the force has a spectrum up to the rate of a contact;",
      "but it is one draw of a random flow, in a small periodic box, and costs by the grain."}},
    {"continuum",
     "surface",
     "free surface, where phi falls through 0.5",
     {"Continuum: mean force, surface and their slow changes, for a layer of any extent;",
      "but it has no collisions, so there is no high-frequency force in it, and none may be read from it."}},
};

struct side {
    const struct kind *kind;
    FILE *script;
    cJSON *record;
    struct plot_force force;
};

bool plot_pair_fits(const cJSON *record)
{
    const cJSON *trial;
    const char *first = NULL;
    cJSON_ArrayForEach(trial, json_get(record, "trials"))
    {
        const char *scenario = json_text(json_get(trial, "values"), "scenario");
        if (first && scenario && strcmp(first, scenario) != 0)
            return true;
        first = first ? first : scenario;
    }
    return false;
}

/* Rows "time height": of grains one a sample, of a continuum the mean over each frame. */
static void take_heights(void *context, const struct reader_chunk *chunk)
{
    struct side *side = context;
    int centre = reader_column(chunk, "centre_z"), surface = reader_column(chunk, "surface");
    double sum = 0;
    for (size_t r = 0; r < chunk->rows; r++) {
        const double *row = chunk->values + r * chunk->columns;
        if (centre >= 0)
            fprintf(side->script, "%.9g %.9g\n", chunk->t0_s + (double)r * chunk->dt_s, 2e3 * row[centre]);
        sum += surface >= 0 ? row[surface] : 0;
    }
    if (surface >= 0 && chunk->rows > 0)
        fprintf(side->script, "%.9g %.9g\n", chunk->t0_s, 1e3 * sum / (double)chunk->rows);
}

/* Finds the side's job among the trials: a continuum is what has a surface. */
static enum outcome find_side(struct link *link, const cJSON *study, struct side *side, struct scree_error *err)
{
    const cJSON *trial;
    bool continuum = side->kind == &kinds[CONTINUUM];
    cJSON_ArrayForEach(trial, json_get(study, "trials"))
    {
        const char *job = json_text(trial, "job");
        enum outcome outcome = job ? ask_record(link, job, true, &side->record, err) : OUTCOME_DONE;
        if (outcome)
            return outcome;
        if (side->record && continuum == (plot_chunks_of(side->record, "surface") > 0) &&
            plot_chunks_of(side->record, "basal_force") > 0)
            return OUTCOME_DONE;
        cJSON_Delete(side->record);
        side->record = NULL;
    }
    return outcome_fail(err, OUTCOME_REFUSED, "no trial of %s has a force on its base to draw yet", side->kind->name);
}

static enum outcome read_side(struct link *link, struct picture *p, int number, struct side *side, struct scree_error *err)
{
    const char *heights = side->kind->heights;
    char name[16];
    side->script = p->script;
    side->force.end = json_number(side->record, "time_s", 0);
    enum outcome outcome = plot_read_stream(link, side->record, "basal_force", plot_force_take, &side->force, err);
    snprintf(name, sizeof name, "$force%d", number);
    plot_force_write(p, name, &side->force);
    fprintf(p->script, "$heights%d << EOD\n", number);
    if (!outcome)
        outcome = plot_read_stream(link, side->record, heights, take_heights, side, err);
    fprintf(p->script, "EOD\n");
    return outcome;
}

static void draw_side(struct picture *p, int number, const struct side *side)
{
    double weight = plot_number_of(side->record, "weight_normal"), left = 0.5 * number;
    if (!(weight > 0))
        weight = 1;
    fprintf(p->script, "set size 0.5,0.4\nset origin %.3g,0.55\nset xrange [0:%.9g]\nset xlabel 'time (s)'\n", left,
            side->force.end);
    fprintf(p->script, "set title ");
    char title[120];
    snprintf(title, sizeof title, "%s: %.20s, scenario %.40s", side->kind->name, json_text(side->record, "id"),
             json_text(side->record, "scenario"));
    picture_quote(p, title);
    fprintf(p->script,
            "\nset ylabel 'force into base / weight'\nset yrange [0:forces]\n"
            "plot $force%d using 1:(-$9/%.9g):(-$10/%.9g) with filledcurves fc rgb '#d55e00' fs transparent solid 0.35 noborder "
            "title 'least and largest', $force%d using 1:(-$8/%.9g) with lines lw 1.2 lc rgb '#000000' title 'mean'\n",
            number, weight, weight, number, weight);
    fprintf(p->script,
            "unset label\nset title '%s'\nset origin %.3g,0.14\nset ylabel 'surface over base (mm)'\nset yrange [0:heights]\n"
            "plot $heights%d using 1:2 with lines lw 1.5 lc rgb '#0072b2' notitle\n",
            side->kind->shown, left, number);
}

/* Both sides on the same axes: force up to the grains' largest that is no mere fall at the start, heights to both's largest. */
static void set_ranges(struct picture *p, const struct side sides[SIDES])
{
    double most = 1.2;
    for (int side = 0; side < SIDES; side++) {
        double weight = plot_number_of(sides[side].record, "weight_normal");
        for (int k = PLOT_FORCE_BINS / 2; k < PLOT_FORCE_BINS && weight > 0; k++)
            if (sides[side].force.bins[k].count > 0)
                most = fmax(most, -sides[side].force.bins[k].least[2] / weight);
    }
    fprintf(p->script, "forces = %.9g\n", 1.1 * most);
    fprintf(p->script, "stats $heights0 using 2 nooutput name 'H0'\nstats $heights1 using 2 nooutput name 'H1'\n"
                       "heights = 1.1 * (H0_max > H1_max ? H0_max : H1_max)\n");
}

enum outcome plot_pair_draw(struct link *link, const cJSON *record, struct picture *p, struct scree_error *err)
{
    struct side *sides = calloc(SIDES, sizeof *sides);
    if (!sides)
        return outcome_fail(err, OUTCOME_FAILED, "no memory for a picture");
    enum outcome outcome = OUTCOME_DONE;
    for (int k = 0; k < SIDES && !outcome; k++) {
        sides[k].kind = &kinds[k];
        outcome = find_side(link, record, &sides[k], err);
        if (!outcome)
            outcome = read_side(link, p, k, &sides[k], err);
    }
    if (!outcome) {
        set_ranges(p, sides);
        for (int k = 0; k < SIDES; k++)
            for (int line = 0; line < 2; line++)
                fprintf(p->script, "set label '%s' at screen 0.05,%.3g tc rgb '%s'\n", kinds[k].says[line],
                        0.105 - 0.03 * (2 * k + line), k == GRAINS ? "#0072b2" : "#009e73");
        fprintf(p->script, "set multiplot title ");
        picture_quote(p, json_text(record, "title") ? json_text(record, "title") : "");
        putc('\n', p->script);
        for (int k = 0; k < SIDES; k++)
            draw_side(p, k, &sides[k]);
        fprintf(p->script, "unset multiplot\n");
    }
    for (int k = 0; k < SIDES; k++)
        cJSON_Delete(sides[k].record);
    free(sides);
    return outcome;
}

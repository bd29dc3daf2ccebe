/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_models.h. A model's geometric standard error over the trials is
 * exp sqrt(mean ln^2(predicted / measured)) (seed 000 S1). A model with a free
 * constant is drawn with the one that makes the mean of ln(predicted / measured) 0. */
#include "plot_models.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct model {
    const char *column, *title, *point;
    bool scaled; // it has a free factor
} models[] = {
    {"model_minimal", "minimal", "pt 7 lc rgb '#0072b2'", false},
    {"model_thin", "thin flow", "pt 9 lc rgb '#d55e00'", false},
    {"model_thick", "thick flow", "pt 11 lc rgb '#009e73'", false},
    {"model_attenuated", "attenuated", "pt 13 lc rgb '#cc79a7'", false},
    {"model_pressure", "pressure (fitted)", "pt 5 lc rgb '#e69f00'", true},
};
enum { MODELS = sizeof models / sizeof *models };

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

/* A number above 0, else NaN. */
static double cell_of(const cJSON *row, int column)
{
    const cJSON *cell = column >= 0 ? cJSON_GetArrayItem(row, column) : NULL;
    return cJSON_IsNumber(cell) && cell->valuedouble > 0 ? cell->valuedouble : NAN;
}

bool plot_models_fit(const cJSON *table)
{
    int power = column_of(table, "spectrum_power"), inertial = column_of(table, "inertial_number"), count = 0;
    const cJSON *row;
    cJSON_ArrayForEach(row, json_get(table, "rows")) count += isfinite(cell_of(row, power) * cell_of(row, inertial));
    return count >= 2;
}

struct score {
    double factor, error; // of predictions; geometric standard error
    int trials;
};

static struct score score_of(const cJSON *table, const struct model *model)
{
    int power = column_of(table, "spectrum_power"), predicted = column_of(table, model->column);
    double sum = 0, sum2 = 0;
    struct score score = {.factor = 1};
    const cJSON *row;
    cJSON_ArrayForEach(row, json_get(table, "rows"))
    {
        double off = log(cell_of(row, predicted) / cell_of(row, power));
        if (!isfinite(off))
            continue;
        sum += off;
        sum2 += off * off;
        score.trials++;
    }
    if (score.trials == 0)
        return score;
    double mean = sum / score.trials, square = sum2 / score.trials;
    if (model->scaled)
        score.factor = exp(-mean);
    score.error = exp(sqrt(fmax(0, model->scaled ? square - mean * mean : square)));
    return score;
}

/* Inertial number, measured power, predictions: a trial a line. */
static void write_data(struct picture *p, const cJSON *table, const struct score *scores)
{
    const cJSON *row;
    int power = column_of(table, "spectrum_power"), inertial = column_of(table, "inertial_number");
    fprintf(p->script, "$models << EOD\n");
    cJSON_ArrayForEach(row, json_get(table, "rows"))
    {
        if (!isfinite(cell_of(row, power) * cell_of(row, inertial)))
            continue;
        fprintf(p->script, "%.9g %.9g", cell_of(row, inertial), cell_of(row, power));
        for (size_t k = 0; k < MODELS; k++) {
            double predicted = cell_of(row, column_of(table, models[k].column)) * scores[k].factor;
            fprintf(p->script, isfinite(predicted) ? " %.9g" : " ?", predicted);
        }
        putc('\n', p->script);
    }
    fprintf(p->script, "EOD\n");
}

void plot_models_draw(struct picture *p, const cJSON *table)
{
    struct score scores[MODELS];
    for (size_t k = 0; k < MODELS; k++)
        scores[k] = score_of(table, &models[k]);
    write_data(p, table, scores);
    fprintf(p->script, "set logscale xy\nset format xy '%%.0e'\nset origin 0,0\nset size 0.4,0.88\nset xlabel 'inertial number'\n"
                       "set format x '%%.2g'\nset ylabel 'P_F^0 (N2/Hz)'\n"
                       "plot $models using 1:2 with points pt 7 ps 1.3 lc rgb '#000000' notitle\n");
    fprintf(p->script, "set origin 0.4,0\nset size 0.6,0.88\nset format x '%%.0e'\nset xlabel 'P_F^0 measured (N2/Hz)'\n"
                       "set ylabel 'predicted (N2/Hz), models as this project formulates them'\n"
                       "set key outside right top reverse Left samplen 1 title \"geometric\\nstandard error\"\nplot ");
    for (size_t k = 0; k < MODELS; k++)
        if (scores[k].trials > 0)
            fprintf(p->script, "$models using 2:%zu with points ps 1.3 %s title '%s: %.3g', ", k + 3, models[k].point,
                    models[k].title, scores[k].error);
    fprintf(p->script, "$models using 2:2 with lines dt 2 lc rgb '#000000' title 'equal'\n");
}

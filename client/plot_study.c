/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A study as a picture; see plot.h. Drawn from its table of trials (and, for a
 * search, its record): the same columns that `fetch` writes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "plot.h"
#include "plot_mobility.h"
#include "plot_models.h"
#include "plot_pair.h"
#include "spec/field.h"

enum { WIDTH = 900, HEIGHT = 600, SERIES_MAX = 24, GROUPS_MAX = 4, LABEL_MAX = 160 };

static const char *const colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999933"};
enum { COLOURS = sizeof colours / sizeof *colours };

static void heading(struct picture *p, const cJSON *record, const char *command)
{
    char text[200];
    const char *title = json_text(record, "title"), *conclusion = json_text(record, "conclusion");
    snprintf(text, sizeof text, "%.20s  %.20s  %.20s  %.20s", json_text(record, "id"), json_text(record, "kind"),
             json_text(record, "state"), conclusion ? conclusion : "");
    picture_title(p, command, text, title);
}

/* ---- a search ---- */

/* Trials in groups by what they answered: each is a data block of round, value. */
static const struct group {
    const char *block, *answer, *label, *style;
} groups[] = {{"$raised", "raise", "raises the low end", "pt 9 ps 1.6 lc rgb '#009e73'"},
              {"$lowered", "lower", "lowers the high end", "pt 11 ps 1.6 lc rgb '#d55e00'"},
              {"$tried", "done", "tried", "pt 7 ps 1.2 lc rgb '#444444'"},
              {"$other", NULL, "no answer", "pt 2 ps 1.2 lc rgb '#999999'"}};
enum { GROUPS = sizeof groups / sizeof *groups };

static int group_of(const char *answer)
{
    int k = 0;
    while (groups[k].answer && (!answer || strcmp(groups[k].answer, answer) != 0))
        k++;
    return k;
}

static void write_answers(struct picture *p, const cJSON *record, const char *over, int counts[GROUPS])
{
    const cJSON *trial;
    double shift = cJSON_GetArraySize(json_get(record, "answers")) > 1 ? 0.08 : 0;
    for (int g = 0; g < GROUPS; g++) {
        counts[g] = 0;
        fprintf(p->script, "%s << EOD\n", groups[g].block);
        cJSON_ArrayForEach(trial, json_get(record, "trials"))
        {
            const char *answer = json_text(trial, "answer");
            if (group_of(answer) != g || (answer && strcmp(answer, "running") == 0))
                continue;
            fprintf(p->script, "%.9g %.17g\n", json_number(trial, "round", 0) + shift * json_number(trial, "replica", 0),
                    json_number(json_get(trial, "values"), over, NAN));
            counts[g]++;
        }
        fprintf(p->script, "EOD\n");
    }
}

static void write_brackets(struct picture *p, const cJSON *record, int replicas)
{
    const cJSON *row;
    for (int r = 0; r < replicas; r++) {
        fprintf(p->script, "$bracket%d << EOD\n", r);
        cJSON_ArrayForEach(row, json_get(record, "bracket")) if ((int)json_number(row, "replica", 0) == r)
            fprintf(p->script, "%.9g %.17g %.17g\n", json_number(row, "round", 0), json_number(row, "low", NAN),
                    json_number(row, "high", NAN));
        fprintf(p->script, "EOD\n");
    }
}

static void describe_answer(const cJSON *record, char *out, size_t size)
{
    const cJSON *spread = json_get(record, "spread");
    const char *unit = json_text(record, "unit");
    const double mean = json_number(spread, "mean", NAN), replicas = json_number(spread, "replicas", 0);
    *out = 0;
    if (replicas > 1)
        snprintf(out, size, "%.3g ± %.2g %.20s over %.0f replicas", mean, json_number(spread, "deviation", NAN), unit ? unit : "",
                 replicas);
    else if (replicas > 0)
        snprintf(out, size, "%.6g %.20s", mean, unit ? unit : "");
}

static int last_round(const cJSON *record)
{
    const cJSON *trial;
    double last = 0;
    cJSON_ArrayForEach(trial, json_get(record, "trials")) last = fmax(last, json_number(trial, "round", 0));
    return (int)last;
}

static enum outcome draw_search(const cJSON *record, struct picture *p, struct scree_error *err)
{
    const char *over = json_text(record, "over"), *unit = json_text(record, "unit");
    char label[LABEL_MAX];
    int counts[GROUPS], replicas = cJSON_GetArraySize(json_get(record, "answers"));
    if (!over || cJSON_GetArraySize(json_get(record, "bracket")) == 0)
        return outcome_fail(err, OUTCOME_REFUSED, "%.20s has no bracket to draw yet", json_text(record, "id"));
    write_answers(p, record, over, counts);
    write_brackets(p, record, replicas);
    heading(p, record, "set title");
    snprintf(label, sizeof label, "%.100s%s%.20s%s", over, unit && *unit ? " (" : "", unit ? unit : "", unit && *unit ? ")" : "");
    fprintf(p->script, "set ylabel ");
    picture_quote(p, label);
    fprintf(p->script,
            "\nset xlabel 'round (0: the ends of the bracket)'\nset xtics 1\nset xrange [-0.4:%d.4]\n"
            "set offsets 0, 0, graph 0.03, graph 0.03\nset key inside right top reverse Left samplen 2\nplot ",
            last_round(record));
    for (int r = 0; r < replicas; r++)
        fprintf(p->script, "$bracket%d using 1:2:3 with filledcurves fc rgb '%s' fs transparent solid 0.12 noborder notitle, ", r,
                colours[r % COLOURS]);
    for (int r = 0; r < replicas; r++)
        for (int end = 2; end <= 3; end++) {
            fprintf(p->script, "$bracket%d using 1:%d with lines lw 1.8 dt %d lc rgb '%s' ", r, end, r % 4 + 1,
                    colours[r % COLOURS]);
            if (end == 2 && replicas > 1)
                fprintf(p->script, "title 'bracket, replica %d', ", r);
            else
                fprintf(p->script, end == 2 ? "title 'bracket', " : "notitle, ");
        }
    for (int g = 0; g < GROUPS; g++)
        if (counts[g] > 0)
            fprintf(p->script, "%s using 1:2 with points %s title '%s', ", groups[g].block, groups[g].style, groups[g].label);
    describe_answer(record, label, sizeof label);
    double mean = json_number(json_get(record, "spread"), "mean", NAN);
    if (isfinite(mean)) {
        fprintf(p->script, "%.17g with lines dt 2 lc rgb '#000000' title ", mean);
        picture_quote(p, label);
        fprintf(p->script, ", ");
    }
    fprintf(p->script, "NaN notitle\n");
    return OUTCOME_DONE;
}

/* ---- a sweep ---- */

struct columns {
    const cJSON *heads, *rows;
    int x, y;
    int groups[GROUPS_MAX], group_count; // columns in which trials differ beside x
    int parameters;                      // columns 2 .. 2 + parameters - 1
};

static const char *name_of(const struct columns *c, int column)
{
    const char *name = json_text(cJSON_GetArrayItem(c->heads, column), "name");
    return name ? name : "?";
}

static int find_column(const struct columns *c, const char *name)
{
    for (int k = 0; k < cJSON_GetArraySize(c->heads); k++)
        if (strcmp(name_of(c, k), name) == 0)
            return k;
    return -1;
}

/* Whether its cells are numbers (or empty), and not all the same. */
static bool tells_something(const struct columns *c, int column, bool words)
{
    const cJSON *row, *first = NULL;
    bool differs = false;
    cJSON_ArrayForEach(row, c->rows)
    {
        const cJSON *cell = cJSON_GetArrayItem(row, column);
        if (cJSON_IsNull(cell))
            continue;
        if (!words && !cJSON_IsNumber(cell))
            return false;
        if (first && !cJSON_Compare(first, cell, true))
            differs = true;
        first = first ? first : cell;
    }
    return differs;
}

static enum outcome no_column(const struct columns *c, const char *name, struct scree_error *err)
{
    const char *names[257], *near;
    int count = 0;
    for (; count < cJSON_GetArraySize(c->heads) && count < 256; count++)
        names[count] = name_of(c, count);
    names[count] = NULL;
    near = word_nearest(names, name);
    return outcome_fail(err, OUTCOME_REFUSED, "the table has no column \"%.80s\"%s%.80s%s", name, near ? "; did you mean \"" : "",
                        near ? near : "", near ? "\"?" : "");
}

/* Settles what is drawn against what. */
static enum outcome choose(struct columns *c, const struct plot_sweep *how, struct scree_error *err)
{
    static const char *const telling[] = {"mean_velocity", "restitution"}; // before what follows from the spec alone
    int last = 2, count = cJSON_GetArraySize(c->heads), first_number;
    while (last < count && strcmp(name_of(c, last), "job") != 0)
        last++;
    bool extra_seed = last > 2 && strcmp(name_of(c, last - 1), "seed") == 0;
    if (find_column(c, "round") >= 0)
        last = find_column(c, "round"); // a search: what follows is its own
    else
        last -= extra_seed; // it tells replicas apart, and is drawn against only when nothing else is there
    c->parameters = last - 2;
    first_number = find_column(c, "wall") + 1;
    c->x = how->x ? find_column(c, how->x) : -1;
    c->y = how->y ? find_column(c, how->y) : -1;
    int by = how->by ? find_column(c, how->by) : -1;
    if (how->x && c->x < 0)
        return no_column(c, how->x, err);
    if (how->y && c->y < 0)
        return no_column(c, how->y, err);
    if (how->by && by < 0)
        return no_column(c, how->by, err);
    for (int k = 2; k < last && c->x < 0; k++)
        c->x = tells_something(c, k, false) ? k : -1;
    if (c->x < 0) // only replicas, or only words: against the seed or the trial's number
        c->x = extra_seed && tells_something(c, last, false) ? last : 0;
    for (size_t k = 0; k < sizeof telling / sizeof *telling && c->y < 0; k++) {
        int column = find_column(c, telling[k]);
        c->y = column >= 0 && tells_something(c, column, false) ? column : -1;
    }
    for (int k = first_number; k < count && c->y < 0; k++)
        c->y = tells_something(c, k, false) ? k : -1;
    if (c->y < 0)
        return outcome_fail(err, OUTCOME_REFUSED, "the trials that have ended do not differ in any number yet");
    for (int k = 2; k < last && c->group_count < GROUPS_MAX; k++)
        if (how->by ? k == by : k != c->x && tells_something(c, k, true))
            c->groups[c->group_count++] = k;
    return OUTCOME_DONE;
}

/* "nz 8, partner plane": what a trial's line has in common. */
static void series_label(const struct columns *c, const cJSON *row, char *out, size_t size)
{
    size_t length = 0;
    *out = 0;
    for (int g = 0; g < c->group_count && length < size; g++) {
        const cJSON *cell = cJSON_GetArrayItem(row, c->groups[g]);
        const char *name = name_of(c, c->groups[g]), *dot = strrchr(name, '.');
        char number[TEXT_MAX];
        length += (size_t)snprintf(out + length, size - length, "%s%s %.40s", length ? ", " : "", dot ? dot + 1 : name,
                                   cJSON_IsNumber(cell)   ? text_number(cell->valuedouble, number)
                                   : cJSON_IsString(cell) ? cell->valuestring
                                   : cJSON_IsBool(cell)   ? (cJSON_IsTrue(cell) ? "yes" : "no")
                                                          : "-");
    }
}

static bool number_at(const cJSON *row, int column, double *out)
{
    const cJSON *cell = cJSON_GetArrayItem(row, column);
    *out = cJSON_IsNumber(cell) ? cell->valuedouble : NAN;
    return cJSON_IsNumber(cell);
}

/* A trial that is drawn. */
struct point {
    int series;
    double x, y;
};

static int by_place(const void *left, const void *right)
{
    const struct point *a = left, *b = right;
    if (a->series != b->series)
        return a->series < b->series ? -1 : 1;
    return a->x < b->x ? -1 : a->x > b->x;
}

/* The trials that have both numbers, by series and x; returns how many. `labels` are those of the series. */
static size_t collect(const struct columns *c, struct point *points, char labels[SERIES_MAX][LABEL_MAX], int *series)
{
    const cJSON *row;
    size_t count = 0;
    *series = 0;
    cJSON_ArrayForEach(row, c->rows)
    {
        char label[LABEL_MAX];
        struct point point;
        if (!number_at(row, c->x, &point.x) || !number_at(row, c->y, &point.y))
            continue;
        series_label(c, row, label, sizeof label);
        for (point.series = 0; point.series < *series && strcmp(labels[point.series], label) != 0;)
            point.series++;
        if (point.series == SERIES_MAX)
            continue;
        if (point.series == *series)
            memcpy(labels[(*series)++], label, sizeof label);
        points[count++] = point;
    }
    qsort(points, count, sizeof *points, by_place);
    return count;
}

/* Each series as a block of its points and one of its means over every x. */
static void write_series(struct picture *p, const struct point *points, size_t count, int series)
{
    for (int s = 0; s < series; s++) {
        fprintf(p->script, "$points%d << EOD\n", s);
        for (size_t k = 0; k < count; k++)
            if (points[k].series == s)
                fprintf(p->script, "%.17g %.17g\n", points[k].x, points[k].y);
        fprintf(p->script, "EOD\n$means%d << EOD\n", s);
        for (size_t k = 0, next; k < count; k = next) {
            double sum = 0;
            for (next = k; next < count && by_place(&points[k], &points[next]) == 0; next++)
                sum += points[next].y;
            if (points[k].series == s)
                fprintf(p->script, "%.17g %.17g\n", points[k].x, sum / (double)(next - k));
        }
        fprintf(p->script, "EOD\n");
    }
}

/* y = factor x^exponent, least squares in the logarithms; factor 0 where there are not two places to fit. */
struct power {
    double factor, exponent;
};
static void fit_power(const struct point *points, size_t count, int series, struct power *out)
{
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (size_t k = 0; k < count; k++) {
        if (points[k].series != series || !(points[k].x > 0 && points[k].y > 0))
            continue;
        double x = log(points[k].x), y = log(points[k].y);
        n++;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    double spread = n * sxx - sx * sx;
    *out = (struct power){0};
    if (!(spread > 1e-9 * sxx))
        return;
    out->exponent = (n * sxy - sx * sy) / spread;
    out->factor = exp((sy - out->exponent * sx) / n);
}

/* Lines of power laws that somebody gives: "2,1 3.4,0.65". */
static enum outcome draw_beside(struct picture *p, const char *laws, struct scree_error *err)
{
    for (const char *at = laws; at && *at;) {
        struct power law;
        int length = 0;
        if (sscanf(at, " %lf,%lf %n", &law.factor, &law.exponent, &length) != 2 || !(law.factor > 0) || !isfinite(law.factor) ||
            !isfinite(law.exponent))
            return outcome_fail(err, OUTCOME_REFUSED,
                                "\"%.40s\" is no power law: FACTOR,EXPONENT, the factor above 0, and spaces between laws", at);
        fprintf(p->script, "%.9g * x**%.9g with lines lw 1.4 dt 4 lc rgb '#777777' title 'beside: %.3g x^%.3g', ", law.factor,
                law.exponent, law.factor, law.exponent);
        at += length;
    }
    return OUTCOME_DONE;
}

/* A logarithmic axis where all is above 0 and it is wished for or spans more than a factor of fifty. */
static void set_axis(struct picture *p, const struct columns *c, int column, char axis, bool log)
{
    const cJSON *row;
    double least = INFINITY, most = -INFINITY, value;
    char label[LABEL_MAX];
    const char *unit = json_text(cJSON_GetArrayItem(c->heads, column), "unit");
    cJSON_ArrayForEach(row, c->rows) if (number_at(row, column, &value))
    {
        least = fmin(least, value);
        most = fmax(most, value);
    }
    snprintf(label, sizeof label, "%.100s%s%.20s%s", name_of(c, column), unit && *unit ? " (" : "", unit ? unit : "",
             unit && *unit ? ")" : "");
    fprintf(p->script, "set %clabel ", axis);
    picture_quote(p, label);
    putc('\n', p->script);
    if (log && least > 0)
        fprintf(p->script, "set logscale %c\nset %crange [%.9g:%.9g]\nset %ctics add (0.2, 0.5, 2, 5, 20, 50)\n", axis, axis,
                0.8 * least, 1.25 * most, axis);
    else if (least > 0 && most > 50 * least)
        fprintf(p->script, "set logscale %c\nset format %c '%%.1e'\n", axis, axis);
    else
        fprintf(p->script, "set %srange [] noextend\nset offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05\n",
                axis == 'x' ? "x" : "y");
}

static enum outcome draw_sweep(const cJSON *record, const cJSON *table, const struct plot_sweep *how, struct picture *p,
                               struct scree_error *err)
{
    struct columns c = {.heads = json_get(table, "columns"), .rows = json_get(table, "rows")};
    char labels[SERIES_MAX][LABEL_MAX];
    struct power fits[SERIES_MAX] = {{0}};
    int series;
    enum outcome outcome = choose(&c, how, err);
    struct point *points = outcome ? NULL : calloc((size_t)cJSON_GetArraySize(c.rows) + 1, sizeof *points);
    if (!points)
        return outcome ? outcome : outcome_fail(err, OUTCOME_FAILED, "no memory for a picture");
    size_t count = collect(&c, points, labels, &series);
    write_series(p, points, count, series);
    if (how->log)
        for (int k = 0; k < series; k++)
            fit_power(points, count, k, &fits[k]);
    free(points);
    heading(p, record, "set title");
    set_axis(p, &c, c.x, 'x', how->log);
    set_axis(p, &c, c.y, 'y', how->log);
    fprintf(p->script, "set key outside right top reverse Left\nplot ");
    for (int k = 0; k < series; k++) {
        if (c.x >= 2 && c.x < 2 + c.parameters) // means over a measured number would join what does not belong together
            fprintf(p->script, "$means%d using 1:2 with lines lw 1.2 lc rgb '%s' dt %d notitle, ", k, colours[k % COLOURS],
                    1 + k / COLOURS);
        fprintf(p->script, "$points%d using 1:2 with points pt %d ps 1.2 lc rgb '%s' ", k, 7 - 2 * (k / COLOURS % 3),
                colours[k % COLOURS]);
        fprintf(p->script, *labels[k] ? "title " : "notitle");
        if (*labels[k])
            picture_quote(p, labels[k]);
        fprintf(p->script, ", ");
        if (fits[k].factor > 0)
            fprintf(p->script, "%.9g * x**%.9g with lines lw 1.2 lc rgb '%s' dt 2 title '%.2f x^%.2f', ", fits[k].factor,
                    fits[k].exponent, colours[k % COLOURS], fits[k].factor, fits[k].exponent);
    }
    outcome = draw_beside(p, how->beside, err);
    fprintf(p->script, "NaN notitle\n");
    return outcome;
}

/* Sweeps that a paper has a figure of: drawn like it, unless columns are named. */
static const struct special {
    bool (*fits)(const cJSON *table);
    void (*draw)(struct picture *picture, const cJSON *table);
    int width, height;
} specials[] = {{plot_models_fit, plot_models_draw, WIDTH, HEIGHT},
                {plot_mobility_fit, plot_mobility_draw, PLOT_MOBILITY_WIDTH, PLOT_MOBILITY_HEIGHT}};

static const struct special *special_of(const cJSON *table)
{
    for (size_t k = 0; table && k < sizeof specials / sizeof *specials; k++)
        if (specials[k].fits(table))
            return &specials[k];
    return NULL;
}

enum outcome plot_study(struct link *link, const cJSON *record, const struct plot_sweep *how, const char *file,
                        struct scree_error *err)
{
    struct picture picture = {0};
    cJSON *table = NULL;
    const char *kind = json_text(record, "kind"), *id = json_text(record, "id");
    bool named = how->x || how->y, search = kind && strcmp(kind, "sweep") != 0 && !named;
    bool pair = !named && !search && plot_pair_fits(record);
    enum outcome outcome = search || pair ? OUTCOME_DONE : link_job(link, "table", id ? id : "", &table, err);
    const struct special *special = named ? NULL : special_of(table);
    if (!outcome)
        outcome = picture_start(&picture, file, special ? special->width : WIDTH, special ? special->height : HEIGHT, err);
    if (!outcome && search)
        outcome = draw_search(record, &picture, err);
    else if (!outcome && pair)
        outcome = plot_pair_draw(link, record, &picture, err);
    else if (!outcome && special) {
        heading(&picture, record, "set multiplot title");
        special->draw(&picture, table);
        fprintf(picture.script, "unset multiplot\n");
    } else if (!outcome)
        outcome = draw_sweep(record, table, how, &picture, err);
    if (!outcome)
        outcome = picture_draw(&picture, err);
    picture_free(&picture);
    cJSON_Delete(table);
    return outcome;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See progress.h.
 *
 *     j1  ████▏░░░  52 %  t 4.16 / 8 s  ETA 38 s  84.2 M grain-steps/s  Fz ▂▃▅▄▃▄▂▃▅▄▃▄
 *
 * A wide terminal gets a longer bar, more of the force and its last value; on one
 * that is too narrow what does not fit is left out from the right. */
#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"

enum {
    BAR_CELLS = 8,
    BAR_CELLS_WIDE = 16,
    WIDE = 110,
    SPARKS_LEAST = 4,
    LINE_EVERY_S = 10,
    FIRST_LINE_S = 2,
    LINE_MAX = 1024,
    TRIALS_SHOWN = 8
};

static int drawn; // lines that stand on the terminal

void progress_start(struct progress *progress)
{
    *progress = (struct progress){.told = now_s() + FIRST_LINE_S - LINE_EVERY_S};
}

void progress_force(struct progress *progress, double mean, double samples)
{
    if (!isfinite(mean))
        return;
    progress->sum += mean * samples;
    progress->weight += samples;
}

static void push_spark(struct progress *progress)
{
    if (progress->weight <= 0)
        return;
    if (progress->spark_count == PROGRESS_SPARKS) {
        progress->spark_count--;
        memmove(progress->sparks, progress->sparks + 1, sizeof progress->sparks - sizeof *progress->sparks);
    }
    progress->sparks[progress->spark_count++] = progress->sum / progress->weight;
    progress->sum = progress->weight = 0;
}

void progress_erase(void)
{
    if (!drawn)
        return;
    for (int line = 1; line < drawn; line++)
        fputs("\r\x1b[K\x1b[A", stderr);
    fputs("\r\x1b[K", stderr);
    fflush(stderr);
    drawn = 0;
}

/* A part of the line, if it fits into the columns that are left. */
static void append(char *line, int *left, const char *part)
{
    int width = text_width(part) + (*line ? 2 : 0);
    if (width > *left || strlen(line) + strlen(part) + 3 > LINE_MAX) {
        *left = 0; // nothing further to the right either
        return;
    }
    strcat(line, *line ? "  " : "");
    strcat(line, part);
    *left -= width;
}

static void draw_bar(char *out, double fraction, int cells)
{
    static const char *const eighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
    int full = (int)(fraction * cells * 8), cell = 0;
    *out = 0;
    if (!output_unicode()) {
        for (; cell < cells; cell++)
            strcat(out, cell < full / 8 ? "#" : ".");
        return;
    }
    for (; cell < full / 8; cell++)
        strcat(out, "█");
    if (full % 8 && cell++ < cells)
        strcat(out, eighths[full % 8]);
    for (; cell < cells; cell++)
        strcat(out, "░");
}

/* The magnitude of the force in its last `count` sparks, between the least and the largest of them. */
static void draw_sparks(char *out, const struct progress *progress, int count)
{
    static const char *const blocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    static const char *const ascii[] = {"_", ".", "-", "=", "+", "*", "%", "#"};
    double low = INFINITY, high = 0;
    int first = progress->spark_count > count ? progress->spark_count - count : 0;
    *out = 0;
    for (int k = first; k < progress->spark_count; k++) {
        low = fmin(low, fabs(progress->sparks[k]));
        high = fmax(high, fabs(progress->sparks[k]));
    }
    for (int k = first; k < progress->spark_count; k++) {
        double level = high > low ? (fabs(progress->sparks[k]) - low) / (high - low) : 0.5;
        strcat(out, (output_unicode() ? blocks : ascii)[(int)(level * 7.999)]);
    }
}

/* Columns that are left for sparks behind "Fz ". */
static int spark_room(int left)
{
    return left - 2 - text_width("Fz ");
}

/* The force: sparks as far as there is room, its last value where that is plenty. */
static void append_force(char *line, int *left, const struct progress *progress, bool terminal)
{
    char part[512], sparks[PROGRESS_SPARKS * 4 + 1], value[TEXT_MAX];
    snprintf(value, sizeof value, "%.3g N", progress->sparks[progress->spark_count - 1]);
    int room = spark_room(*left), beside = room - text_width(value) - 1;
    bool both = beside >= PROGRESS_SPARKS / 2;
    if (terminal && room < SPARKS_LEAST)
        return;
    draw_sparks(sparks, progress, both ? beside : room);
    if (!terminal)
        snprintf(part, sizeof part, "Fz %s", value);
    else
        snprintf(part, sizeof part, "Fz %s%s%s", sparks, both ? " " : "", both ? value : "");
    append(line, left, part);
}

static double fraction_of(const cJSON *job)
{
    double fraction = json_number(job, "progress", 0);
    return fraction >= 0 && fraction <= 1 ? fraction : 0;
}

/* Everything before the force; returns the columns that are left. */
static int describe_run(const cJSON *job, bool terminal, bool with_time, char line[LINE_MAX])
{
    char part[512], bar[128] = "", text[TEXT_MAX];
    const char *id = json_text(job, "id"), *state = json_text(job, "state");
    bool running = state && strcmp(state, "running") == 0;
    int width = terminal ? output_width() : LINE_MAX, left = width - 1;
    *line = 0;
    snprintf(part, sizeof part, "%.20s%s%.12s", id ? id : "?", terminal && running ? "" : " ",
             terminal && running ? ""
             : state             ? state
                                 : "?");
    append(line, &left, part);
    if (state && strcmp(state, "queued") == 0)
        return 0;
    if (terminal)
        draw_bar(bar, fraction_of(job), width >= WIDE ? BAR_CELLS_WIDE : BAR_CELLS);
    snprintf(part, sizeof part, "%s%3.0f %%", bar, 100 * fraction_of(job));
    append(line, &left, part);
    if (with_time) {
        snprintf(part, sizeof part, "t %.3g / %.3g s", json_number(job, "time_s", 0), json_number(job, "end_s", 0));
        append(line, &left, part);
    }
    if (json_number(job, "eta_s", -1) >= 0) {
        snprintf(part, sizeof part, "ETA %s", text_duration(json_number(job, "eta_s", -1), text));
        append(line, &left, part);
    }
    if (json_number(job, "grain_steps_per_s", 0) > 0)
        append(line, &left, text_rate(json_number(job, "grain_steps_per_s", 0), text));
    return left;
}

static void describe(const struct progress *progress, const cJSON *job, bool terminal, char line[LINE_MAX])
{
    int left = describe_run(job, terminal, true, line);
    if (progress->spark_count == 0)
        return;
    /* The force is worth more than the time, which the bar shows too. */
    if (terminal && spark_room(left) < SPARKS_LEAST)
        left = describe_run(job, terminal, false, line);
    append_force(line, &left, progress, terminal);
}

void progress_show(struct progress *progress, const cJSON *job)
{
    char line[LINE_MAX];
    bool terminal = output_progress();
    if (!terminal && now_s() - progress->told < LINE_EVERY_S)
        return;
    push_spark(progress);
    describe(progress, job, terminal, line);
    if (!terminal) {
        progress->told = now_s();
        say("%s", line);
        return;
    }
    fputs("\r\x1b[K", stderr);
    put_clean(stderr, line);
    fflush(stderr);
    drawn = 1;
}

/* ---- studies ---- */

/* The bracket of a search, the trials of a sweep: what a study is about. */
static void describe_study(const cJSON *study, bool terminal, char line[LINE_MAX])
{
    char part[512], bar[128] = "", text[TEXT_MAX];
    const cJSON *jobs = json_get(study, "jobs"), *answer;
    const char *id = json_text(study, "id"), *kind = json_text(study, "kind");
    int width = terminal ? output_width() : LINE_MAX, left = width - 1;
    *line = 0;
    snprintf(part, sizeof part, "%.20s %.12s", id ? id : "?", kind ? kind : "?");
    append(line, &left, part);
    if (terminal)
        draw_bar(bar, fraction_of(study), width >= WIDE ? BAR_CELLS_WIDE : BAR_CELLS);
    snprintf(part, sizeof part, "%s%3.0f %%", bar, 100 * fraction_of(study));
    append(line, &left, part);
    if (json_number(study, "eta_s", -1) >= 0) {
        snprintf(part, sizeof part, "ETA %s", text_duration(json_number(study, "eta_s", -1), text));
        append(line, &left, part);
    }
    double done = json_number(jobs, "done", 0), total = json_number(study, "total", 0);
    snprintf(part, sizeof part, total > 0 ? "%.0f of %.0f trials" : "%.0f trials", done, total);
    append(line, &left, part);
    if (json_number(jobs, "failed", 0) > 0) {
        snprintf(part, sizeof part, "%.0f failed", json_number(jobs, "failed", 0));
        append(line, &left, part);
    }
    cJSON_ArrayForEach(answer, json_get(study, "answers"))
    {
        snprintf(part, sizeof part, "%.5g..%.5g", json_number(answer, "low", NAN), json_number(answer, "high", NAN));
        append(line, &left, part);
    }
}

/* "   j12  ████▏░░░ 52 %  t 4.16 / 20 s  material.mu_t = 0.234" */
static void describe_trial(const cJSON *trial, char line[LINE_MAX])
{
    char part[512], bar[128] = "";
    const char *job = json_text(trial, "job"), *state = json_text(trial, "state");
    const cJSON *value;
    int left = output_width() - 1;
    snprintf(line, LINE_MAX, "  ");
    snprintf(part, sizeof part, "%.20s", job ? job : "?");
    append(line, &left, part);
    draw_bar(bar, fraction_of(trial), BAR_CELLS);
    snprintf(part, sizeof part, "%s%3.0f %%", bar, 100 * fraction_of(trial));
    append(line, &left, state && strcmp(state, "running") == 0 ? part : state ? state : "?");
    snprintf(part, sizeof part, "t %.3g / %.3g s", json_number(trial, "time_s", 0), json_number(trial, "end_s", 0));
    append(line, &left, part);
    cJSON_ArrayForEach(value, json_get(trial, "values"))
    {
        char *text = json_print(value, false);
        snprintf(part, sizeof part, "%.100s = %.60s", value->string, text ? text : "?");
        append(line, &left, part);
        free(text);
    }
}

void progress_show_study(struct progress *progress, const cJSON *study)
{
    char line[LINE_MAX];
    const cJSON *trial;
    int lines = 1;
    bool terminal = output_progress();
    if (!terminal && now_s() - progress->told < LINE_EVERY_S)
        return;
    describe_study(study, terminal, line);
    if (!terminal) {
        progress->told = now_s();
        say("%s", line);
        return;
    }
    progress_erase();
    put_clean(stderr, line);
    cJSON_ArrayForEach(trial, json_get(study, "trials"))
    {
        if (lines > TRIALS_SHOWN)
            break;
        describe_trial(trial, line);
        putc('\n', stderr);
        put_clean(stderr, line);
        lines++;
    }
    fflush(stderr);
    drawn = lines;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See picture.h. The script goes through a temporary file without a name, so that
 * gnuplot cannot wait for us while we wait for it. */
#include "picture.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "output.h"

extern char **environ;

static bool ends_in(const char *file, const char *ending)
{
    size_t length = strlen(file), tail = strlen(ending);
    return length > tail && strcmp(file + length - tail, ending) == 0;
}

enum outcome picture_start(struct picture *p, const char *file, int width, int height, struct scree_error *err)
{
    *p = (struct picture){.size = 0};
    bool svg = ends_in(file, ".svg");
    if (!svg && !ends_in(file, ".png"))
        return outcome_fail(err, OUTCOME_REFUSED, "a picture's name ends in .png or .svg, which \"%.200s\" does not", file);
    if (snprintf(p->file, sizeof p->file, "%s", file) >= (int)sizeof p->file ||
        snprintf(p->part, sizeof p->part, "%s.part-%ld", file, (long)getpid()) >= (int)sizeof p->part)
        return outcome_fail(err, OUTCOME_REFUSED, "the path of the picture is too long");
    /* gnuplot would write to our stdout what it cannot write to its file. */
    FILE *try = fopen(p->part, "we");
    if (!try)
        return outcome_fail(err, OUTCOME_REFUSED, "cannot write the picture %s: %s", file, strerror(errno));
    fclose(try);
    if (!(p->script = open_memstream(&p->text, &p->size)))
        return outcome_fail(err, OUTCOME_FAILED, "no memory for a picture");
    fprintf(p->script, "set encoding utf8\n");
    if (svg)
        fprintf(p->script, "set terminal svg size %d,%d dynamic noenhanced font 'sans,13' background '#ffffff'\n", width, height);
    else
        fprintf(p->script, "set terminal pngcairo size %d,%d noenhanced font 'sans,11' background '#ffffff'\n", width, height);
    fprintf(p->script, "set output ");
    picture_quote(p, p->part);
    fprintf(
        p->script,
        "\nset border 3 lc rgb '#444444'\nset tics nomirror\nset grid lc rgb '#dddddd' lt 1 lw 0.7\nset datafile missing '?'\n");
    return OUTCOME_DONE;
}

void picture_quote(struct picture *p, const char *text)
{
    putc('\'', p->script);
    for (; *text; text++) { // within single quotes only they themselves mean anything
        if ((unsigned char)*text < 0x20 || *text == 0x7f)
            continue;
        if (*text == '\'')
            putc('\'', p->script);
        putc(*text, p->script);
    }
    putc('\'', p->script);
}

void picture_title(struct picture *p, const char *command, const char *first, const char *second)
{
    enum { FITS = 96 }; // characters
    char cut[4 * FITS + 8];
    size_t at = 0;
    int columns = 0;
    for (; second && second[at] && at < 4 * FITS && columns < FITS; at++) {
        columns += (second[at + 1] & 0xc0) != 0x80; // the last byte of a character
        cut[at] = second[at];
    }
    snprintf(cut + at, sizeof cut - at, "%s", second && second[at] ? "..." : "");
    fprintf(p->script, "%s ", command);
    picture_quote(p, first);
    if (*cut) {
        fprintf(p->script, ".\"\\n\".");
        picture_quote(p, cut);
    }
    putc('\n', p->script);
}

/* Runs gnuplot on the script in `fd`; what it says goes to our stderr. */
static enum outcome run_gnuplot(int fd, struct scree_error *err)
{
    static char name[] = "gnuplot", dash[] = "-";
    char *const words[] = {name, dash, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int status;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fd, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO); // what it has to say is no data of ours
    int failed = posix_spawnp(&pid, name, &actions, NULL, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed == ENOENT) {
        outcome_fail(err, OUTCOME_FAILED, "pictures are drawn by gnuplot, which is not installed here");
        scree_hint(err, "on Debian: apt-get install gnuplot-nox");
        return OUTCOME_FAILED;
    }
    if (failed)
        return outcome_fail(err, OUTCOME_FAILED, "cannot start gnuplot: %s", strerror(failed));
    while (waitpid(pid, &status, 0) < 0)
        if (errno != EINTR)
            return outcome_fail(err, OUTCOME_FAILED, "lost sight of gnuplot: %s", strerror(errno));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return outcome_fail(err, OUTCOME_FAILED, "gnuplot could not draw the picture");
    return OUTCOME_DONE;
}

enum outcome picture_draw(struct picture *p, struct scree_error *err)
{
    FILE *file = tmpfile();
    enum outcome outcome = OUTCOME_DONE;
    fprintf(p->script, "\nset output\n");
    if (fflush(p->script) != 0 || !file || fwrite(p->text, 1, p->size, file) != p->size || fflush(file) != 0 ||
        fseek(file, 0, SEEK_SET) != 0)
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot write the script of a picture: %s", strerror(errno));
    if (!outcome)
        outcome = run_gnuplot(fileno(file), err);
    if (file)
        fclose(file);
    if (!outcome && rename(p->part, p->file) != 0)
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot write %s: %s", p->file, strerror(errno));
    return outcome;
}

void picture_free(struct picture *p)
{
    if (p->script)
        fclose(p->script);
    if (*p->part)
        unlink(p->part);
    free(p->text);
    p->script = NULL;
    p->text = NULL;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A picture drawn by gnuplot, a program of Debian's: a script is written, gnuplot
 * reads it, and the file is put into place once it is whole. */
#ifndef SCREE_CLIENT_PICTURE_H
#define SCREE_CLIENT_PICTURE_H

#include <limits.h>
#include <stdio.h>

#include "cli.h"

struct picture {
    FILE *script; // what gnuplot will read
    char *text;
    size_t size;
    char file[PATH_MAX], part[PATH_MAX];
};

/* Starts a script for FILE, whose name ends in .png or .svg: OUTCOME_REFUSED if in anything else. The size is in pixels. */
enum outcome picture_start(struct picture *picture, const char *file, int width, int height, struct scree_error *err);

/* Writes text as a gnuplot string, in quotes. */
void picture_quote(struct picture *picture, const char *text);

/* "COMMAND 'first\nsecond'": a heading of two lines, the second cut to what fits. */
void picture_title(struct picture *picture, const char *command, const char *first, const char *second);

/* Lets gnuplot draw it. OUTCOME_FAILED says what is missing. */
enum outcome picture_draw(struct picture *picture, struct scree_error *err);

/* Throws away what picture_start made. */
void picture_free(struct picture *picture);

#endif

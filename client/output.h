/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Data on stdout, messages on stderr, and what the two can show.
 *
 * Text that came over the wire or out of a file may hold escape sequences;
 * everything here writes it without control characters. */
#ifndef SCREE_CLIENT_OUTPUT_H
#define SCREE_CLIENT_OUTPUT_H

#include <cjson/cJSON.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"

/* Looks once at locale, terminals and NO_COLOR. Call it first. */
void output_start(void);

bool output_progress(void); // stderr is a terminal that can rewrite its line
bool output_unicode(void);  // the locale's character set is UTF-8

enum colour { COLOUR_NONE, COLOUR_GOOD, COLOUR_BAD, COLOUR_BUSY, COLOUR_DIM, COLOUR_BOLD };
/* The escape sequence, or "" where `file` is no terminal or NO_COLOR is set. */
const char *colour_on(FILE *file, enum colour colour);
const char *colour_off(FILE *file, enum colour colour);
enum colour colour_of_state(const char *state);

/* A message on stderr: "scree: ..." and a newline. Takes away a progress line first. */
void say(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* The message and the hint of an error. */
void say_error(const struct scree_error *err);

/* Writes text without its control characters. */
void put_clean(FILE *file, const char *text);
/* One JSON value on one line of stdout. */
void put_json_line(const cJSON *tree);
/* The same indented. */
void put_json_pretty(const cJSON *tree);

/* Width of the terminal behind stderr, in columns. */
int output_width(void);
/* Columns that UTF-8 text takes, one a character. */
int text_width(const char *text);

enum { TEXT_MAX = 64 };
/* "84.2 M grain-steps/s" or "-" when there is nothing to tell; returns `out`. */
char *text_rate(double grain_steps_per_s, char out[TEXT_MAX]);
/* "0.8 s", "42 s", "3 min 05 s", "48 min", "7 h 12 min", "31 h"; "-" when negative or not finite. */
char *text_duration(double seconds, char out[TEXT_MAX]);
/* "12.4 MB" */
char *text_bytes(double bytes, char out[TEXT_MAX]);
/* "12,800,000" */
char *text_count(double count, char out[TEXT_MAX]);
/* Six significant digits. */
char *text_number(double value, char out[TEXT_MAX]);

/* Seconds on a clock that only goes forward. */
double now_s(void);

/* Closes stdout. A reader that has gone away (`| head`) is no failure; any other is. */
bool output_end(void);

#endif

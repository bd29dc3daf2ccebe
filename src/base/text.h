/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers as text, and what may stand in a text that came from outside. */
#ifndef SCREE_BASE_TEXT_H
#define SCREE_BASE_TEXT_H

#include <stddef.h>

enum { TEXT_REAL_MAX = 32 };

/* The shortest decimal that reads back to the same double, "nan" or "inf"; returns `out`. */
char *text_real(double value, char out[TEXT_REAL_MAX]);

/* Bytes of the UTF-8 sequence that starts at `text` and ends before `end`; 0 if there is none
 * (overlong, half a surrogate pair, above U+10FFFF, cut short). */
size_t text_utf8_length(const char *text, const char *end);

/* Makes a terminated text fit for a terminal, a log line and JSON: control characters
 * (C0, DEL, C1) and bytes that are not UTF-8 become "?". */
void text_clean(char *text);

#endif

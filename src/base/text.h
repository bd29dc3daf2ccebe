/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers as text. */
#ifndef SCREE_BASE_TEXT_H
#define SCREE_BASE_TEXT_H

enum { TEXT_REAL_MAX = 32 };

/* The shortest decimal that reads back to the same double, "nan" or "inf"; returns `out`. */
char *text_real(double value, char out[TEXT_REAL_MAX]);

#endif

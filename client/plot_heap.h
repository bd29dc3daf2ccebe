/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A row of a job's picture: how bodies collapse, beside what is published of it. */
#ifndef SCREE_CLIENT_PLOT_HEAP_H
#define SCREE_CLIENT_PLOT_HEAP_H

#include <stdio.h>

#include "reader.h"

struct plot_heap {
    FILE *script;
    size_t rows;
};

/* Rows of the stream as data of the script, which plot_heap_end closes; `context` is a struct plot_heap. */
void plot_heap_take(void *context, const struct reader_chunk *chunk);
void plot_heap_end(const struct plot_heap *heap);

/* The plots, between `low` and `low + high` of the picture's height. */
void plot_heap_draw(const struct plot_heap *heap, const cJSON *record, double low, double high);

#endif

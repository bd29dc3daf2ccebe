/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The library's one way to get arrays; see memory.h. */
#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { CACHE_LINE = 64 };

static _Thread_local unsigned long requests;

unsigned long memory_requests(void)
{
    return requests;
}

/* Unset memory on a cache line, NULL on overflow or lack of memory. */
static void *allocate(size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - CACHE_LINE)
        return NULL;
    bytes = (bytes + CACHE_LINE) / CACHE_LINE * CACHE_LINE;
    requests++;
    return aligned_alloc(CACHE_LINE, bytes);
}

void *memory_rows(size_t count, size_t size)
{
    void *rows = allocate(count, size);
    if (rows)
        memset(rows, 0, count * size);
    return rows;
}

enum scree_status memory_grow(void **array, size_t *room, size_t need, size_t size, struct scree_error *err)
{
    if (need <= *room)
        return SCREE_OK;
    size_t grown = *room + *room / 4;
    if (grown < need)
        grown = need + need / 8 + 16;
    void *larger = allocate(grown, size);
    if (!larger)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu elements of %zu bytes", grown, size);
    if (*array) {
        memcpy(larger, *array, *room * size);
        free(*array);
    }
    *array = larger;
    *room = grown;
    return SCREE_OK;
}

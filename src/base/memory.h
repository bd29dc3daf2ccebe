/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Aligned arrays with a stated size. Rows of four doubles are read as vectors,
 * so every array starts on a cache line. */
#ifndef SCREE_BASE_MEMORY_H
#define SCREE_BASE_MEMORY_H

#include <stddef.h>

#include "base/status.h"

/* Zeroed, on a cache line; released with free(). NULL when `count * size` overflows or there is no memory.
 * A count of 0 gives a valid pointer. */
void *memory_rows(size_t count, size_t size);

/* Makes room for at least `need` elements of `size` bytes in *array, which holds
 * *room now; grows by a quarter at least. Keeps the contents, leaves the new part unset. */
enum scree_status memory_grow(void **array, size_t *room, size_t need, size_t size, struct scree_error *err);

/* Number of times memory was asked for by this thread, for the test that a warm
 * step asks for none. */
unsigned long memory_requests(void);

#endif

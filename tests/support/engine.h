/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What tests of the engine of grains share: steps, and what they came to; any failure fails the test. */
#ifndef TEST_SUPPORT_ENGINE_H
#define TEST_SUPPORT_ENGINE_H

#include "unit.h"

#include "dem/dem.h"

static inline void advance(struct dem *dem, uint64_t steps)
{
    struct scree_error error = {0};
    must(dem_advance(dem, steps, &error), &error);
}

static inline struct view look(struct dem *dem)
{
    struct scree_error error = {0};
    struct view view;
    must(dem_view(dem, &view, &error), &error);
    return view;
}

#endif

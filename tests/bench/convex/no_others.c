/* SPDX-License-Identifier: GPL-3.0-or-later */
/* In place of others.cpp where FCL and libccd are not installed. */
#include "pairs.h"

const struct other others[1] = {{0}};
const int other_count = 0;

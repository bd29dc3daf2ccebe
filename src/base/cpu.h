/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which of the compiled kernels this machine can run. */
#ifndef SCREE_BASE_CPU_H
#define SCREE_BASE_CPU_H

#include "base/status.h"

/* Levels of the x86-64 psABI. */
enum cpu_isa { CPU_V2, CPU_V3, CPU_V4, CPU_ISA_COUNT };

/* "x86-64-v2", ... */
const char *cpu_isa_name(enum cpu_isa isa);

/* The best level that this machine has; SCREE_ISA in the environment lowers it. */
enum cpu_isa cpu_best(void);

int cpu_has(enum cpu_isa isa);

/* Picks by name; NULL is cpu_best(). SCREE_INVALID when the name is unknown or
 * the machine does not have it. */
enum scree_status cpu_choose(const char *name, enum cpu_isa *out, struct scree_error *err);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One CPU test at start, so that one binary runs everywhere at full speed. */
#include "base/cpu.h"

#include <stdlib.h>
#include <string.h>

static const char *const names[CPU_ISA_COUNT] = {"x86-64-v2", "x86-64-v3", "x86-64-v4"};

const char *cpu_isa_name(enum cpu_isa isa)
{
    return names[isa];
}

int cpu_has(enum cpu_isa isa)
{
    __builtin_cpu_init();
    switch (isa) {
    case CPU_V2:
        return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
    case CPU_V3:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2");
    case CPU_V4:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd");
    default:
        return 0;
    }
}

enum cpu_isa cpu_best(void)
{
    enum cpu_isa forced;
    const char *name = getenv("SCREE_ISA");
    if (name && *name && cpu_choose(name, &forced, NULL) == SCREE_OK)
        return forced;
    enum cpu_isa best = CPU_V2;
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++)
        if (cpu_has(isa))
            best = isa;
    return best;
}

enum scree_status cpu_choose(const char *name, enum cpu_isa *out, struct scree_error *err)
{
    if (!name) {
        *out = cpu_best();
        return SCREE_OK;
    }
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++) {
        if (strcmp(name, names[isa]) != 0)
            continue;
        if (!cpu_has(isa))
            return scree_fail(err, SCREE_INVALID, "isa", "this machine does not have the instruction set %s", name);
        *out = isa;
        return SCREE_OK;
    }
    return scree_fail(err, SCREE_INVALID, "isa", "unknown instruction set \"%s\": x86-64-v2, x86-64-v3 or x86-64-v4", name);
}

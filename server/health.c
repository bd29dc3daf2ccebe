/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See health.h. */
#include "health.h"

#include <stdio.h>
#include <string.h>
#include <sys/statvfs.h>

/* Bytes of a line "NAME:  N kB" of a file of /proc, 0 if there is none. */
static double read_kilobytes(const char *path, const char *name)
{
    char line[128];
    double kilobytes = 0;
    FILE *file = fopen(path, "re");
    while (file && fgets(line, sizeof line, file))
        if (strncmp(line, name, strlen(name)) == 0 && sscanf(line + strlen(name), ": %lf", &kilobytes) == 1)
            break;
    if (file)
        fclose(file);
    return 1024 * kilobytes;
}

double health_memory_available(void)
{
    return read_kilobytes("/proc/meminfo", "MemAvailable");
}

void health_put(cJSON *json, const struct config *config, struct scheduler *scheduler)
{
    size_t counts[JOB_STATES];
    struct statvfs disk;
    double rate = 0;
    cJSON *jobs = cJSON_CreateObject(), *space = cJSON_CreateObject(), *memory = cJSON_CreateObject();
    scheduler_states(scheduler, counts);
    for (int k = 0; k < JOB_STATES; k++)
        json_put_int(jobs, job_state_word((enum job_state)k), (long long)counts[k]);
    for (size_t k = 0; k < scheduler_count(scheduler); k++) {
        const struct job *job = scheduler_at(scheduler, k);
        rate += job->state == JOB_RUNNING ? job->report.rate : 0;
    }
    if (statvfs(config->data, &disk) == 0) {
        json_put_real(space, "free_bytes", (double)disk.f_bavail * (double)disk.f_frsize);
        json_put_real(space, "total_bytes", (double)disk.f_blocks * (double)disk.f_frsize);
    }
    json_put_real(memory, "used_bytes", read_kilobytes("/proc/self/status", "VmRSS"));
    json_put_real(memory, "peak_bytes", read_kilobytes("/proc/self/status", "VmHWM"));
    json_put_real(memory, "available_bytes", health_memory_available());
    json_put(json, "jobs", jobs);
    json_put_real(json, "grain_steps_per_s", rate);
    json_put(json, "disk", space);
    json_put(json, "memory", memory);
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See spec_file.h. */
#include "spec_file.h"

#include <stdio.h>
#include <string.h>

/* Puts the file's name before a message, unless the message has it already. */
static enum outcome blame(const char *name, enum scree_status status, struct scree_error *err)
{
    struct scree_error plain = *err;
    if (strncmp(plain.message, name, strlen(name)) != 0)
        snprintf(err->message, sizeof err->message, "%s: %s", name, plain.message);
    return status == SCREE_INTERNAL ? OUTCOME_FAILED : OUTCOME_REFUSED;
}

enum outcome spec_file_read(const char *path, const struct arguments *arguments, double memory_limit, struct spec_file *out,
                            struct scree_error *err)
{
    *out = (struct spec_file){.name = strcmp(path, "-") == 0 ? "stdin" : path};
    enum scree_status status = json_read_file(path, &out->json, err);
    if (status == SCREE_IO)
        return OUTCOME_REFUSED; // the message names the file
    for (int k = 0; k < arguments->option_count && !status; k++) {
        if (strcmp(arguments->options[k].name, "--set") != 0)
            continue;
        if (!cJSON_IsObject(out->json))
            break; // job_decode says so
        if ((status = job_json_set(out->json, arguments->options[k].value, err)))
            return blame("--set", status, err);
    }
    if (!status)
        status = mesh_file_read(out->json, path, &out->mesh, err);
    out->is_study = !status && study_is(out->json);
    if (!status && out->is_study) {
        if (!(status = study_decode(out->json, &out->study, err)))
            status = study_plan_check(&out->study, memory_limit, NULL, NULL, NULL, err);
        out->job = out->study.base;
    } else if (!status && !(status = job_decode(out->json, &out->job, err))) {
        status = job_check(&out->job, memory_limit, err);
    }
    return status ? blame(out->name, status, err) : OUTCOME_DONE;
}

void spec_file_free(struct spec_file *file)
{
    study_plan_free(&file->study);
    mesh_file_free(&file->mesh);
    cJSON_Delete(file->json);
    file->json = NULL;
}

double memory_available(void)
{
    FILE *file = fopen("/proc/meminfo", "r");
    double kilobytes = 0;
    char line[256];
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "MemAvailable: %lf", &kilobytes) == 1)
            break;
    if (file)
        fclose(file);
    return 0.8 * 1024 * kilobytes;
}

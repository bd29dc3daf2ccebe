/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The spec of a job or a study from a file, with --set applied and checked before anything is sent. */
#ifndef SCREE_CLIENT_SPEC_FILE_H
#define SCREE_CLIENT_SPEC_FILE_H

#include "cli.h"
#include "mesh_file.h"
#include "protocol/study_json.h"

struct spec_file {
    const char *name; // as messages call it: the path, or "stdin"
    cJSON *json;      // as written, with --set applied: what is submitted
    bool is_study;
    struct job_spec job;     // of a study: the job that its trials start from
    struct study_plan study; // if it is one
    struct mesh_file mesh;   // that it names by a file
};

/* Reads FILE ("-" is stdin), applies every --set of the command line, decodes
 * and checks. `memory_limit` as for job_check. Messages start with the file's
 * name. Release with spec_file_free, whatever came of it. */
enum outcome spec_file_read(const char *path, const struct arguments *arguments, double memory_limit, struct spec_file *out,
                            struct scree_error *err);
void spec_file_free(struct spec_file *file);

/* Memory that a new world may take on this machine: 0.8 of what is available, bytes; 0 if unknown. */
double memory_available(void);

#endif

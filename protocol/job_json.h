/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Job specs between JSON and structs, driven by the field tables of src/spec. */
#ifndef SCREE_PROTOCOL_JOB_JSON_H
#define SCREE_PROTOCOL_JOB_JSON_H

#include "protocol/json.h"
#include "spec/spec.h"

/* Decodes and range-checks a job (not job_check's scenario rules, which need a
 * memory limit). Errors carry the JSON path, value, range and unit, and for an
 * unknown key the nearest known one. */
enum scree_status job_decode(const cJSON *json, struct job_spec *out, struct scree_error *err);

/* The resolved spec: every value spelled out. NULL on lack of memory.
 * job_decode(job_encode(j)) gives j again, to the bit, of a job that job_decode
 * or job_defaults made: one whose records that are off hold their defaults. */
cJSON *job_encode(const struct job_spec *job);

/* Applies `path=value` (as of `--set`) to a job's JSON before decoding: the value
 * is read as JSON if it is JSON, else as a string. Creates objects on the way. */
enum scree_status job_json_set(cJSON *json, const char *assignment, struct scree_error *err);

/* Every member of an object into its row of a table, below `path` in messages; keys
 * in `others` (NULL-terminated, or NULL) are somebody else's. Types and choices are
 * checked, ranges are left to field_check. */
enum scree_status table_decode(const struct field_table *table, const cJSON *json, const char *path, void *object,
                               const char *const *others, struct scree_error *err);

/* One value, and all of a table's values into an object. */
cJSON *field_encode(const struct field *row, const void *value);
void table_encode_into(cJSON *json, const struct field_table *table, const void *object);

/* What `check` answers of a job's cost. */
cJSON *job_cost_encode(const struct job_cost *cost);

/* A table, or everything about a scenario or a preset, as JSON (what
 * `scree scenarios --json` prints). */
cJSON *table_describe(const struct field_table *table);
cJSON *scenario_describe(const struct scenario_fields *scenario);
cJSON *material_describe(const struct material_preset *preset);

#endif

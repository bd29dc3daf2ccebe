/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The JSON Schemas of jobs and studies, made from the tables: what protocol/schema
 * must hold. A test compares; the program write_schema writes it anew. */
#ifndef TEST_SUPPORT_SCHEMA_H
#define TEST_SUPPORT_SCHEMA_H

/* The text of job.json, of study.json, freed with free(); NULL on lack of memory. */
char *schema_text(void);
char *study_schema_text(void);

#endif

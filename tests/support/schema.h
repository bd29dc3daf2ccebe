/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The JSON Schema of a job, made from the tables: what protocol/schema/job.json
 * must hold. A test compares; the program write_schema writes it anew. */
#ifndef TEST_SUPPORT_SCHEMA_H
#define TEST_SUPPORT_SCHEMA_H

/* The text of the file, freed with free(); NULL on lack of memory. */
char *schema_text(void);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Prints a schema of protocol/schema as it must be:
 *   write_schema > protocol/schema/job.json
 *   write_schema study > protocol/schema/study.json */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "schema.h"

int main(int argc, char **argv)
{
    char *text = argc > 1 && strcmp(argv[1], "study") == 0 ? study_schema_text() : schema_text();
    int failed = !text || puts(text) < 0;
    free(text);
    return failed;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Prints protocol/schema/job.json as it must be: write_schema > protocol/schema/job.json */
#include <stdio.h>
#include <stdlib.h>

#include "schema.h"

int main(void)
{
    char *text = schema_text();
    int failed = !text || puts(text) < 0;
    free(text);
    return failed;
}

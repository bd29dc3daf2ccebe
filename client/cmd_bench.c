/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree bench`: becomes `screed bench`, which has the engine. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "daemon.h"
#include "signals.h"
#include "verbs.h"

static enum outcome bench_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    char program[PATH_MAX], bench[] = "bench", json[] = "--json";
    enum outcome outcome = daemon_program(program, &err);
    if (outcome)
        return give_up(outcome, &err);
    char **argv = calloc((size_t)arguments->word_count + 4, sizeof *argv);
    if (!argv)
        return give_up(outcome_fail(&err, OUTCOME_FAILED, "no memory"), &err);
    int count = 0;
    argv[count++] = program;
    argv[count++] = bench;
    for (int k = 0; k < arguments->word_count; k++)
        argv[count++] = (char *)arguments->words[k]; // execv takes them as they are
    if (arguments->json)
        argv[count++] = json; // it stood before the verb
    signals_reset();
    execv(program, argv);
    outcome_fail(&err, OUTCOME_FAILED, "cannot start %s: %s", program, strerror(errno));
    free(argv);
    return give_up(OUTCOME_FAILED, &err);
}

const struct verb verb_bench = {
    .name = "bench",
    .synopsis = "[ARGUMENT]...",
    .doc = "measure grain-steps per second of the bare engine (screed bench)",
    .help = "Hands everything over to the screed beside this program.\n",
    .words_max = -1,
    .untouched = true,
    .run = bench_run,
};

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree checkpoint`: writes a checkpoint now. */
#include "steer.h"
#include "verbs.h"

static enum outcome checkpoint_run(const struct arguments *arguments)
{
    return steer_each(arguments, "checkpoint");
}

const struct verb verb_checkpoint = {
    .name = "checkpoint",
    .synopsis = "ID...",
    .doc = "write a checkpoint of running jobs now",
    .help = "The daemon writes checkpoints by itself, every minute by default and at every change; this is for one at this\n"
            "very moment. Returns when it is on disk. Prints `ID STATE`; with --json the step, too.\n"
            "\n"
            "  scree checkpoint j17\n",
    .words_min = 1,
    .words_max = -1,
    .run = checkpoint_run,
};

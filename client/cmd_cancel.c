/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree cancel`: stops jobs; what they have recorded stays. */
#include "steer.h"
#include "verbs.h"

static enum outcome cancel_run(const struct arguments *arguments)
{
    return steer_each(arguments, "cancel");
}

const struct verb verb_cancel = {
    .name = "cancel",
    .synopsis = "ID...",
    .doc = "stop jobs and studies; what they have recorded so far stays",
    .help = "A running job stops at the end of its slice, a queued one never starts, an ended one stays as it is.\n"
            "A study takes its trials with it. Prints `ID STATE`.\n"
            "\n"
            "  scree cancel j17 j18\n",
    .words_min = 1,
    .words_max = -1,
    .run = cancel_run,
};

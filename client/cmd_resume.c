/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree resume`: lets a paused job go on. */
#include "steer.h"
#include "verbs.h"

static enum outcome resume_run(const struct arguments *arguments)
{
    return steer_each(arguments, "resume");
}

const struct verb verb_resume = {
    .name = "resume",
    .synopsis = "ID...",
    .doc = "let paused jobs and studies go on",
    .help = "The job goes back into the queue and continues from its checkpoint, with the same bits as if it had never been\n"
            "paused. A job that is not paused stays as it is. Of a study the trials go on that were paused\n"
            "with it. Prints `ID STATE`.\n"
            "\n"
            "  scree resume j17\n",
    .words_min = 1,
    .words_max = -1,
    .run = resume_run,
};

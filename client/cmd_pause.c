/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree pause`: lets a running job rest: a checkpoint, and its worker and memory are free. */
#include "steer.h"
#include "verbs.h"

static enum outcome pause_run(const struct arguments *arguments)
{
    return steer_each(arguments, "pause");
}

const struct verb verb_pause = {
    .name = "pause",
    .synopsis = "ID...",
    .doc = "hold jobs and studies where they are, until `resume`",
    .help = "A running job stops between two steps and writes a checkpoint; its worker and its memory are free for others. It\n"
            "stays paused when the daemon is restarted. A job that is paused already stays so.\n"
            "Of a study every trial that is on its way is paused, and no other begins.\n"
            "Prints `ID STATE`; with --json the step, too.\n"
            "\n"
            "  scree pause j17\n",
    .words_min = 1,
    .words_max = -1,
    .run = pause_run,
};

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The verbs, one file each. */
#ifndef SCREE_CLIENT_VERBS_H
#define SCREE_CLIENT_VERBS_H

#include "cli.h"

extern const struct verb verb_run, verb_check, verb_submit, verb_list, verb_show, verb_wait, verb_watch, verb_tail, verb_cancel,
    verb_pause, verb_resume, verb_checkpoint, verb_set, verb_fork, verb_replay, verb_fetch, verb_plot, verb_scenarios,
    verb_materials, verb_bench, verb_keygen, verb_trust, verb_ping, verb_shutdown;

#endif

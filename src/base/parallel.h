/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A team of threads that step one world together.
 *
 * The caller of team_run is member 0; the others sleep between runs and meet
 * at barriers inside. Nothing here decides who does what: worlds cut their
 * work by member number, so results never depend on timing. */
#ifndef SCREE_BASE_PARALLEL_H
#define SCREE_BASE_PARALLEL_H

#include "base/status.h"

struct team;

/* `size` >= 1 members. Owned by the caller, freed with team_free. */
enum scree_status team_create(int size, struct team **out, struct scree_error *err);
void team_free(struct team *team);
int team_size(const struct team *team);

/* Runs work(context, member) once on every member and returns when all are done. */
void team_run(struct team *team, void (*work)(void *context, int member), void *context);

/* Called by every member inside a run: nobody passes until all have come; what
 * was written before is seen after. */
void team_barrier(struct team *team);

#endif

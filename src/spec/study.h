/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a user can ask of a study: many jobs that answer one question.
 *
 * A sweep runs a job at every point of a grid or of a list of cases; a bisection
 * looks for the value of one parameter at which the verdict changes; a root
 * search for the value at which a number of the summary meets a target. The jobs
 * of a study are its trials. */
#ifndef SCREE_SPEC_STUDY_H
#define SCREE_SPEC_STUDY_H

#include "spec/spec.h"

enum study_kind { STUDY_SWEEP, STUDY_BISECT, STUDY_ROOT, STUDY_KINDS };

enum study_undecided { UNDECIDED_REPORT, UNDECIDED_RAISE, UNDECIDED_LOWER };

enum { STUDY_REPLICAS_MAX = 64, STUDY_AT_ONCE_MAX = 256 };

/* One struct for all three; each kind's table shows its own part of it. */
struct study_spec {
    int kind; // enum study_kind
    char title[128];
    char paper[SPEC_PAPER_MAX];
    int64_t replicas; // of every point (sweep), or whole searches, each with seeds of its own
    int64_t at_once;  // trials that may run or wait in the daemon's queue at one time; 0: as the daemon has workers
    /* Searches. */
    char over[SCREE_PATH_MAX]; // dotted path of the parameter
    double low, high;
    int64_t digits;
    /* Bisection. */
    unsigned raise_low_when; // bits of enum stop_when: verdicts that move the low end up; any other one moves the high end down
    double extend_to_s;      // a trial that is undecided is run again, twice as long, up to this; 0: four times its own end
    int undecided;           // enum study_undecided: what a trial counts as that is undecided at that limit
    /* Root. */
    char number[64]; // of the summary
    double target;
};

/* A kind of study as the user sees it. */
struct study_fields {
    const char *name, *doc, *source;
    const struct field_table *table; // rows beside study, job and what needs more than a table: grid, cases, replica_seeds
    const char *const *required;     // rows of the table that have no default, NULL-terminated
};
extern const struct study_fields study_kinds[STUDY_KINDS];

/* Writes the defaults of the kind. */
void study_defaults(struct study_spec *spec, enum study_kind kind);

/* What ranges cannot say; the spec has passed field_check. */
enum scree_status study_check(const struct study_spec *spec, struct scree_error *err);

/* The verdicts meant by one word: a flow that accelerates flows all the more, so "steady" means both. */
unsigned study_verdicts_meant(unsigned bit);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The fields of studies, kind by kind. */
#include "spec/study.h"

#include <math.h>
#include <string.h>

#include "base/text.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define AT(member)   .offset = offsetof(struct study_spec, member)

#define TITLE                                                                                                                      \
    {                                                                                                                              \
        .name = "title", .type = FIELD_TEXT, AT(title), .size = sizeof(((struct study_spec *)0)->title), .unit = "",               \
        .doc = "for people", .source = ""                                                                                          \
    }
#define PAPER                                                                                                                      \
    {                                                                                                                              \
        .name = "paper", .type = FIELD_TEXT, AT(paper), .size = sizeof(((struct study_spec *)0)->paper), .unit = "",               \
        .doc = SPEC_PAPER_DOC, .source = ""                                                                                        \
    }
#define REPLICAS(what)                                                                                                             \
    {                                                                                                                              \
        .name = "replicas", .type = FIELD_INT, AT(replicas), .min = 1, .max = STUDY_REPLICAS_MAX, .preset = 1, .unit = "",         \
        .doc = what, .source = "protocols 1.13"                                                                                    \
    }
#define AT_ONCE                                                                                                                    \
    {                                                                                                                              \
        .name = "at_once", .type = FIELD_INT, AT(at_once), .min = 0, .max = STUDY_AT_ONCE_MAX, .preset = 0, .unit = "trials",      \
        .doc = "trials that run or wait in the queue at one time; 0: as many as the daemon has workers", .source = ""              \
    }
#define OVER                                                                                                                       \
    {                                                                                                                              \
        .name = "over", .type = FIELD_TEXT, AT(over), .size = sizeof(((struct study_spec *)0)->over), .unit = "",                  \
        .doc = "dotted path of the parameter that is looked for: \"material.mu_t\"", .source = ""                                  \
    }
#define END_OF_BRACKET(member, what)                                                                                               \
    {                                                                                                                              \
        .name = #member, .type = FIELD_REAL, AT(member), .min = -1e15, .max = 1e15, .unit = "", .doc = what, .source = ""          \
    }
#define DIGITS                                                                                                                     \
    {                                                                                                                              \
        .name = "digits", .type = FIELD_INT, AT(digits), .min = 1, .max = 9, .preset = 3, .unit = "significant digits",            \
        .doc = "to which both ends of the bracket must agree", .source = "seed 000 S4.3"                                           \
    }

static const struct field sweep_fields[] = {
    TITLE,
    PAPER,
    REPLICAS("trials of every point, with seed, seed + 1, ..."),
    AT_ONCE,
};

static const char *const verdict_words[] = {"rest", "steady", "accelerating", NULL}; // in the order of enum stop_when
static const char *const undecided_words[] = {"report", "raise", "lower", NULL};
static const struct field bisect_fields[] = {
    TITLE,
    PAPER,
    REPLICAS("searches, each with seeds of its own: their spread is that of the answer"),
    AT_ONCE,
    OVER,
    END_OF_BRACKET(low, "low end of the bracket"),
    END_OF_BRACKET(high, "high end of the bracket"),
    DIGITS,
    {.name = "raise_low_when",
     .type = FIELD_FLAGS,
     AT(raise_low_when),
     .unit = "",
     .doc = "verdicts that move the low end up; any other one moves the high end down",
     .source = "seed 000 S4.3",
     .choices = verdict_words},
    {.name = "extend_to_s",
     .type = FIELD_REAL,
     AT(extend_to_s),
     .min = 0,
     .max = 1e6,
     .preset = 0,
     .unit = "s",
     .doc = "an undecided trial goes on to this end (run again, twice as long each time, where trials do not stop at every "
            "verdict); 0: four times time.end_s",
     .source = "protocols 1.13"},
    {.name = "undecided",
     .type = FIELD_ENUM,
     AT(undecided),
     .preset = UNDECIDED_REPORT,
     .unit = "",
     .doc = "what a trial counts as that is undecided even then: \"report\" ends the search, \"raise\" takes it for one that "
            "raises the low end (what has not come to rest flows), \"lower\" for the other",
     .source = "protocols 1.5",
     .choices = undecided_words},
};

static const struct field root_fields[] = {
    TITLE,
    PAPER,
    REPLICAS("searches, each with seeds of its own: their spread is that of the answer"),
    AT_ONCE,
    OVER,
    END_OF_BRACKET(low, "low end of the bracket"),
    END_OF_BRACKET(high, "high end of the bracket"),
    DIGITS,
    {.name = "number",
     .type = FIELD_TEXT,
     AT(number),
     .size = sizeof(((struct study_spec *)0)->number),
     .unit = "",
     .doc = "of a trial's summary, as `scree show` names it: \"restitution\"",
     .source = ""},
    {.name = "target",
     .type = FIELD_REAL,
     AT(target),
     .min = -1e300,
     .max = 1e300,
     .unit = "",
     .doc = "what the number is to be, in its own unit",
     .source = ""},
};

static const struct field_table sweep_table = {"sweep", "", sweep_fields, COUNT(sweep_fields), sizeof(struct study_spec)};
static const struct field_table bisect_table = {"bisect", "", bisect_fields, COUNT(bisect_fields), sizeof(struct study_spec)};
static const struct field_table root_table = {"root", "", root_fields, COUNT(root_fields), sizeof(struct study_spec)};

static const char *const nothing[] = {NULL};
static const char *const bisect_required[] = {"over", "low", "high", "raise_low_when", NULL};
static const char *const root_required[] = {"over", "low", "high", "number", "target", NULL};

const struct study_fields study_kinds[STUDY_KINDS] = {
    {.name = "sweep",
     .doc = "a job at every point of a grid, or for every one of a list of cases",
     .source = "",
     .table = &sweep_table,
     .required = nothing},
    {.name = "bisect",
     .doc = "the lowest value of a parameter at which the verdict is another one",
     .source = "seed 000 S4.3, protocols 1.13",
     .table = &bisect_table,
     .required = bisect_required},
    {.name = "root",
     .doc = "the value of a parameter at which a number of the summary meets a target",
     .source = "",
     .table = &root_table,
     .required = root_required},
};

void study_defaults(struct study_spec *spec, enum study_kind kind)
{
    memset(spec, 0, sizeof *spec);
    field_defaults(study_kinds[kind].table, spec);
    spec->kind = (int)kind;
}

enum scree_status study_check(const struct study_spec *spec, struct scree_error *err)
{
    char low[TEXT_REAL_MAX], high[TEXT_REAL_MAX];
    if (spec->kind == STUDY_SWEEP)
        return SCREE_OK;
    if (!(spec->low < spec->high))
        return scree_fail(err, SCREE_INVALID, "low", "low: %s is not below high, %s", text_real(spec->low, low),
                          text_real(spec->high, high));
    if (spec->kind == STUDY_ROOT && !*spec->number)
        return scree_fail(err, SCREE_INVALID, "number", "number: is empty; it names a number of the summary");
    if (spec->kind == STUDY_BISECT && (spec->raise_low_when == 0 || spec->raise_low_when == STOP_ANY))
        return scree_fail(err, SCREE_INVALID, "raise_low_when",
                          "raise_low_when: %s verdict moves the low end, so that the bracket could never close",
                          spec->raise_low_when ? "every" : "no");
    return SCREE_OK;
}

unsigned study_verdicts_meant(unsigned bit)
{
    return bit == STOP_STEADY ? STOP_STEADY | STOP_ACCELERATING : bit;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How a function of scree says that it failed.
 *
 * Bugs assert. Bad input, I/O, lack of memory and numerical blow-up return an
 * enum scree_status and leave a message in the caller's struct scree_error.
 * A function that takes an `err` accepts NULL there. */
#ifndef SCREE_BASE_STATUS_H
#define SCREE_BASE_STATUS_H

enum scree_status {
    SCREE_OK = 0,
    SCREE_INVALID,   // the input breaks a stated rule; `path` names the field
    SCREE_NO_MEMORY, // the system refused memory, or a stated limit would be passed
    SCREE_IO,        // a file or a database could not be read or written
    SCREE_CORRUPT,   // what was read is damaged or of another version
    SCREE_BLOWUP,    // the simulation left the physical range (NaN, energy explosion, a grain through the base)
    SCREE_NOT_FOUND, // no such job, stream, preset or scenario
    SCREE_BUSY,      // try again later (queue full)
    SCREE_CANCELLED, // the user stopped it
    SCREE_DENIED,    // the user is not authorised
    SCREE_CONFLICT,  // the job's state does not allow it
    SCREE_INTERNAL   // a bug that was caught at a boundary
};

enum { SCREE_PATH_MAX = 160, SCREE_MESSAGE_MAX = 640, SCREE_HINT_MAX = 320 };

struct scree_error {
    enum scree_status status;
    char path[SCREE_PATH_MAX];       // JSON path of the field at fault, "" if none: "params.slope_deg"
    char message[SCREE_MESSAGE_MAX]; // one sentence, no newline
    char hint[SCREE_HINT_MAX];       // what to do about it, "" if nothing is to be said
};

/* Fills *err (if not NULL) and returns `status`, so that a failing function can
 * end with `return scree_fail(...)`. `path` may be NULL. Clears the hint. What is
 * kept is valid UTF-8 without control characters, whatever was quoted. */
enum scree_status scree_fail(struct scree_error *err, enum scree_status status, const char *path, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Adds a hint to an error that was just filled. */
void scree_hint(struct scree_error *err, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The wire's word for a status: "invalid", "not_found", ... */
const char *scree_status_word(enum scree_status status);

#endif

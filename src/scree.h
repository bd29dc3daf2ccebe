/* SPDX-License-Identifier: GPL-3.0-or-later */
/* scree's simulation library: the one public header.
 *
 * A world is built from a job's spec, advanced in slices, watched through its
 * progress and its streams, and freed. The library opens no socket, reads no
 * JSON, prints nothing and never exits. One world belongs to one thread at a
 * time; different worlds may run in different threads.
 *
 *     struct scree_world *world;
 *     scree_world_create(&job, &options, &sink, &world, &err);
 *     while (!scree_world_progress(world).finished)
 *         scree_world_advance(world, 1000, &err);
 *     scree_world_free(world);
 */
#ifndef SCREE_H
#define SCREE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "spec/spec.h"

struct scree_world;

/* ---- streams: what a world says while it runs ---- */

struct scree_column {
    const char *name; // "Fz"
    const char *unit; // "N"
};

/* Describes one quantity of a world; lives as long as the program. */
struct scree_stream {
    const char *name; // "basal_force"
    const char *doc;
    const struct scree_column *columns;
    size_t column_count;
    bool frames; // each chunk is one frame (one instant, a row per grain) rather than rows along time
};

/* A numbered piece of a stream. Where a stream is cut depends on the spec and on
 * simulated time alone, never on slices, threads or wall time. */
struct scree_chunk {
    const struct scree_stream *stream;
    uint64_t seq; // 0, 1, 2, ... within the stream of this job
    double t0_s;  // time of the first row (a block average: the end of its block)
    double dt_s;  // between rows; 0 for frames
    size_t rows;
    const double *values; // rows * column_count, row by row
};

/* Where a world puts its chunks: called on the thread that advances the world,
 * `chunk` is valid during the call. A status other than SCREE_OK stops the
 * slice and is returned by scree_world_advance. */
struct scree_sink {
    enum scree_status (*put)(void *context, const struct scree_chunk *chunk, struct scree_error *err);
    void *context;
};

/* ---- worlds ---- */

struct scree_options {
    const char *isa;    // "x86-64-v2", "-v3", "-v4" or NULL: the best this machine has
    int threads;        // 0: the job's own
    const char *meshes; // folder of the meshes that jobs name, each a file called by its SHA-256; NULL: there are none
};

/* Refuses a job that job_check passes and no world could be made of, as bodies that are not convex: SCREE_INVALID. */
enum scree_status scree_job_check(const struct job_spec *job, const struct scree_options *options, struct scree_error *err);

/* A mesh as the bytes of an STL or OBJ file: whether worlds can be made of it, and what it is. SCREE_INVALID names the
 * triangle or the line. */
struct scree_mesh {
    size_t vertices, triangles;
    double low[3], high[3]; // in the file's lengths
    bool closed;            // it encloses a space
};
enum scree_status scree_mesh_look(const char *bytes, size_t size, struct scree_mesh *out, struct scree_error *err);

/* Builds the world of a checked job (job_check). May take seconds for a large
 * one: `cancelled`, polled now and then, makes it return SCREE_CANCELLED.
 * On success *out is owned by the caller. The sink must outlive the world. */
enum scree_status scree_world_create(const struct job_spec *job, const struct scree_options *options, const struct scree_sink *sink,
                                     struct scree_world **out, struct scree_error *err);
void scree_world_free(struct scree_world *world);

/* Advances by at most `steps` time steps; stops early when the job's stop rule
 * or its end time is met. The result does not depend on how a run is sliced.
 * SCREE_BLOWUP names step, grain and last good time. */
enum scree_status scree_world_advance(struct scree_world *world, uint64_t steps, struct scree_error *err);

enum scree_verdict { VERDICT_UNDECIDED, VERDICT_REST, VERDICT_STEADY, VERDICT_ACCELERATING };
const char *scree_verdict_word(enum scree_verdict verdict);

struct scree_progress {
    uint64_t step;     // steps done
    uint64_t end_step; // steps at time.end_s
    double time_s, end_s;
    size_t moving, fixed; // grains
    bool finished;
    enum scree_verdict verdict;
    const char *evidence; // one line on which the verdict rests; owned by the world
    const char *isa;      // instruction set in use
    int threads;
};
struct scree_progress scree_world_progress(const struct scree_world *world);

/* Numbers that sum a run up, in the scenario's own words. */
struct scree_number {
    const char *name; // "mean_force_z"
    const char *unit;
    const char *doc;
    double value;
};
enum { SCREE_SUMMARY_MAX = 96 };
/* Writes at most SCREE_SUMMARY_MAX numbers, returns how many. */
size_t scree_world_summary(const struct scree_world *world, struct scree_number numbers[SCREE_SUMMARY_MAX]);

/* Ends the streams: puts the last, possibly shorter chunks and the final frame.
 * Called once, when the world is finished or was stopped for good. */
enum scree_status scree_world_close(struct scree_world *world, struct scree_error *err);

/* A 64-bit hash over positions, velocities, spins and contact histories: equal
 * exactly when two worlds are in the same state, to the bit. */
uint64_t scree_world_hash(const struct scree_world *world);

/* A second world in the same state, to the bit, which goes on by itself. Takes
 * nothing from the first one, which must not be advanced meanwhile. */
enum scree_status scree_world_fork(const struct scree_world *world, const struct scree_options *options,
                                   const struct scree_sink *sink, struct scree_world **out, struct scree_error *err);

/* From here on the job is `job`, which may differ from the one so far in steerable
 * values alone (job_steer_check): takes effect with the next step. Windows that a
 * verdict rests on begin anew when forces change. The same steps and the same
 * commands give the same bits. */
enum scree_status scree_world_steer(struct scree_world *world, const struct job_spec *job, struct scree_error *err);

/* Streams begin anew here with chunk 0: a fork's own. What was gathered for a chunk is dropped. */
void scree_world_branch(struct scree_world *world);

/* Number of the chunk that a stream of scree_world_streams will put next. */
uint64_t scree_world_next_chunk(const struct scree_world *world, size_t stream);

/* A copy of everything a world is, which the world may leave behind: taken on the
 * world's thread in the time of a memcpy, written later on another. */
struct scree_image;
enum scree_status scree_image_take(const struct scree_world *world, struct scree_image **out, struct scree_error *err);
void scree_image_free(struct scree_image *image);

/* ---- checkpoints (HDF5: one thread of a process makes these calls) ---- */

/* Makes libhdf5 set up all of itself now: what it has no memory for in the midst of a first use it is without for good.
 * SCREE_NO_MEMORY. */
enum scree_status scree_prepare(struct scree_error *err);

/* As scree_checkpoint_write, of an image. */
enum scree_status scree_image_write(const struct scree_image *image, const char *path, struct scree_error *err);

/* Writes PATH beside, flushed to disk, then renamed; the world stays as it is. */
enum scree_status scree_checkpoint_write(const struct scree_world *world, const char *path, struct scree_error *err);

/* A world that goes on where the checkpoint was written, to the bit. `job` is the
 * job's spec as the caller knows it; a checkpoint of another spec, version or
 * build, or one that is cut short or changed by a single bit, is SCREE_CORRUPT,
 * with the file's name in the message. */
enum scree_status scree_checkpoint_read(const char *path, const struct job_spec *job, const struct scree_options *options,
                                        const struct scree_sink *sink, struct scree_world **out, struct scree_error *err);

/* The streams this world will put, in a fixed order. */
size_t scree_world_streams(const struct scree_world *world, const struct scree_stream *const **streams);

/* Version and build: "0.1.0 (gcc 12.2.0, Release)". */
const char *scree_build(void);

/* ---- results ---- */

/* A stored stream, read back chunk by chunk when a result is written: `next`
 * fills *chunk (values valid until the next call) and sets *more. */
struct scree_source {
    enum scree_status (*next)(void *context, const char *stream, uint64_t seq, struct scree_chunk *chunk, bool *more,
                              struct scree_error *err);
    void *context;
};
struct scree_result {
    const char *path;         // written beside as PATH.part, fsynced, renamed
    const char *spec_json;    // the resolved spec
    const char *journal_json; // steering commands with their steps, "[]" if none
    const char *job_id, *title, *state, *verdict, *evidence;
    const struct job_spec *job;
    const struct scree_number *numbers;
    size_t number_count;
    uint64_t steps;
    double time_s;
    const struct scree_stream *const *streams;
    size_t stream_count;
};
/* Writes result.h5 as H5MD from stored streams. All HDF5 calls of a process must
 * come from one thread. */
enum scree_status scree_result_write(const struct scree_result *result, const struct scree_source *source, struct scree_error *err);

#endif

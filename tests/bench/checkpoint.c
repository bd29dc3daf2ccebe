/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Time and size of a checkpoint from a thousand grains to a million, beside a plain
 * write of as many bytes to the same disk.
 *
 *     build/tests/bench/checkpoint [FOLDER]
 *
 * prints a Markdown table. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "scree.h"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void die(const char *what, const struct scree_error *error)
{
    fprintf(stderr, "checkpoint: %s: %s\n", what, error->message);
    exit(1);
}

static enum scree_status drop(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    (void)context, (void)chunk, (void)err;
    return SCREE_OK;
}

/* Seconds that the disk takes for `size` bytes and a sync. */
static double plain_write(const char *path, size_t size)
{
    enum { BLOCK = 1 << 20 };
    char *block = calloc(1, BLOCK);
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    double start = now();
    for (size_t done = 0; block && file >= 0 && done < size; done += BLOCK) {
        memset(block, (int)done, BLOCK);
        if (write(file, block, size - done < BLOCK ? size - done : BLOCK) < 0)
            break;
    }
    fsync(file);
    double taken = now() - start;
    close(file);
    unlink(path);
    free(block);
    return taken;
}

static void measure(int64_t n, int64_t deep, const char *folder)
{
    struct job_spec job;
    struct scree_error error = {0};
    struct scree_sink sink = {drop, NULL};
    struct scree_options options = {0};
    struct scree_world *world, *again;
    char path[4096];
    struct stat file;
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = n;
    p->nz = deep;
    snprintf(path, sizeof path, "%s/checkpoint.h5", folder);
    double set_up = now();
    if (scree_world_create(&job, &options, &sink, &world, &error))
        die("create", &error);
    set_up = now() - set_up;
    if (scree_world_advance(world, 200, &error))
        die("advance", &error);
    double written = now();
    if (scree_checkpoint_write(world, path, &error))
        die("write", &error);
    written = now() - written;
    double read = now();
    if (scree_checkpoint_read(path, &job, &options, &sink, &again, &error))
        die("read", &error);
    read = now() - read;
    if (stat(path, &file) != 0 || scree_world_hash(world) != scree_world_hash(again))
        die("compare", &error);
    unlink(path);
    double plain = plain_write(path, (size_t)file.st_size);
    struct scree_progress progress = scree_world_progress(world);
    size_t grains = progress.moving + progress.fixed;
    printf("| %zu | %.2f | %.3g | %.4g | %.4g | %.0f | %.4g | %.4g |\n", grains, set_up, (double)file.st_size / 1e6,
           (double)file.st_size / (double)grains, 1e3 * written, (double)file.st_size / written / 1e6, 1e3 * plain, 1e3 * read);
    fflush(stdout);
    scree_world_free(again);
    scree_world_free(world);
}

int main(int argc, char **argv)
{
    const char *folder = argc > 1 ? argv[1] : ".";
    printf("| grains | set-up, s | MB | bytes a grain | write and sync, ms | MB/s | plain write and sync, ms | read, ms |\n"
           "|---|---|---|---|---|---|---|---|\n");
    const int64_t sizes[][2] = {{10, 10}, {20, 10}, {40, 10}, {100, 10}, {100, 99}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        measure(sizes[k][0], sizes[k][1], folder);
    return 0;
}

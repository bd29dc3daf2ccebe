/* SPDX-License-Identifier: GPL-3.0-or-later */
/* main for a fuzz target without libFuzzer: every file of a folder, then a fixed
 * number of mutations of them. No clock and no randomness: what fails once fails
 * always, and its number is printed. An input is handed over in a buffer of its
 * exact size, so that a sanitizer sees the first byte read behind it. */
#include <dirent.h>

#include "base/rng.h"
#include "check.h"

enum { FILES_MAX = 256, INPUT_MAX = 1 << 16, ROUNDS = 200000 };

struct input {
    uint8_t *data;
    size_t size;
};

static struct input corpus[FILES_MAX];
static size_t corpus_count;

static void run(const uint8_t *data, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1);
    CHECK(exact != NULL);
    memcpy(exact, data, size);
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static void read_corpus(const char *folder)
{
    struct dirent **entries;
    int count = scandir(folder, &entries, NULL, by_name);
    CHECK(count > 2);
    for (int k = 0; k < count; k++) {
        static uint8_t buffer[INPUT_MAX];
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, entries[k]->d_name);
        FILE *file = entries[k]->d_name[0] == '.' ? NULL : fopen(path, "rb");
        free(entries[k]);
        if (!file)
            continue;
        struct input *in = &corpus[corpus_count++];
        CHECK(corpus_count < FILES_MAX);
        in->size = fread(buffer, 1, sizeof buffer, file);
        in->data = malloc(in->size + 1);
        CHECK(in->data != NULL);
        memcpy(in->data, buffer, in->size);
        fclose(file);
    }
    free(entries);
    CHECK(corpus_count > 0);
}

/* A few of: a bit turned, a byte replaced by one that means something, a piece cut out, doubled or taken from another input. */
static size_t mutate(struct rng *rng, uint8_t *data, size_t size)
{
    static const char telling[] = "{}[]\",:\\u0e-+.=\n\x00\x80\xc2\xed\xf0\xff";
    for (uint64_t left = 1 + rng_next(rng) % 4; left > 0 && size > 0; left--) {
        size_t at = rng_next(rng) % size, length = 1 + rng_next(rng) % 16;
        length = length < size - at ? length : size - at;
        const struct input *other = &corpus[rng_next(rng) % corpus_count];
        switch (rng_next(rng) % 5) {
        case 0:
            data[at] ^= (uint8_t)(1u << rng_next(rng) % 8);
            break;
        case 1:
            data[at] = (uint8_t)telling[rng_next(rng) % (sizeof telling - 1)];
            break;
        case 2:
            memmove(data + at, data + at + length, size - at - length);
            size -= length;
            break;
        case 3:
            if (size + length <= INPUT_MAX) {
                memmove(data + at + length, data + at, size - at);
                size += length;
            }
            break;
        default:
            if (other->size > 0) {
                size_t from = rng_next(rng) % other->size;
                length = length < other->size - from ? length : other->size - from;
                memcpy(data + at, other->data + from, length);
            }
        }
    }
    return size;
}

int main(int count, char **arguments)
{
    static uint8_t data[INPUT_MAX];
    struct rng rng = rng_start(1, 1);
    int rounds = count == 3 ? atoi(arguments[2]) : ROUNDS;
    if (count < 2 || count > 3) {
        fprintf(stderr, "usage: %s CORPUS_FOLDER [MUTATIONS]\n", arguments[0]);
        return 2;
    }
    read_corpus(arguments[1]);
    for (size_t k = 0; k < corpus_count; k++)
        run(corpus[k].data, corpus[k].size);
    for (int k = 0; k < rounds; k++) {
        const struct input *in = &corpus[rng_next(&rng) % corpus_count];
        memcpy(data, in->data, in->size);
        run(data, mutate(&rng, data, in->size));
    }
    printf("%zu inputs and %d mutations\n", corpus_count, rounds);
    for (size_t k = 0; k < corpus_count; k++)
        free(corpus[k].data);
    return 0;
}

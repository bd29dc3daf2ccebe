/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See table.h. Columns of words become strings of one length, the longest one's:
 * every HDF5 reader takes those. */
#include "io/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "io/files.h"
#include "io/h5.h"

static hid_t text_type(size_t length)
{
    hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length + 1);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

static void write_words(struct h5 *h5, const char *at, const char *const *words, size_t rows)
{
    size_t longest = 1;
    for (size_t k = 0; k < rows; k++)
        longest = strlen(words[k]) > longest ? strlen(words[k]) : longest;
    char *block = memory_rows(rows, longest + 1);
    if (!block) {
        h5->status = scree_fail(&h5->error, SCREE_NO_MEMORY, NULL, "no memory for the column %s", at);
        return;
    }
    for (size_t k = 0; k < rows; k++)
        memcpy(block + k * (longest + 1), words[k], strlen(words[k]));
    hid_t type = text_type(longest);
    h5_array(h5, at, type, block, rows);
    H5Tclose(type);
    free(block);
}

static void write_columns(struct h5 *h5, const struct io_table *t)
{
    h5_group(h5, "/trials");
    for (size_t k = 0; k < t->column_count && !h5->status; k++) {
        const struct io_column *c = &t->columns[k];
        char at[256];
        snprintf(at, sizeof at, "/trials/%s", c->name);
        if (c->values)
            h5_vector(h5, at, c->values, t->rows);
        else
            write_words(h5, at, c->words, t->rows);
        h5_attribute_text(h5, at, "unit", c->unit);
    }
}

enum scree_status io_table_write(const struct io_table *t, struct scree_error *err)
{
    struct h5 h5;
    char *part = NULL;
    if (asprintf(&part, "%s.part", t->path) < 0)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %s", t->path);
    h5_create(&h5, part);
    h5_group(&h5, "/study");
    h5_attribute_text(&h5, "/study", "id", t->id);
    h5_attribute_text(&h5, "/study", "kind", t->kind);
    h5_attribute_text(&h5, "/study", "title", t->title);
    h5_attribute_text(&h5, "/study", "state", t->state);
    h5_attribute_text(&h5, "/study", "conclusion", t->conclusion);
    h5_attribute_text(&h5, "/study", "build", t->build);
    hid_t type = text_type(strlen(t->spec_json));
    h5_array(&h5, "/study/spec", type, t->spec_json, 1);
    H5Tclose(type);
    write_columns(&h5, t);
    enum scree_status status = h5_close(&h5, err);
    if (!status)
        status = files_into_place(part, t->path, err);
    if (status)
        unlink(part);
    free(part);
    return status;
}

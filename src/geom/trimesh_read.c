/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes out of files, strictly: a file is as hostile as a message.
 *
 * STL: 80 bytes of anything, a count, 50 bytes a triangle; or words, beginning
 * with "solid". Many binary files begin with "solid" too, so a file whose length
 * fits its count is binary. Normals are not read: corners say which way a
 * triangle turns. OBJ: the statements `v` and `f` are read (negative indices
 * count from the end, texture and normal indices are passed over), the other
 * statements of the format are known by name and skipped. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geom/trimesh.h"

enum { FILE_BYTES_MAX = 1 << 30 };

struct soup { // what has been read so far
    double (*vertex)[3];
    uint32_t (*corner)[3];
    size_t vertices, triangles, vertex_room, corner_room;
    double scale;
};

static enum scree_status add_vertex(struct soup *soup, const double at[3], struct scree_error *err)
{
    if (soup->vertices >= TRIMESH_VERTICES_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "the mesh has more than %d vertices", TRIMESH_VERTICES_MAX);
    enum scree_status status =
        memory_grow((void **)&soup->vertex, &soup->vertex_room, soup->vertices + 1, sizeof *soup->vertex, err);
    for (int a = 0; a < 3 && !status; a++)
        soup->vertex[soup->vertices][a] = at[a] * soup->scale;
    soup->vertices += !status;
    return status;
}

static enum scree_status add_triangle(struct soup *soup, uint32_t a, uint32_t b, uint32_t c, struct scree_error *err)
{
    if (soup->triangles >= TRIMESH_TRIANGLES_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "the mesh has more than %d triangles", TRIMESH_TRIANGLES_MAX);
    enum scree_status status =
        memory_grow((void **)&soup->corner, &soup->corner_room, soup->triangles + 1, sizeof *soup->corner, err);
    if (status)
        return status;
    uint32_t *corner = soup->corner[soup->triangles++];
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    return SCREE_OK;
}

/* ---- binary STL ---- */

static uint32_t little_u32(const char *bytes)
{
    const unsigned char *b = (const unsigned char *)bytes;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static bool is_binary_stl(const char *bytes, size_t size)
{
    return size >= 84 && (uint64_t)little_u32(bytes + 80) * 50 + 84 == size;
}

static enum scree_status read_binary_stl(const char *bytes, struct soup *soup, struct scree_error *err)
{
    size_t count = little_u32(bytes + 80);
    enum scree_status status = SCREE_OK;
    for (size_t t = 0; t < count && !status; t++) {
        const char *corner = bytes + 84 + 50 * t + 12;
        for (int k = 0; k < 3 && !status; k++) {
            double at[3];
            for (int a = 0; a < 3; a++) {
                uint32_t bits = little_u32(corner + 12 * k + 4 * a);
                float value;
                memcpy(&value, &bits, sizeof value);
                at[a] = (double)value;
            }
            status = add_vertex(soup, at, err);
        }
        uint32_t first = (uint32_t)(3 * t);
        status = status ? status : add_triangle(soup, first, first + 1, first + 2, err);
    }
    return status;
}

/* ---- words ---- */

struct words {
    const char *at, *end;
    size_t line;
};

/* The next word on this line into `word`; false at its end. Words too long to be any of ours are cut. */
static bool next_word(struct words *w, char word[64])
{
    while (w->at < w->end && *w->at != '\n' && isspace((unsigned char)*w->at))
        w->at++;
    size_t n = 0;
    while (w->at < w->end && !isspace((unsigned char)*w->at)) {
        if (n < 63)
            word[n++] = *w->at;
        w->at++;
    }
    word[n] = 0;
    return n > 0;
}

static bool next_line(struct words *w)
{
    while (w->at < w->end && *w->at != '\n')
        w->at++;
    if (w->at < w->end)
        w->at++;
    w->line++;
    return w->at < w->end;
}

static enum scree_status bad_line(const struct words *w, const char *what, struct scree_error *err)
{
    return scree_fail(err, SCREE_INVALID, NULL, "line %zu of the mesh: %s", w->line, what);
}

static bool real_of(const char *word, double *out)
{
    char *end;
    if (!*word || strspn(word, "+-.0123456789eE") != strlen(word)) // no "nan", "inf", "0x"
        return false;
    *out = strtod(word, &end);
    return *end == 0 && isfinite(*out);
}

static enum scree_status read_point(struct words *w, struct soup *soup, struct scree_error *err)
{
    double at[3];
    char word[64];
    for (int a = 0; a < 3; a++)
        if (!next_word(w, word) || !real_of(word, &at[a]))
            return bad_line(w, "expected three finite numbers", err);
    return add_vertex(soup, at, err);
}

/* ---- ASCII STL ---- */

static enum scree_status read_ascii_stl(struct words *w, struct soup *soup, struct scree_error *err)
{
    char word[64];
    size_t corners = 0;
    bool inside = false;
    enum scree_status status = SCREE_OK;
    do {
        if (status)
            return status;
        if (!next_word(w, word))
            continue;
        if (strcmp(word, "vertex") == 0) {
            if (!inside || corners == 3)
                return bad_line(w, "a facet has three vertices, between \"outer loop\" and \"endloop\"", err);
            corners++;
            status = read_point(w, soup, err);
        } else if (strcmp(word, "outer") == 0) {
            inside = true;
            corners = 0;
        } else if (strcmp(word, "endloop") == 0) {
            uint32_t last = (uint32_t)soup->vertices;
            if (!inside || corners != 3)
                return bad_line(w, "a facet has three vertices, between \"outer loop\" and \"endloop\"", err);
            inside = false;
            status = add_triangle(soup, last - 3, last - 2, last - 1, err);
        } else if (strcmp(word, "solid") != 0 && strcmp(word, "facet") != 0 && strcmp(word, "endfacet") != 0 &&
                   strcmp(word, "endsolid") != 0) {
            return bad_line(w, "not a statement of an STL file", err);
        }
    } while (next_line(w));
    if (inside && !status)
        status = bad_line(w, "the file ends within a facet", err);
    return status;
}

/* ---- OBJ ---- */

/* "7", "7/1", "7/1/2", "7//2", "-1": the vertex, counted from 0. */
static bool index_of(const char *word, size_t vertices, uint32_t *out)
{
    char *end;
    long value = strtol(word, &end, 10);
    if (end == word || (*end && *end != '/') || strspn(word, "-+0123456789/") != strlen(word) || value == 0)
        return false;
    long index = value > 0 ? value - 1 : (long)vertices + value;
    *out = (uint32_t)index;
    return index >= 0 && index < (long)vertices;
}

static enum scree_status read_face(struct words *w, struct soup *soup, struct scree_error *err)
{
    char word[64];
    uint32_t first = 0, last = 0, here;
    int corners = 0;
    for (; next_word(w, word); corners++) {
        if (!index_of(word, soup->vertices, &here))
            return bad_line(w, "a face names a vertex that is not there", err);
        if (corners == 0)
            first = here;
        enum scree_status status = corners >= 2 ? add_triangle(soup, first, last, here, err) : SCREE_OK;
        if (status)
            return status;
        last = here;
    }
    return corners >= 3 ? SCREE_OK : bad_line(w, "a face needs three vertices or more", err);
}

static enum scree_status read_obj(struct words *w, struct soup *soup, struct scree_error *err)
{
    static const char *const skipped[] = {"vn", "vt", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p"};
    char word[64];
    enum scree_status status = SCREE_OK;
    do {
        if (status)
            return status;
        if (!next_word(w, word) || *word == '#')
            continue;
        if (strcmp(word, "v") == 0) {
            status = read_point(w, soup, err);
        } else if (strcmp(word, "f") == 0) {
            status = read_face(w, soup, err);
        } else {
            bool known = false;
            for (size_t k = 0; k < sizeof skipped / sizeof *skipped; k++)
                known |= strcmp(word, skipped[k]) == 0;
            if (!known)
                return bad_line(w, "not a statement of an OBJ file (nor is the file STL)", err);
        }
    } while (next_line(w));
    return status;
}

/* ---- either ---- */

enum scree_status trimesh_parse(const char *bytes, size_t size, double scale, bool closed, struct trimesh **out,
                                struct scree_error *err)
{
    struct soup soup = {.scale = scale};
    struct words words = {bytes, bytes + size, 1}, first = words;
    char word[64] = "";
    while (!next_word(&first, word) && next_line(&first))
        ;
    enum scree_status status;
    if (is_binary_stl(bytes, size))
        status = read_binary_stl(bytes, &soup, err);
    else if (strcmp(word, "solid") == 0)
        status = read_ascii_stl(&words, &soup, err);
    else
        status = read_obj(&words, &soup, err);
    if (!status)
        status = trimesh_create((const double(*)[3])soup.vertex, soup.vertices, (const uint32_t(*)[3])soup.corner, soup.triangles,
                                closed, out, err);
    free(soup.vertex);
    free(soup.corner);
    return status;
}

enum scree_status trimesh_read(const char *path, double scale, bool closed, struct trimesh **out, struct scree_error *err)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return scree_fail(err, SCREE_IO, NULL, "cannot open the mesh %s", path);
    char *bytes = NULL;
    enum scree_status status = SCREE_OK;
    long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    if (size < 0 || size > FILE_BYTES_MAX)
        status = scree_fail(err, SCREE_IO, NULL, "the mesh %s is not a file of at most 1 GB", path);
    else if (!(bytes = memory_rows((size_t)size + 1, 1)))
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the mesh %s", path);
    else if (fseek(file, 0, SEEK_SET) != 0 || fread(bytes, 1, (size_t)size, file) != (size_t)size)
        status = scree_fail(err, SCREE_IO, NULL, "cannot read the mesh %s", path);
    else
        status = trimesh_parse(bytes, (size_t)size, scale, closed, out, err);
    free(bytes);
    fclose(file);
    return status;
}

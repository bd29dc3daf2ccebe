/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A grid of cells as wide as the longest pair, from which outer lists are built.
 *
 * Periodic axes need no ghosts: a neighbour cell past the edge is the one at the
 * other side, and the pair notes by how many boxes its second grain is moved.
 * With one or two cells along an axis the same cell is met several times with
 * different images, which are different pairs, as they must be in a small box. */
#include "dem/cells.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "dem/state.h"

enum scree_status cells_create(struct cells **out, struct scree_error *err)
{
    *out = calloc(1, sizeof **out);
    return *out ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the cell grid");
}

void cells_free(struct cells *cells)
{
    if (!cells)
        return;
    free(cells->start);
    free(cells->point);
    free(cells->row);
    free(cells->image);
    free(cells->cell);
    free(cells->ways);
    free(cells->wide);
    free(cells);
}

/* Extent and number of cells along each axis; at most about four cells a grain. */
static void cells_layout(struct cells *cells, const struct dem *dem, double width)
{
    double size[3];
    for (int a = 0; a < 3; a++) {
        double low = 0, high = dem->length[a];
        if (high <= 0) {
            low = INFINITY, high = -INFINITY;
            for (size_t i = 0; i < dem->grains; i++) {
                double x = dem->position[i][a];
                low = x < low ? x : low;
                high = x > high ? x : high;
            }
            high += 1e-6 * width;
        }
        cells->low[a] = low;
        size[a] = high - low;
    }
    for (double stretch = 1;; stretch *= 1.26) {
        double total = 1;
        for (int a = 0; a < 3; a++) {
            double n = fmax(1, floor(size[a] / (width * stretch)));
            cells->count[a] = n < 1e6 ? (int)n : 1000000;
            total *= cells->count[a];
        }
        if (total <= 4.0 * (double)dem->grains + 64)
            break;
    }
    for (int a = 0; a < 3; a++)
        cells->inverse[a] = cells->count[a] / size[a];
}

/* The whole part, also of what no int holds: before a blow-up is noticed a grain may be anywhere. */
static int whole_part(double value, int low, int high)
{
    return value > low ? value < high ? (int)value : high : low;
}

enum scree_status cells_fill(struct cells *cells, const struct dem *dem, double width, struct scree_error *err)
{
    size_t n = dem->grains;
    cells->width = width;
    cells_layout(cells, dem, width);
    size_t total = (size_t)cells->count[0] * (size_t)cells->count[1] * (size_t)cells->count[2];
    enum scree_status status;
    if ((status = memory_grow((void **)&cells->start, &cells->start_room, total + 1, sizeof *cells->start, err)) ||
        (status = memory_grow((void **)&cells->point, &cells->point_room, n, sizeof *cells->point, err)) ||
        (status = memory_grow((void **)&cells->row, &cells->row_room, n, sizeof *cells->row, err)) ||
        (status = memory_grow((void **)&cells->image, &cells->image_room, n, sizeof *cells->image, err)) ||
        (status = memory_grow((void **)&cells->cell, &cells->cell_room, n, sizeof *cells->cell, err)))
        return status;
    for (size_t c = 0; c <= total; c++)
        cells->start[c] = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t cell = 0;
        for (int a = 2; a >= 0; a--) {
            double x = dem->position[i][a], box = dem->length[a], boxes = box > 0 ? floor(x / box) : 0;
            int k = whole_part((x - boxes * box - cells->low[a]) * cells->inverse[a], 0, cells->count[a] - 1);
            cell = cell * (uint32_t)cells->count[a] + (uint32_t)k;
        }
        cells->cell[i] = cell;
        cells->start[cell + 1]++;
    }
    for (size_t c = 0; c < total; c++)
        cells->start[c + 1] += cells->start[c];
    for (size_t i = n; i-- > 0;) { // from the back, so that rows ascend within a cell once starts have moved down
        uint32_t at = --cells->start[cells->cell[i] + 1];
        for (int a = 0; a < 3; a++) {
            double x = dem->position[i][a], box = dem->length[a], boxes = box > 0 ? floor(x / box) : 0;
            cells->point[at][a] = x - boxes * box;
            cells->image[at][a] = (int8_t)whole_part(boxes, INT8_MIN, INT8_MAX);
        }
        cells->point[at][3] = dem->position[i][3];
        cells->row[at] = (uint32_t)i;
    }
    /* start[c + 1] now holds the first entry of cell c: move down by one. */
    for (size_t c = 0; c < total; c++)
        cells->start[c] = cells->start[c + 1];
    cells->start[total] = (uint32_t)n;
    return SCREE_OK;
}

/* What one grain looks for. */
struct search {
    const struct cells *cells;
    const struct dem *dem;
    uint32_t row, next; // rows of its own unit end before `next`
    double point[3], radius, skin;
    int image[3];
    uint32_t *found;
    size_t count, room;
    bool torn; // an image number out of range
};

/* Adds the grains of a cell whose rows are above those of the searcher's unit. Rows ascend: from the last one down to those. */
static enum scree_status search_cell(struct search *s, uint32_t cell, const double at[3], const int wrap[3],
                                     struct scree_error *err)
{
    const struct cells *cells = s->cells;
    const uint32_t *row = cells->row, first = cells->start[cell];
    double reach = s->radius + s->skin;
    for (uint32_t k = cells->start[cell + 1]; k-- > first && row[k] >= s->next;) {
        const double *q = cells->point[k];
        double x = q[0] - at[0], y = q[1] - at[1], z = q[2] - at[2], r = reach + q[3];
        if (x * x + y * y + z * z >= r * r)
            continue;
        int code = 0;
        for (int a = 2; a >= 0; a--) {
            int boxes = wrap[a] - cells->image[k][a] + s->image[a];
            s->torn |= boxes < -IMAGE_REACH || boxes > IMAGE_REACH;
            code = code * IMAGE_BASE + boxes + IMAGE_REACH;
        }
        enum scree_status status = memory_grow((void **)&s->found, &s->room, s->count + 1, sizeof *s->found, err);
        if (status)
            return status;
        s->found[s->count++] = row[k] | (uint32_t)code << IMAGE_SHIFT;
    }
    return SCREE_OK;
}

static enum scree_status search_cells(struct search *s, uint32_t from, uint32_t to, const int wrap[3], struct scree_error *err)
{
    double at[3];
    enum scree_status status = SCREE_OK;
    for (int a = 0; a < 3; a++)
        at[a] = s->point[a] - wrap[a] * s->dem->length[a];
    for (uint32_t cell = from; cell < to && !status; cell++)
        status = search_cell(s, cell, at, wrap, err);
    return status;
}

/* All neighbour cells of one row of cells along x, wrapped where needed. */
static enum scree_status search_row(struct search *s, const int cell[3], int wrap[3], struct scree_error *err)
{
    const struct cells *cells = s->cells;
    uint32_t base = (uint32_t)((cell[2] * cells->count[1] + cell[1]) * cells->count[0]);
    int from = cell[0] - 1, to = cell[0] + 2;
    int inside_from = from < 0 ? 0 : from, inside_to = to > cells->count[0] ? cells->count[0] : to;
    wrap[0] = 0;
    enum scree_status status = search_cells(s, base + (uint32_t)inside_from, base + (uint32_t)inside_to, wrap, err);
    if (status || s->dem->length[0] <= 0)
        return status;
    if (from < 0) {
        wrap[0] = -1;
        status = search_cells(s, base + (uint32_t)cells->count[0] - 1, base + (uint32_t)cells->count[0], wrap, err);
    }
    if (!status && to > cells->count[0]) {
        wrap[0] = 1;
        status = search_cells(s, base, base + 1, wrap, err);
    }
    return status;
}

static enum scree_status search_all(struct search *s, struct scree_error *err)
{
    const struct cells *cells = s->cells;
    uint32_t own = cells->cell[s->row];
    int c[3] = {(int)(own % (uint32_t)cells->count[0]), (int)(own / (uint32_t)cells->count[0] % (uint32_t)cells->count[1]),
                (int)(own / (uint32_t)cells->count[0] / (uint32_t)cells->count[1])};
    for (int dz = -1; dz <= 1; dz++)
        for (int dy = -1; dy <= 1; dy++) {
            int cell[3] = {c[0], c[1] + dy, c[2] + dz}, wrap[3] = {0, 0, 0};
            bool outside = false;
            for (int a = 1; a < 3; a++) {
                if (cell[a] >= 0 && cell[a] < cells->count[a])
                    continue;
                wrap[a] = cell[a] < 0 ? -1 : 1;
                cell[a] -= wrap[a] * cells->count[a];
                outside |= s->dem->length[a] <= 0;
            }
            enum scree_status status = outside ? SCREE_OK : search_row(s, cell, wrap, err);
            if (status)
                return status;
        }
    return SCREE_OK;
}

/* Few and nearly sorted: insertion. */
static void sort_ascending(uint32_t *items, size_t count)
{
    for (size_t k = 1; k < count; k++) {
        uint32_t item = items[k];
        size_t at = k;
        for (; at > 0 && items[at - 1] > item; at--)
            items[at] = items[at - 1];
        items[at] = item;
    }
}

enum scree_status cells_pairs(const struct cells *cells, const struct dem *dem, struct part *part, double skin,
                              struct scree_error *err)
{
    struct search s = {.cells = cells, .dem = dem, .skin = skin, .found = part->outer_second, .room = part->outer_second_room};
    enum scree_status status = SCREE_OK;
    for (size_t i = part->from; i < part->to && !status; i++) {
        size_t before = s.count;
        s.row = (uint32_t)i;
        s.next = (uint32_t)dem->motion->next(dem, i);
        s.radius = dem->position[i][3];
        for (int a = 0; a < 3; a++) {
            double x = dem->position[i][a], box = dem->length[a], boxes = box > 0 ? floor(x / box) : 0;
            s.image[a] = whole_part(boxes, INT8_MIN, INT8_MAX);
            s.point[a] = x - boxes * box;
        }
        status = search_all(&s, err);
        if (s.count > before)
            sort_ascending(s.found + before, s.count - before);
        if (!status)
            status = memory_grow((void **)&part->outer_first, &part->outer_room, s.count, sizeof *part->outer_first, err);
        for (size_t k = before; k < s.count && !status; k++)
            part->outer_first[k] = (uint32_t)i;
    }
    part->outer_second = s.found;
    part->outer_second_room = s.room;
    part->outer_count = s.count;
    if (!status && s.torn)
        status = scree_fail(err, SCREE_BLOWUP, NULL, "a grain crossed the periodic box within %d steps", DEM_HOUSEKEEPING);
    return status;
}

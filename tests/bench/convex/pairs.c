/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See pairs.h. Ours measures from crust to crust; the others get the same boxes
 * with their crusts on. */
#include "pairs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "base/memory.h"
#include "geom/gjk.h"

enum { TOUCHING, NEAR, FAR, CLASSES, ROUNDS = 20 };
static const char *const class_names[CLASSES] = {"touching", "near (< 1 mm)", "far"};

struct cores {
    struct gjk_core a, b;
    struct gjk_cache cache;
};
struct found {
    struct cores *cores;
    struct box_pair *boxes;
    size_t count, core_room, box_room;
};

double pairs_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static struct placed_box box_of(const struct composite_part *part, const struct gjk_core *core)
{
    struct placed_box box = {.half = {0, 0, 0}};
    for (int i = 0; i < 3; i++) {
        for (size_t v = 0; v < part->vertices; v++)
            box.half[i] = fmax(box.half[i], fabs(part->vertex[v][i]) + part->radius);
        vec3_store3(box.axis[i], core->turn.column[i]);
    }
    vec3_store3(box.centre, core->centre);
    return box;
}

static struct gjk_core core_of(const struct composite_part *part, const struct convex_body *b)
{
    return (struct gjk_core){part->vertex, part->vertices, quat_turn(quat_load(b->orientation)), vec3_load(b->position)};
}

static enum scree_status sort_in(const struct composite *shape, const struct convex_body *a, const struct convex_body *b,
                                 struct found found[CLASSES], struct scree_error *err)
{
    for (size_t p = 0; p < shape->parts; p++)
        for (size_t q = 0; q < shape->parts; q++) {
            const struct composite_part *pa = &shape->part[p], *pb = &shape->part[q];
            struct cores c = {core_of(pa, a), core_of(pb, b), {0}};
            struct gjk_result r;
            if (gjk_distance(&c.a, &c.b, &c.cache, &r) != GJK_APART)
                continue;
            double gap = r.distance - pa->radius - pb->radius;
            struct found *f = &found[gap <= 0 ? TOUCHING : gap < 1e-3 ? NEAR : FAR];
            enum scree_status status = memory_grow((void **)&f->cores, &f->core_room, f->count + 1, sizeof *f->cores, err);
            if (status || (status = memory_grow((void **)&f->boxes, &f->box_room, f->count + 1, sizeof *f->boxes, err)))
                return status;
            f->cores[f->count] = c;
            f->boxes[f->count++] = (struct box_pair){box_of(pa, &c.a), box_of(pb, &c.b)};
        }
    return SCREE_OK;
}

static double time_ours(struct found *f, bool warm, double *sum)
{
    double start = pairs_seconds();
    for (int round = 0; round < ROUNDS; round++)
        for (size_t k = 0; k < f->count; k++) {
            struct gjk_cache cache = warm ? f->cores[k].cache : (struct gjk_cache){0};
            struct gjk_result r;
            gjk_distance(&f->cores[k].a, &f->cores[k].b, &cache, &r);
            *sum += r.distance;
        }
    return 1e9 * (pairs_seconds() - start) / (ROUNDS * (double)f->count);
}

enum scree_status pairs_compare(struct convex *world, const struct composite *shape, struct scree_error *err)
{
    struct found found[CLASSES] = {{.count = 0}};
    enum scree_status status = SCREE_OK;
    double sum = 0;
    for (size_t i = 0; i < convex_bodies(world) && !status; i++)
        for (size_t j = i + 1; j < convex_bodies(world) && !status; j++) {
            struct convex_body a, b;
            convex_look(world, i, &a);
            convex_look(world, j, &b);
            double d2 = 0;
            for (int k = 0; k < 3; k++)
                d2 += (a.position[k] - b.position[k]) * (a.position[k] - b.position[k]);
            if (d2 < 4 * shape->reach * shape->reach)
                status = sort_in(shape, &a, &b, found, err);
        }
    for (int k = 0; k < CLASSES && !status; k++) {
        struct found *f = &found[k];
        if (f->count == 0)
            continue;
        printf("%s, %zu pairs, ns each: GJK from the last corners %.0f, from none %.0f", class_names[k], f->count,
               time_ours(f, true, &sum), time_ours(f, false, &sum));
        for (int o = 0; o < other_count; o++) {
            unsigned long overlapping;
            double ns = others[o].time(f->boxes, f->count, ROUNDS, &overlapping);
            printf("; %s %.0f (%lu overlap)", others[o].name, ns, overlapping);
        }
        printf("\n");
    }
    if (!status && !(sum > 0))
        printf("no pairs\n");
    for (int k = 0; k < CLASSES; k++) {
        free(found[k].cores);
        free(found[k].boxes);
    }
    return status;
}

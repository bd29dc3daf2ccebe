/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See mobility.h.
 *
 * Flow proper. The paper takes all particles on the chute that touch one another
 * and leaves out those in front that came alone; here that is the largest set
 * connected by contacts (targets S3-12).
 * Unit of beta. With delta and V^(1/3) in metres the published lines would span
 * mu_A by 0.0005: they hold for delta and V^(1/3) in mm and w in cm (erratum). */
#include "measure/mobility.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

#define FRONT_CUT 0.03 // m, of the uncertainty bar

void fragment_row(const struct view_body *b, int in_flow, double row[FRAGMENT_COLUMNS])
{
    const double all[FRAGMENT_COLUMNS] = {
        b->id,          b->shape,          in_flow,           b->mass,           b->position[0],    b->position[1],
        b->position[2], b->orientation[0], b->orientation[1], b->orientation[2], b->orientation[3], b->velocity[0],
        b->velocity[1], b->velocity[2],    b->members,        b->volume};
    memcpy(row, all, sizeof all);
}

/* ---- sums ---- */

struct mean { // of places
    double mass, at[3];
};

static void mean_add(struct mean *m, double mass, const double at[3])
{
    m->mass += mass;
    for (int a = 0; a < 3; a++)
        m->at[a] += mass * at[a];
}

/* h / l between two centres of mass (eq. 14). */
static double drop_over_way(const struct mean *from, const struct mean *to)
{
    double h = from->at[2] / from->mass - to->at[2] / to->mass, l = to->at[0] / to->mass - from->at[0] / from->mass;
    return h / l;
}

/* ---- the flow proper ---- */

static uint32_t root_of(uint32_t *parent, uint32_t k)
{
    while (parent[k] != k)
        k = parent[k] = parent[parent[k]];
    return k;
}

/* Marks the largest set of bodies connected by contacts; returns how many. */
static size_t connect(const struct view *view, const uint32_t *body_of, uint32_t *parent, uint32_t *size, uint8_t *in_flow)
{
    for (uint32_t k = 0; k < view->bodies; k++) {
        parent[k] = k;
        size[k] = 0;
    }
    for (size_t c = 0; c < view->contacts; c++) {
        const struct view_contact *contact = &view->contact[c];
        if (contact->b >= view->moving)
            continue;
        uint32_t a = root_of(parent, body_of[contact->a]), b = root_of(parent, body_of[contact->b]);
        parent[a > b ? a : b] = a > b ? b : a;
    }
    uint32_t largest = 0;
    for (uint32_t k = 0; k < view->bodies; k++)
        size[root_of(parent, k)]++;
    for (uint32_t k = 1; k < view->bodies; k++)
        largest = size[k] > size[largest] ? k : largest;
    for (uint32_t k = 0; k < view->bodies; k++)
        in_flow[k] = root_of(parent, k) == largest;
    return size[largest];
}

/* ---- ranks ---- */

struct ranked {
    double value;
    uint32_t body;
};

static int by_value(const void *a, const void *b)
{
    const struct ranked *p = a, *q = b;
    if (p->value != q->value)
        return p->value < q->value ? -1 : 1;
    return (p->body > q->body) - (p->body < q->body);
}

/* Mean rank, 0..1, of the bodies of the largest volume among the flow proper. */
static double rank_of_largest(const struct view *view, struct ranked *items, size_t count)
{
    double largest = 0, sum = 0;
    size_t cubes = 0;
    qsort(items, count, sizeof *items, by_value);
    for (size_t k = 0; k < count; k++)
        largest = fmax(largest, view->body[items[k].body].volume);
    for (size_t k = 0; k < count; k++)
        if (view->body[items[k].body].volume > 0.99 * largest) {
            sum += ((double)k + 0.5) / (double)count;
            cubes++;
        }
    return sum / (double)cubes;
}

/* Scratch of one measurement. */
struct scratch {
    uint32_t *body_of, *parent, *size;
    uint8_t *in_flow;
    double *along;
    struct ranked *ranked;
};

static void scratch_free(struct scratch *s)
{
    free(s->body_of);
    free(s->parent);
    free(s->size);
    free(s->in_flow);
    free(s->along);
    free(s->ranked);
}

static enum scree_status scratch_make(struct scratch *s, const struct view *view, const struct mobility_site *site,
                                      struct scree_error *err)
{
    *s = (struct scratch){.body_of = memory_rows(view->moving, sizeof *s->body_of),
                          .parent = memory_rows(view->bodies, sizeof *s->parent),
                          .size = memory_rows(view->bodies, sizeof *s->size),
                          .in_flow = memory_rows(view->bodies, 1),
                          .along = memory_rows(view->bodies, sizeof *s->along),
                          .ranked = memory_rows(view->bodies, sizeof *s->ranked)};
    if (!s->body_of || !s->parent || !s->size || !s->in_flow || !s->along || !s->ranked) {
        scratch_free(s);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to measure %zu bodies", view->bodies);
    }
    for (uint32_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        for (uint32_t i = 0; i < b->members; i++)
            s->body_of[b->first + i] = k;
        s->along[k] = chute_arc(&site->chute, b->position[0]);
    }
    return SCREE_OK;
}

static void measure_ranks(const struct view *view, const struct mobility_site *site, struct scratch *s, struct mobility *out)
{
    size_t n = 0;
    for (uint32_t k = 0; k < view->bodies; k++)
        if (s->in_flow[k])
            s->ranked[n++] = (struct ranked){s->along[k], k};
    out->cube_front = rank_of_largest(view, s->ranked, n);
    for (size_t k = 0; k < n; k++) {
        s->ranked[k].value = chute_height(&site->chute, view->body[s->ranked[k].body].position);
    }
    out->cube_height = rank_of_largest(view, s->ranked, n);
}

enum scree_status mobility_measure(const struct view *view, const struct mobility_site *site, struct mobility *out,
                                   uint8_t *in_flow, struct scree_error *err)
{
    struct scratch s;
    enum scree_status status = scratch_make(&s, view, site, err);
    if (status)
        return status;
    struct mean start = {0}, own = {0}, flow = {0}, all = {0}, cut = {0};
    *out = (struct mobility){.bodies = view->bodies, .front = -INFINITY, .rear = INFINITY};
    out->in_flow = connect(view, s.body_of, s.parent, s.size, s.in_flow);
    for (size_t k = 0; k < site->count; k++)
        mean_add(&start, site->release[k][3], site->release[k]);
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        mean_add(&all, b->mass, b->position);
        if (!s.in_flow[k])
            continue;
        mean_add(&flow, b->mass, b->position);
        mean_add(&own, b->mass, site->release[b->id]);
        out->volume += b->volume;
        out->front = fmax(out->front, s.along[k]);
        out->rear = fmin(out->rear, s.along[k]);
    }
    for (size_t k = 0; k < view->bodies; k++)
        if (s.in_flow[k] && s.along[k] <= out->front - FRONT_CUT)
            mean_add(&cut, view->body[k].mass, view->body[k].position);
    out->mass = flow.mass;
    out->mobility = drop_over_way(&start, &flow);
    out->trimmed = drop_over_way(&own, &flow);
    out->upper = drop_over_way(&start, cut.mass > 0 ? &cut : &flow);
    out->lower = drop_over_way(&start, &all);
    double width_cm = 100 * site->chute.width;
    out->beta = 1e3 * site->grain_m * 1e3 * cbrt(out->volume) / (width_cm * width_cm);
    for (size_t c = 0; c < view->contacts; c++)
        out->overlap = fmax(out->overlap, view->contact[c].overlap / site->grain_m);
    measure_ranks(view, site, &s, out);
    if (in_flow)
        memcpy(in_flow, s.in_flow, view->bodies);
    scratch_free(&s);
    return SCREE_OK;
}

/* ---- on the way ---- */

/* The place along the chute that half of the mass has not reached. */
static double median_place(const struct view *view, const struct scratch *s)
{
    double mass = 0, sum = 0;
    for (uint32_t k = 0; k < view->bodies; k++) {
        s->ranked[k] = (struct ranked){s->along[k], k};
        mass += view->body[k].mass;
    }
    qsort(s->ranked, view->bodies, sizeof *s->ranked, by_value);
    for (size_t k = 0; k < view->bodies; k++) {
        sum += view->body[s->ranked[k].body].mass;
        if (sum >= 0.5 * mass)
            return s->ranked[k].value;
    }
    return 0;
}

/* Mean and largest overlap of all contacts, in grain sizes. */
static void measure_overlaps(const struct view *view, const struct mobility_site *site, double out[2])
{
    out[0] = out[1] = 0;
    for (size_t c = 0; c < view->contacts; c++) {
        double overlap = view->contact[c].overlap / site->grain_m;
        out[0] += overlap / (double)view->contacts;
        out[1] = fmax(out[1], overlap);
    }
}

/* Between which places on the curved chute the middle nine tenths of the bodies that lie still are; 0, 0 where none do. */
static void measure_still(const struct view *view, struct scratch *s, double out[2])
{
    size_t count = 0;
    out[0] = out[1] = 0;
    for (uint32_t k = 0; k < view->bodies; k++) {
        const double *v = view->body[k].velocity;
        if (s->along[k] > 0 && v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < FLOW_STILL * FLOW_STILL)
            s->ranked[count++] = (struct ranked){s->along[k], k};
    }
    if (count == 0)
        return;
    qsort(s->ranked, count, sizeof *s->ranked, by_value);
    out[0] = s->ranked[count / 20].value;
    out[1] = s->ranked[count - 1 - count / 20].value;
}

enum scree_status flow_measure(const struct view *view, const struct mobility_site *site, double row[FLOW_COLUMNS],
                               struct scree_error *err)
{
    struct scratch s;
    enum scree_status status = scratch_make(&s, view, site, err);
    if (status)
        return status;
    double place = median_place(view, &s), g = sqrt(view->gravity[0] * view->gravity[0] + view->gravity[1] * view->gravity[1] +
                                                    view->gravity[2] * view->gravity[2]);
    double mass = 0, count = 0, across = 0, across2 = 0, speed = 0, translation = 0, rotation = 0, potential = 0, at_start = 0;
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        const double *v = b->velocity, *w = b->spin, *l = b->momentum;
        if (fabs(s.along[k] - place) > FLOW_CENTRAL_HALF)
            continue;
        double slope = chute_slope(&site->chute, b->position[0]);
        count += 1;
        mass += b->mass;
        across += v[1];
        across2 += v[1] * v[1];
        speed += b->mass * (v[0] * cos(slope) - v[2] * sin(slope));
        translation += 0.5 * b->mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        rotation += 0.5 * (w[0] * l[0] + w[1] * l[1] + w[2] * l[2]);
        potential += b->mass * g * b->position[2];
        at_start += b->mass * g * site->release[b->id][2];
    }
    double overlap[2], still[2];
    measure_overlaps(view, site, overlap);
    measure_still(view, &s, still);
    const double all[FLOW_COLUMNS] = {view->time_s,
                                      place,
                                      count,
                                      across2 / count - (across / count) * (across / count),
                                      speed / mass,
                                      translation / mass,
                                      rotation / mass,
                                      potential / mass,
                                      (at_start - translation - rotation - potential) / mass,
                                      overlap[0],
                                      overlap[1],
                                      still[0],
                                      still[1]};
    memcpy(row, all, sizeof all);
    scratch_free(&s);
    return SCREE_OK;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See contact.h. Outside the contact grains fly straight, so its beginning and
 * end can be placed within a step from the first overlap and the first gap. */
#include "measure/contact.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "calibrate/impact.h"
#include "measure/measure.h"

static const struct scree_column columns[CONTACT_COLUMNS] = {
    {"time", "s"},    {"overlap", "m"}, {"approach", "m/s"},  {"force_normal", "N"}, {"force_x", "N"},
    {"force_y", "N"}, {"force_z", "N"}, {"torque1_x", "N m"}, {"torque1_y", "N m"},  {"torque1_z", "N m"},
};
static const struct scree_stream contact_stream = {"contact", "overlap and force of the one contact, of grain 1 on what it meets",
                                                   columns, CONTACT_COLUMNS, false};

/* Row of the grain with that id, or -1. */
static long row_of(const struct view *view, uint32_t id)
{
    for (size_t i = 0; i < view->moving + view->fixed; i++)
        if (view->id[i] == id)
            return (long)i;
    return -1;
}

static double kinetic(const struct view *view)
{
    double sum = 0;
    for (size_t i = 0; i < view->moving; i++)
        for (int a = 0; a < 3; a++)
            sum += 0.5 * view->velocity[i][3] * view->velocity[i][a] * view->velocity[i][a] +
                   0.5 * view->spin[i][3] * view->spin[i][a] * view->spin[i][a];
    return sum;
}

static void relative_velocity(const struct view *view, double out[3])
{
    long one = row_of(view, 0), two = row_of(view, 1);
    for (int a = 0; a < 3; a++)
        out[a] = view->velocity[one][a] - (two >= 0 ? view->velocity[two][a] : 0);
}

/* Distance between the surfaces when they do not touch, m. */
static double gap(const struct view *view)
{
    long one = row_of(view, 0), two = row_of(view, 1);
    const double *x = view->position[one];
    if (two < 0)
        return x[2] - x[3];
    const double *y = view->position[two];
    return sqrt((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) + (x[2] - y[2]) * (x[2] - y[2])) - x[3] - y[3];
}

static void finish(const struct view *view, struct contact_trace *t)
{
    relative_velocity(view, t->after);
    double opening = (gap(view) + t->last_overlap) / (view->time_s - t->last_s);
    t->end_s = opening > 0 ? view->time_s - gap(view) / opening : view->time_s;
    t->dissipated = t->energy_before - kinetic(view);
    for (uint32_t id = 0; id < 2; id++) {
        long row = row_of(view, id);
        if (row >= 0)
            memcpy(t->spin_after[id], view->spin[row], sizeof t->spin_after[id]);
    }
    t->ended = true;
}

void contact_measure(const struct view *view, struct contact_trace *t, double row[CONTACT_COLUMNS])
{
    memset(row, 0, CONTACT_COLUMNS * sizeof *row);
    row[0] = view->time_s;
    double force[3] = {0};
    if (view->contacts == 0) {
        row[1] = -gap(view);
        if (t->touching) {
            finish(view, t);
        } else {
            relative_velocity(view, t->before);
            t->energy_before = kinetic(view);
        }
        t->touching = false;
    } else {
        const struct view_contact *c = &view->contact[0];
        /* Forces are of grain 1 on what it meets, whichever row came first. */
        double sign = view->id[c->a] == 0 ? 1 : -1;
        if (!t->touching)
            t->start_s = t->before[2] != 0 ? view->time_s - c->overlap / fabs(t->before[2]) : view->time_s;
        t->touching = true;
        t->samples++;
        t->last_s = view->time_s;
        t->last_overlap = c->overlap;
        t->last_approach = c->approach;
        t->largest_overlap = fmax(t->largest_overlap, c->overlap);
        t->largest_force = fmax(t->largest_force, c->force_normal);
        row[1] = c->overlap;
        row[2] = c->approach;
        row[3] = c->force_normal;
        for (int a = 0; a < 3; a++) {
            row[4 + a] = force[a] = sign * c->force[a];
            row[7 + a] = sign > 0 ? c->torque_a[a] : c->torque_b[a];
        }
    }
    /* Kicks are force times step at each step: the sum is the impulse that was exchanged. */
    for (int a = 0; a < 3; a++)
        t->impulse[a] += force[a] * view->step_s;
    memcpy(t->last_force, force, sizeof force);
}

size_t contact_summary(const struct contact_trace *t, double step_s, struct scree_number numbers[CONTACT_NUMBERS])
{
    if (!t->ended)
        return 0;
    double duration = t->end_s - t->start_s;
    double slide_before = hypot(t->before[0], t->before[1]), slide_after = hypot(t->after[0], t->after[1]);
    const struct scree_number all[] = {
        {"restitution", "1", "normal speed of separation over that of approach", -t->after[2] / t->before[2]},
        {"contact_time", "s", "duration of the contact, interpolated within a step", duration},
        {"steps_per_contact", "1", "contact time over time step", duration / step_s},
        {"largest_overlap", "m", "", t->largest_overlap},
        {"largest_normal_force", "N", "", t->largest_force},
        {"impulse_x", "N s", "of grain 1 on what it meets", t->impulse[0]},
        {"impulse_y", "N s", "", t->impulse[1]},
        {"impulse_z", "N s", "", t->impulse[2]},
        {"slide_before", "m/s", "relative velocity of the centres in the plane of contact, before", slide_before},
        {"slide_after", "m/s", "and after", slide_after},
        {"dissipated", "J", "kinetic energy lost", t->dissipated},
        {"spin1_x", "rad/s", "of grain 1 afterwards", t->spin_after[0][0]},
        {"spin1_y", "rad/s", "", t->spin_after[0][1]},
        {"spin1_z", "rad/s", "", t->spin_after[0][2]},
        {"spin2_x", "rad/s", "of the sphere it met", t->spin_after[1][0]},
        {"spin2_y", "rad/s", "", t->spin_after[1][1]},
        {"spin2_z", "rad/s", "", t->spin_after[1][2]},
    };
    _Static_assert(sizeof all / sizeof *all == CONTACT_NUMBERS, "as the header says");
    memcpy(numbers, all, sizeof all);
    return sizeof all / sizeof *all;
}

/* ---- the measurement ---- */

enum { CHUNK = 256 };
static const struct scree_stream *const streams[] = {&contact_stream};

/* The error that time steps make in the normal force of a head-on impact (seed 000 S4.5): the equation of motion is solved
 * beside the run, from the instant at which the surfaces met, and compared at every step. */
struct force_check {
    struct impact truth;
    double unit;          // of its force, N
    double tau;           // of its time, s
    double error2, size2; // sums of squares over steps, N2
};

struct state {
    struct contact_trace trace;
    struct force_check check;
    struct series series;
};

/* Is normal motion all there is? */
static bool head_on(const struct job_spec *job)
{
    const struct collision_params *p = (const struct collision_params *)(const void *)job->params;
    static const double none[3];
    return memcmp(p->tangential_m_s, none, sizeof none) == 0 && memcmp(p->spin1_rad_s, none, sizeof none) == 0 &&
           memcmp(p->spin2_rad_s, none, sizeof none) == 0 && memcmp(p->gravity_m_s2, none, sizeof none) == 0;
}

static void start_check(struct force_check *check, const struct job_spec *job, const struct view *view, double speed)
{
    const struct material_spec *m = &job->material;
    long one = row_of(view, 0), two = row_of(view, 1);
    double mass = view->velocity[one][3], radius = view->position[one][3];
    double beta = collision_kind(job) == BEAD_WALL ? m->wall.beta_s : m->beta_s;
    if (two >= 0) {
        double other = view->velocity[two][3], r = view->position[two][3];
        mass = (size_t)two < view->moving ? mass * other / (mass + other) : mass;
        radius = radius * r / (radius + r);
    }
    double length = impact_length(mass, radius, material_plane_modulus(m, collision_kind(job)), speed);
    check->tau = length / speed;
    check->unit = mass * speed * speed / length;
    impact_start(&check->truth, beta / check->tau);
}

/* One step of contact, or the one after it; `force` is the world's. */
static void check_force(struct force_check *check, double time_in_contact, double force)
{
    impact_advance(&check->truth, time_in_contact / check->tau - check->truth.time);
    double truth = check->unit * impact_force(&check->truth);
    check->error2 += (force - truth) * (force - truth);
    check->size2 += truth * truth;
}

static size_t chunk(const struct measure_context *context)
{
    (void)context;
    return CHUNK;
}

static enum scree_status first(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    double row[CONTACT_COLUMNS];
    (void)context;
    (void)err;
    contact_measure(now->grains, &((struct state *)state)->trace, row);
    return SCREE_OK;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    double row[CONTACT_COLUMNS];
    contact_measure(now->grains, &s->trace, row);
    if (s->trace.touching && s->check.tau == 0 && head_on(context->job))
        start_check(&s->check, context->job, now->grains, -s->trace.before[2]);
    if (s->check.tau > 0)
        check_force(&s->check, context->time_s - s->trace.start_s, row[3]);
    context->stop = context->stop || s->trace.ended;
    return series_add(&s->series, context->sink, context->time_s, row, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    (void)now;
    const struct state *s = state;
    struct scree_number all[CONTACT_NUMBERS + 2];
    size_t count = contact_summary(&s->trace, context->job->time.step_s, all);
    double g = -context->gravity[2], up = s->trace.after[2];
    if (count > 0 && g > 0)
        all[count++] =
            (struct scree_number){"rebound_height", "m", "that grain 1 rises to by what it keeps of its speed", 0.5 * up * up / g};
    if (count > 0 && s->check.tau > 0)
        all[count++] = (struct scree_number){"force_error", "1",
                                             "root mean square error of the normal force at each step over that of the force",
                                             sqrt(s->check.error2 / s->check.size2)};
    return measure_numbers(out, room, all, count);
}

const struct measurement measure_contact = {
    .name = "contact",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .chunk = chunk,
    .first = first,
    .sample = sample,
    .numbers = numbers,
};

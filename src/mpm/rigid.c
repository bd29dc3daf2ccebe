/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walls of the box and rigid boxes with imposed motion: which nodes they hold,
 * and how much room they leave.
 *
 * Contact is at nodes: a node on a wall, or on or inside a body, may leave along
 * the normal, may not enter, and its slip is resisted by mu times the normal push
 * (Signorini and Coulomb). With lumped mass a node's own block is isotropic, so
 * the row has a closed form (kernels.c). A body takes its volume from the nodes'
 * room exactly (integrals of hat functions), so that material against it can be
 * dense. The published code spreads a body over one cell of level set instead. */
#include <math.h>

#include "mpm/state.h"

double rigid_way(const struct mpm_body *body, double time, int axis)
{
    double t = time - body->start_s;
    if (t <= 0)
        return 0;
    if (body->tau_s <= 0)
        return body->velocity[axis] * t;
    /* Integral of U. expm1 keeps small times exact. */
    return body->velocity[axis] * (t + body->tau_s * expm1(-t / body->tau_s));
}

void rigid_tilt(struct mpm *mpm)
{
    const struct mpm_tilt *tilt = &mpm->tilt;
    if (!(tilt->hold_s > 0))
        return;
    double turns = floor((mpm_time(mpm) + 1e-9 * tilt->hold_s) / tilt->hold_s), *g = mpm->gravity;
    double angle = fmin(tilt->from + turns * tilt->step, tilt->to);
    g[0] = tilt->weight * sin(angle);
    g[1] = 0;
    g[2] = -tilt->weight * cos(angle);
}

/* The face's axis, and whether a node lies on it. */
static bool on_face(const struct mpm *mpm, const int place[3], int face)
{
    int axis = face / 2;
    if (mpm->grid.flat[axis])
        return false;
    return place[axis] == (face % 2 ? mpm->grid.cells[axis] : 0);
}

bool rigid_sticks(const struct mpm *mpm, const int place[3], double velocity[3])
{
    for (int face = 0; face < MPM_FACES; face++)
        if (mpm->walls[face].kind == MPM_STICK && on_face(mpm, place, face)) {
            for (int a = 0; a < 3; a++)
                velocity[a] = mpm->walls[face].velocity[a];
            return true;
        }
    return false;
}

bool rigid_floor(const struct mpm *mpm, const int place[3])
{
    return on_face(mpm, place, MPM_Z_LOW);
}

static void body_box(const struct mpm *mpm, const struct mpm_body *body, double low[3], double high[3])
{
    double time = mpm_time(mpm);
    for (int a = 0; a < 3; a++) {
        double way = rigid_way(body, time, a);
        low[a] = body->low[a] + way;
        high[a] = body->high[a] + way;
    }
}

double rigid_room(const struct mpm *mpm, const int place[3])
{
    const double zero[3] = {0, 0, 0};
    double room = grid_node_volume(&mpm->grid, place, zero, mpm->grid.length);
    for (size_t k = 0; k < mpm->body_count; k++) {
        double low[3], high[3];
        body_box(mpm, &mpm->bodies[k], low, high);
        room -= grid_node_volume(&mpm->grid, place, low, high);
    }
    return fmax(room, 0);
}

/* The node's nearest side of the body; false if it is outside. Depths that are
 * equal within rounding go to the lower axis: a gate holds its column at its edges. */
static bool body_side(const struct mpm *mpm, const int place[3], const double low[3], const double high[3], double normal[3])
{
    double best = INFINITY;
    int side = -1;
    for (int a = 0; a < 3; a++) {
        if (mpm->grid.flat[a])
            continue;
        double x = place[a] * mpm->grid.spacing[a], slack = 1e-6 * mpm->grid.spacing[a];
        double below = x - low[a], above = high[a] - x;
        if (below < -slack || above < -slack)
            return false;
        /* Sides outside the box hold nothing back. */
        if (low[a] > 0 && below < best - slack) {
            best = below;
            side = 2 * a;
        }
        if (high[a] < mpm->grid.length[a] && above < best - slack) {
            best = above;
            side = 2 * a + 1;
        }
    }
    if (side < 0)
        return false;
    for (int a = 0; a < 3; a++)
        normal[a] = a == side / 2 ? (side % 2 ? 1 : -1) : 0;
    return true;
}

static void add_contact(struct mpm *mpm, size_t node, uint32_t owner, const double normal[3], double mu, const double velocity[3],
                        size_t *seen)
{
    struct contact *c = &mpm->contacts[mpm->contact_count++];
    double scale = mpm->scale[node];
    *c = (struct contact){.normal = v4_set(normal[0], normal[1], normal[2], 0),
                          .velocity = v4_set(velocity[0] / scale, velocity[1] / scale, velocity[2] / scale, 0),
                          .mu = mu,
                          .scale = scale,
                          .node = (uint32_t)node,
                          .owner = owner};
    /* Warm: the same force, N, as the last step's contact of the same node and owner; both lists run alike. */
    while (*seen < mpm->last_contact_count && (mpm->last_contacts[*seen].node < node ||
                                               (mpm->last_contacts[*seen].node == node && mpm->last_contacts[*seen].owner < owner)))
        ++*seen;
    if (*seen < mpm->last_contact_count && mpm->last_contacts[*seen].node == node && mpm->last_contacts[*seen].owner == owner)
        c->push = mpm->last_contacts[*seen].force * v4_all(scale);
    c->last = c->push;
}

static void node_contacts(struct mpm *mpm, size_t node, const int place[3], size_t *seen)
{
    for (int face = 0; face < MPM_FACES; face++) {
        const struct mpm_wall *wall = &mpm->walls[face];
        if (wall->kind == MPM_STICK || !on_face(mpm, place, face))
            continue;
        double normal[3] = {0, 0, 0};
        normal[face / 2] = face % 2 ? -1 : 1;
        add_contact(mpm, node, (uint32_t)face, normal, wall->kind == MPM_FRICTION ? wall->mu : 0, wall->velocity, seen);
    }
    for (size_t k = 0; k < mpm->body_count; k++) {
        double low[3], high[3], normal[3], velocity[3], time = mpm_time(mpm);
        body_box(mpm, &mpm->bodies[k], low, high);
        if (!body_side(mpm, place, low, high, normal))
            continue;
        for (int a = 0; a < 3; a++) // the mean over the step, so that the node keeps up with the body
            velocity[a] = (rigid_way(&mpm->bodies[k], time + mpm->step_s, a) - rigid_way(&mpm->bodies[k], time, a)) / mpm->step_s;
        add_contact(mpm, node, (uint32_t)(MPM_FACES + k), normal, mpm->bodies[k].mu, velocity, seen);
    }
}

void rigid_contacts(struct mpm *mpm)
{
    struct contact *last = mpm->last_contacts;
    size_t seen = 0;
    mpm->last_contacts = mpm->contacts;
    mpm->last_contact_count = mpm->contact_count;
    mpm->contacts = last;
    mpm->contact_count = 0;
    mpm->field.contacts = mpm->contacts;
    for (size_t r = 0; r < mpm->row_count; r++) {
        struct row *row = &mpm->rows[r];
        int place[3];
        grid_node_place(&mpm->grid, row->node, place);
        row->contact = (uint32_t)mpm->contact_count;
        if (mpm->scale[row->node] > 0) // a node that sticks is held already
            node_contacts(mpm, row->node, place, &seen);
        row->contacts = (uint32_t)mpm->contact_count - row->contact;
    }
}

size_t rigid_contacts_most(const struct grid *grid, size_t bodies)
{
    size_t layers[3];
    for (int a = 0; a < 3; a++)
        layers[a] = (size_t)grid_layers(grid, a);
    return 2 * (layers[1] * layers[2] + layers[0] * layers[2] + layers[0] * layers[1]) + bodies * layers[0] * layers[1] * layers[2];
}

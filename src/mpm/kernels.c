/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See kernels.h. KERNELS names this instruction set's table.
 *
 * A row of the sweep gathers its strain rate from 27 nodes, turns it into its own
 * eigenbasis, solves for its stress there (local.h), turns the change back and
 * scatters it. The same node's contacts come just before. */
#include "mpm/kernels.h"

#include <math.h>
#include <string.h>

#include "mpm/local.h"

/* A visit solves its row to this squared, relatively: far below what the next visits of its neighbours change. */
#define LOCAL_NEAR 1e-4

/* A 3 x 3 matrix as columns whose lanes are rows. */
struct columns {
    v4 c0, c1, c2;
};

SIMD_INLINE v4 v4_broadcast(const double *a)
{
    return (v4){*a, *a, *a, *a};
}

/* G = sum_i w_i (x) c_i over the row's neighbours: lanes are components of w. */
SIMD_INLINE struct columns gather(const struct field *f, const struct row *row, const double *c)
{
    v4 sum[3][3] = {{{0}}}; // one set a place in the run, so that additions do not wait for each other
    for (int r = 0; r < f->runs; r++) {
        const double(*w)[4] = (const double(*)[4])(f->w + (ptrdiff_t)row->node + f->run[r]);
        for (int k = 0; k < 3; k++, c += 3) {
            v4 u = v4_load(w[k]);
            sum[k][0] += u * v4_broadcast(c);
            sum[k][1] += u * v4_broadcast(c + 1);
            sum[k][2] += u * v4_broadcast(c + 2);
        }
    }
    return (struct columns){sum[0][0] + sum[1][0] + sum[2][0], sum[0][1] + sum[1][1] + sum[2][1],
                            sum[0][2] + sum[1][2] + sum[2][2]};
}

/* w_i += D c_i for a symmetric D given by columns. */
SIMD_INLINE void scatter(const struct field *f, const struct row *row, const double *c, struct columns d)
{
    for (int r = 0; r < f->runs; r++) {
        double(*w)[4] = f->w + (ptrdiff_t)row->node + f->run[r];
        for (int k = 0; k < 3; k++, c += 3)
            v4_store(w[k], v4_load(w[k]) + (d.c0 * v4_broadcast(c) + d.c1 * v4_broadcast(c + 1) + d.c2 * v4_broadcast(c + 2)));
    }
}

/* m q, by columns. */
SIMD_INLINE struct columns times_basis(struct columns m, const double q[3][4])
{
    return (struct columns){m.c0 * v4_broadcast(&q[0][0]) + m.c1 * v4_broadcast(&q[1][0]) + m.c2 * v4_broadcast(&q[2][0]),
                            m.c0 * v4_broadcast(&q[0][1]) + m.c1 * v4_broadcast(&q[1][1]) + m.c2 * v4_broadcast(&q[2][1]),
                            m.c0 * v4_broadcast(&q[0][2]) + m.c1 * v4_broadcast(&q[1][2]) + m.c2 * v4_broadcast(&q[2][2])};
}

SIMD_INLINE struct columns transposed(struct columns m)
{
    const v4 zero = {0, 0, 0, 0};
    v4 c0, c1, c2, c3;
    v4_transpose(m.c0, m.c1, m.c2, zero, &c0, &c1, &c2, &c3);
    return (struct columns){c0, c1, c2};
}

/* sym(q^T g q): diagonal parts, and {yz, zx, xy}. */
SIMD_INLINE void turn_in(struct columns g, const double q[3][4], v4 *diagonal, v4 *off)
{
    /* q^T (g q) = ((g q)^T q)^T, and only the symmetric part is wanted. */
    struct columns s = times_basis(transposed(times_basis(g, q)), q);
    *diagonal = v4_set(s.c0[0], s.c1[1], s.c2[2], 0);
    *off = (v4_set(s.c1[2], s.c2[0], s.c0[1], 0) + v4_set(s.c2[1], s.c0[2], s.c1[0], 0)) * v4_all(0.5);
}

/* q m q^T for a symmetric m given by parts. */
SIMD_INLINE struct columns turn_out(v4 diagonal, v4 off, const double q[3][4])
{
    struct columns m = {v4_set(diagonal[0], off[2], off[1], 0), v4_set(off[2], diagonal[1], off[0], 0),
                        v4_set(off[1], off[0], diagonal[2], 0)};
    v4 q0 = v4_load(q[0]), q1 = v4_load(q[1]), q2 = v4_load(q[2]);
    /* m q^T: column b is sum_k m_k q[b][k]. */
    struct columns h = {m.c0 * v4_all(q0[0]) + m.c1 * v4_all(q0[1]) + m.c2 * v4_all(q0[2]),
                        m.c0 * v4_all(q1[0]) + m.c1 * v4_all(q1[1]) + m.c2 * v4_all(q1[2]),
                        m.c0 * v4_all(q2[0]) + m.c1 * v4_all(q2[1]) + m.c2 * v4_all(q2[2])};
    /* q h, and the result is symmetric: (h^T q^T)^T. */
    struct columns t = transposed(h);
    return (struct columns){t.c0 * v4_all(q0[0]) + t.c1 * v4_all(q0[1]) + t.c2 * v4_all(q0[2]),
                            t.c0 * v4_all(q1[0]) + t.c1 * v4_all(q1[1]) + t.c2 * v4_all(q1[2]),
                            t.c0 * v4_all(q2[0]) + t.c1 * v4_all(q2[1]) + t.c2 * v4_all(q2[2])};
}

/* The push that Signorini and Coulomb ask for, given w without it: the node's block is the identity in w. */
SIMD_INLINE v4 contact_push(const struct contact *c, v4 w)
{
    const v4 zero = {0, 0, 0, 0};
    v4 away = w - c->velocity;
    double along = v4_sum3(away * c->normal);
    if (along >= 0)
        return zero;
    v4 slip = away - v4_all(along) * c->normal;
    double size = sqrt(v4_sum3(slip * slip)), most = -along * c->mu;
    double share = size <= most ? 1 : most / size;
    return v4_all(-along) * c->normal - v4_all(share) * slip;
}

/* Contacts of one node share its velocity: in a corner they are visited in turn until they agree. */
SIMD_INLINE void visit_contacts(const struct field *f, const struct row *row)
{
    enum { TURNS = 12 };
    v4 w = v4_load(f->w[row->node]);
    for (int turn = 0; turn < TURNS; turn++) {
        double change = 0;
        for (uint32_t k = 0; k < row->contacts; k++) {
            struct contact *c = &f->contacts[row->contact + k];
            v4 push = contact_push(c, w - c->push), delta = push - c->push;
            w += delta;
            c->push = push;
            change += v4_sum3(delta * delta);
        }
        if (row->contacts < 2 || change <= 1e-24 * v4_sum3(w * w))
            break;
    }
    v4_store(f->w[row->node], w);
}

/* Nobody else reads a row's stress or a contact's push, so they are extrapolated when their turn comes. */
SIMD_INLINE void advance_row(const struct field *f, struct row *row, double weight)
{
    v4 b = v4_all(weight), d = row->stress_d, o = row->stress_o;
    row->stress_d = d + b * (d - row->last_d);
    row->stress_o = o + b * (o - row->last_o);
    row->last_d = d;
    row->last_o = o;
    for (uint32_t k = 0; k < row->contacts; k++) {
        struct contact *c = &f->contacts[row->contact + k];
        v4 push = c->push;
        c->push = push + b * (push - c->last);
        c->last = push;
    }
}

SIMD_INLINE unsigned visit(const struct field *f, struct local_axes axes, size_t r, double weight)
{
    struct row *row = &f->rows[r];
    const double *c = f->coupling + r * f->coupling_stride;
    unsigned stalls = 0;
    advance_row(f, row, weight);
    if (row->contacts)
        visit_contacts(f, row);
    v4 gd, go, ld, lo;
    turn_in(gather(f, row, c), (const double(*)[4])row->basis, &gd, &go);
    v4 bd = (gd + row->offset_d - row->kd * row->stress_d) * axes.on, bo = go + row->offset_o - row->ko * row->stress_o;
    row->phase = (uint32_t)local_solve(axes, row->kd, row->ko, bd, bo, row->mu, LOCAL_NEAR, &row->alpha, &ld, &lo, &stalls);
    v4 dd = ld - row->stress_d, dof = lo - row->stress_o;
    row->stress_d = ld;
    row->stress_o = lo;
    const v4 zero = {0, 0, 0, 0};
    if (m4_bits((m4)(dd != zero)) | m4_bits((m4)(dof != zero))) {
        scatter(f, row, c, turn_out(dd, dof, (const double(*)[4])row->basis));
        if (row->contacts) // again: what the row just did to its own node is most of what the wall must answer
            visit_contacts(f, row);
    }
    return stalls;
}

static unsigned sweep(const struct field *f, size_t from, size_t to, double weight)
{
    struct local_axes axes = local_axes(f->plane);
    unsigned stalls = 0;
    for (size_t r = from; r < to; r++)
        stalls += visit(f, axes, r, weight);
    return stalls;
}

static void extrapolate(const struct field *f, size_t from, size_t to, double weight, double (*last)[4])
{
    v4 b = v4_all(weight);
    for (size_t r = from; r < to; r++) {
        size_t n = f->rows[r].node;
        v4 w = v4_load(f->w[n]);
        v4_store(f->w[n], w + b * (w - v4_load(last[n])));
        v4_store(last[n], w);
    }
}

static void exert(const struct field *f, size_t from, size_t to)
{
    for (size_t r = from; r < to; r++) {
        const struct row *row = &f->rows[r];
        const double *c = f->coupling + r * f->coupling_stride;
        scatter(f, row, c, turn_out(row->stress_d, row->stress_o, (const double(*)[4])row->basis));
        for (uint32_t k = 0; k < row->contacts; k++) {
            double *w = f->w[row->node];
            v4_store(w, v4_load(w) + f->contacts[row->contact + k].push);
        }
    }
}

/* By how much one more visit would change the node's velocity, squared, m2/s2. */
static double contact_departure(const struct contact *c, const double w[4])
{
    v4 change = contact_push(c, v4_load(w) - c->push) - c->push;
    return v4_sum3(change * change) * c->scale * c->scale;
}

static struct row_sums look(const struct field *f, size_t from, size_t to, const struct row_look *how)
{
    struct local_axes axes = local_axes(f->plane);
    struct row_sums sums = {0, 0};
    for (size_t r = from; r < to; r++) {
        const struct row *row = &f->rows[r];
        v4 gd, go;
        turn_in(gather(f, row, f->coupling + r * f->coupling_stride), (const double(*)[4])row->basis, &gd, &go);
        gd *= axes.on;
        v4 t = v4_all(row->trace);
        double square =
            local_residual(axes, gd + row->offset_d, go + row->offset_o, t * row->stress_d, t * row->stress_o, row->mu) *
            how->unit * how->unit;
        double wall_unit = how->wall_unit * how->volume[row->node];
        for (uint32_t k = 0; k < row->contacts; k++)
            square += contact_departure(&f->contacts[row->contact + k], f->w[row->node]) * wall_unit * wall_unit;
        sums.sum += square;
        sums.largest = fmax(sums.largest, square);
        if (how->strain) {
            if (how->held) {
                gd += row->offset_d;
                go += row->offset_o;
            }
            v4 dev = gd - v4_all(v4_sum3(gd) * axes.inverse) * axes.on;
            how->strain[r][0] = sqrt(0.5 * v4_sum3(dev * dev) + v4_sum3(go * go)) / how->volume[row->node];
            how->strain[r][1] = v4_sum3(row->stress_d) * axes.inverse;
        }
    }
    return sums;
}

/* ---- points ---- */

/* u over a cell as powers of the cell coordinates: u = sum m[abc] x^a y^b z^c. */
struct trilinear {
    double m[8][3]; // 1, x, y, z, yz, zx, xy, xyz
};

static struct trilinear cell_velocity(const struct move *move, const int place[3])
{
    struct trilinear t;
    double v[8][3];
    for (int k = 0; k < 8; k++) {
        int x = move->grid->flat[0] ? 0 : k >> 2, y = move->grid->flat[1] ? 0 : k >> 1 & 1; // nothing depends on flat axes
        const double *u = move->velocity[grid_node(move->grid, place[0] + x, place[1] + y, place[2] + (k & 1))];
        memcpy(v[k], u, sizeof v[k]);
    }
    for (int a = 0; a < 3; a++) {
        double o = v[0][a], z = v[1][a] - o, y = v[2][a] - o, x = v[4][a] - o;
        double yz = v[3][a] - v[2][a] - z, zx = v[5][a] - v[4][a] - z, xy = v[6][a] - v[4][a] - y;
        double xyz = (v[7][a] - v[6][a]) - (v[5][a] - v[4][a]) - yz;
        const double m[8] = {o, x, y, z, yz, zx, xy, xyz};
        for (int k = 0; k < 8; k++)
            t.m[k][a] = m[k];
    }
    return t;
}

/* Four points at a time: velocity and its derivatives by cell coordinate. */
struct lanes {
    v4 u[3], rate[3][3]; // rate[axis][component]
};
SIMD_INLINE struct lanes sample(const struct trilinear *t, v4 x, v4 y, v4 z)
{
    struct lanes s;
    v4 yz = y * z;
    for (int a = 0; a < 3; a++) {
#define M(k) v4_all(t->m[k][a])
        s.rate[0][a] = M(1) + M(6) * y + M(5) * z + M(7) * yz;
        s.rate[1][a] = M(2) + M(4) * z + x * (M(6) + M(7) * z);
        s.rate[2][a] = M(3) + M(4) * y + x * (M(5) + M(7) * y);
        s.u[a] = M(0) + M(2) * y + M(3) * z + M(4) * yz + x * s.rate[0][a];
#undef M
    }
    return s;
}

/* Sums over a cell, a lane a quarter of its points. */
struct sums {
    v4 moment[MOMENTS], momentum[CORNER_ROOM];
};

/* Adds four points at cell coordinates (x, y, z), volume v (0 in lanes that do not count). APIC: corner t takes
 * v N_t (u + grad u (x_t - x)). */
SIMD_INLINE void deposit(struct sums *sums, const struct lanes *s, v4 x, v4 y, v4 z, v4 v)
{
    v4 one = v4_all(1), n[3][2] = {{one - x, x}, {one - y, y}, {one - z, z}};
    v4 px[3] = {n[0][0] * n[0][0], n[0][0] * n[0][1], n[0][1] * n[0][1]};
    v4 py[3] = {n[1][0] * n[1][0], n[1][0] * n[1][1], n[1][1] * n[1][1]};
    v4 pz[3] = {n[2][0] * n[2][0], n[2][0] * n[2][1], n[2][1] * n[2][1]};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            v4 ab = v * px[a] * py[b];
            for (int c = 0; c < 3; c++)
                sums->moment[a * 9 + b * 3 + c] += ab * pz[c];
        }
    v4 q[3];
    for (int a = 0; a < 3; a++)
        q[a] = s->u[a] - s->rate[0][a] * x - s->rate[1][a] * y - s->rate[2][a] * z;
    for (int k = 0; k < 8; k++) {
        v4 weight = v * n[0][k >> 2] * n[1][k >> 1 & 1] * n[2][k & 1];
        for (int a = 0; a < 3; a++) {
            v4 u = q[a];
            if (k >> 2)
                u += s->rate[0][a];
            if (k >> 1 & 1)
                u += s->rate[1][a];
            if (k & 1)
                u += s->rate[2][a];
            sums->momentum[3 * k + a] += weight * u;
        }
    }
}

static void push_mover(struct move *move, const double position[4], const struct lanes *s, int lane, uint32_t id)
{
    const struct grid *g = move->grid;
    struct mover *m = &move->movers[move->mover_count++];
    memcpy(m->position, position, sizeof m->position);
    for (int a = 0; a < 3; a++) {
        m->velocity[a] = s->u[a][lane];
        for (int b = 0; b < 3; b++)
            m->rate[b][a] = s->rate[b][a][lane];
    }
    m->id = id;
    m->cell = (uint32_t)grid_cell(g, grid_cell_along(g, 0, position[0]), grid_cell_along(g, 1, position[1]),
                                  grid_cell_along(g, 2, position[2]));
}

static void fold(const v4 *sums, size_t count, double *out)
{
    for (size_t k = 0; k < count; k++)
        out[k] = (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]);
}

static void move_cell(struct move *move, size_t cell)
{
    const struct grid *g = move->grid;
    const v4 zero = {0, 0, 0, 0};
    uint32_t from = move->cell_start[cell], to = move->cell_start[cell + 1], kept = from;
    struct sums sums;
    memset(&sums, 0, sizeof sums);
    int place[3];
    grid_cell_place(g, cell, place);
    v4 corner[3], inverse[3], length[3], step[3];
    for (int a = 0; a < 3; a++) {
        corner[a] = v4_all(place[a]);
        inverse[a] = v4_all(g->inverse[a]);
        length[a] = v4_all(g->flat[a] ? 0 : g->length[a]);
        step[a] = v4_all(move->step_s);
    }
    struct trilinear t = from < to ? cell_velocity(move, place) : (struct trilinear){{{0}}};
    v4 courant = zero;
    for (uint32_t p = from; p < to; p += 4) {
        uint32_t lanes = to - p < 4 ? to - p : 4;
        _Alignas(32) double rows[4][4] = {{0}};
        uint32_t ids[4] = {0};
        for (uint32_t k = 0; k < lanes; k++) {
            memcpy(rows[k], move->position[p + k], sizeof rows[k]);
            ids[k] = move->id[p + k];
        }
        for (uint32_t k = lanes; k < 4; k++) // idle lanes sit on the first point, without volume
            memcpy(rows[k], rows[0], 3 * sizeof(double));
        v4 x[3], v;
        v4_transpose(v4_load(rows[0]), v4_load(rows[1]), v4_load(rows[2]), v4_load(rows[3]), &x[0], &x[1], &x[2], &v);
        struct lanes s = sample(&t, x[0] * inverse[0] - corner[0], x[1] * inverse[1] - corner[1], x[2] * inverse[2] - corner[2]);
        v4 local[3];
        m4 inside = (m4)(v == v);
        for (int a = 0; a < 3; a++) {
            v4 way = step[a] * s.u[a];
            courant = v4_max(v4_abs(way * inverse[a]), courant); // a NaN in the first operand is dropped, hence:
            courant += way - way;
            x[a] = v4_min(v4_max(x[a] + way, zero), length[a]);
            local[a] = x[a] * inverse[a] - corner[a];
            inside &= (m4)(local[a] >= zero) & (m4)(local[a] <= v4_all(1));
        }
        unsigned stay = m4_bits(inside);
        deposit(&sums, &s, local[0], local[1], local[2], v4_select(inside, v, zero));
        v4_transpose(x[0], x[1], x[2], v, (v4 *)rows[0], (v4 *)rows[1], (v4 *)rows[2], (v4 *)rows[3]);
        for (uint32_t k = 0; k < lanes; k++)
            if (stay >> k & 1) {
                memcpy(move->position[kept], rows[k], sizeof rows[k]);
                move->id[kept++] = ids[k];
            } else {
                push_mover(move, rows[k], &s, (int)k, ids[k]);
            }
    }
    move->stayed[cell] = kept - from;
    fold(sums.moment, MOMENTS, move->moment[cell]);
    fold(sums.momentum, CORNER_ROOM, move->momentum[cell]);
    for (int k = 0; k < 4; k++)
        move->courant = courant[k] > move->courant || courant[k] != courant[k] ? courant[k] : move->courant;
}

static size_t move_cells(struct move *move, size_t from, size_t to)
{
    for (size_t cell = from; cell < to; cell++) {
        if (move->mover_count + (move->cell_start[cell + 1] - move->cell_start[cell]) > move->mover_room)
            return cell;
        move_cell(move, cell);
    }
    return to;
}

const struct kernels KERNELS = {.sweep = sweep, .extrapolate = extrapolate, .exert = exert, .look = look, .move = move_cells};

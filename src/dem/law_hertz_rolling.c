/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The contact law of seed 000 (Arran, Mangeney, De Rosny, Toussaint; Supporting
 * Information S3): viscoelastic Hertz-Mindlin with unloading rescale, torsion
 * and rolling, in plain C. The errata of the paper that matter here:
 *   eq. 8   the tangential velocity is v1 - v2 MINUS its normal part;
 *   eq. 13  same sign on both bodies, lever arm r - overlap / 2;
 *   eq. 26  the rolling spring after slip is M_r (capped) - beta_r k_r rate;
 *   eq. 14  16 G / 3 a^3 is kept as printed and is a material value.
 *
 * Frame rotation, eqs 6 and 20. The paper subtracts F.(v2 - v1) dt / |x| along
 * the new normal. With velocities at half steps x moves by exactly (v2 - v1) dt,
 * so F_old.x_new = F.(v2 - v1) dt (F_old was normal to x_old) and the term
 * equals the projection F - (F.n) n. We project: the same number, and rounding
 * errors out of the plane do not pile up.
 *
 * The lanes of law_hertz_rolling_kernel.c do the same operations in the same
 * order on four contacts at once; a test compares the two bit for bit. */
#include "dem/law.h"

#include <math.h>

#include "base/vec3.h"
#include "dem/law_hertz_rolling.h"

/* S4.4: moduli are means with the wall's, friction and damping are the wall's own. */
static void against_wall(const struct material_spec *m, struct law_coefs *c)
{
    const struct material_wall *w = &m->wall;
    double shear = material_shear_modulus(m), shear_w = w->young_Pa / (2 * (1 + w->poisson));
    c->normal = 2.0 / 3.0 * material_plane_modulus(m, BEAD_WALL);
    c->tangential = 4.0 * material_wall_mean(shear / (2 - m->poisson), shear_w / (2 - w->poisson)); // printed: G / (1 - nu)
    c->torsion = m->torsion_factor * material_wall_mean(shear, shear_w);
    c->beta = w->beta_s;
    c->mu_t = w->mu;
    c->mu_n = 3 * M_PI * w->mu / 16;
}

/* S4.4: as if the grain met its own image. Effective radius r2, not r2 / 2, and half the overlap: twice the modulus gives
 * eq. 5's force. The image slides and twists along, so those springs are left out altogether; with a friction of zero
 * alone, as printed, they would go on storing what they never exert. k_r is twice and the rate of rolling half what
 * the pair's are; only the cap of eq. 25, which the paper forgets, has to be halved. */
static void against_mirror(struct law_coefs *c)
{
    c->normal *= 2;
    c->tangential = c->torsion = c->mu_t = c->mu_n = 0;
    c->mu_r *= 0.5;
}

static void hertz_rolling_coefs(const void *material, int partner, double step_s, struct law_coefs *out)
{
    const struct material_spec *m = material;
    double shear = material_shear_modulus(m);
    *out = (struct law_coefs){
        .normal = 2.0 * m->young_Pa / (3.0 * (1.0 - m->poisson * m->poisson)),
        .tangential = 4.0 * shear / (2.0 - m->poisson),
        .torsion = m->torsion_factor * shear,
        .rolling = 2.0 * m->kappa,
        .beta = m->beta_s,
        .beta_r = m->beta_r_s,
        .mu_t = m->mu_t,
        .mu_n = material_torsion_friction(m),
        .mu_r = m->mu_r,
        .step = step_s,
    };
    if (partner == BEAD_WALL)
        against_wall(m, out);
    else if (partner == BEAD_MIRROR)
        against_mirror(out);
}

/* Kinematics of one contact. */
struct meeting {
    struct vec3 normal;   // from 1 to 2
    double overlap;       // m
    struct vec3 velocity; // v1 - v2
    struct vec3 spin1, spin2;
};

static struct vec3 scaled_to(struct vec3 v, double length, double limit)
{
    return vec3_scale(v, limit / length);
}

/* The law itself, equations in the order of the paper. */
static void hertz_rolling_contact(const struct law_coefs *c, const struct meeting *m, double contact[CONTACT_SLOTS],
                                  struct contact_out *out, struct contact_loss *loss)
{
    const struct vec3 n = m->normal;
    const double r = contact[CONTACT_R], r1 = contact[CONTACT_R1], r2 = contact[CONTACT_R2];
    const double dt = c->step, a_old = contact[CONTACT_A], fn_old = contact[CONTACT_FN];
    const struct vec3 ft_was = {contact[CONTACT_FT_X], contact[CONTACT_FT_Y], contact[CONTACT_FT_Z]};
    const struct vec3 mr_was = {contact[CONTACT_MR_X], contact[CONTACT_MR_Y], contact[CONTACT_MR_Z]};
    const double mn_was = contact[CONTACT_MN];

    /* Normal force, eqs 4 and 5, with a = sqrt(r overlap). */
    double approach = vec3_dot(m->velocity, n);
    double a = sqrt(r * m->overlap);
    double fn = c->normal * a * (m->overlap + c->beta * approach);
    double fn_size = fabs(fn);
    int loading = fn_size >= fn_old;
    double ratio = a / a_old; // of contact radii, used when unloading only: then a_old > 0

    /* Sliding, eqs 6 to 12. */
    double kt = c->tangential * a;
    struct vec3 lever = vec3_add(vec3_scale(m->spin1, r1), vec3_scale(m->spin2, r2));
    struct vec3 slide = vec3_add(vec3_sub(m->velocity, vec3_scale(n, approach)), vec3_cross(lever, n));
    struct vec3 ft_e = vec3_sub(ft_was, vec3_scale(n, vec3_dot(ft_was, n)));
    ft_e = vec3_add(vec3_scale(ft_e, loading ? 1.0 : ratio), vec3_scale(slide, kt * dt));
    struct vec3 viscous = vec3_scale(slide, c->beta * kt);
    struct vec3 ft = vec3_add(ft_e, viscous);
    double ft_size = sqrt(vec3_dot(ft, ft)), ft_cap = c->mu_t * fn_size;
    if (ft_size > ft_cap) {
        ft = scaled_to(ft, ft_size, ft_cap);
        ft_e = vec3_sub(ft, viscous);
    }

    /* Torsion, eqs 14 to 19. */
    struct vec3 spin = vec3_sub(m->spin1, m->spin2);
    double twist = vec3_dot(spin, n);
    double kn = c->torsion * (a * a * a);
    double mn_e = mn_was * (loading ? 1.0 : ratio * ratio * ratio) + twist * (kn * dt);
    double mn = mn_e + twist * (c->beta * kn), mn_cap = c->mu_n * fn_size * a;
    if (fabs(mn) > mn_cap) {
        mn = mn < 0 ? -mn_cap : mn_cap;
        mn_e = mn - twist * (c->beta * kn);
    }

    /* Rolling, eqs 20 to 26. */
    double kr = c->rolling * fn_size * r;
    struct vec3 roll = vec3_sub(spin, vec3_scale(n, twist));
    struct vec3 mr_e = vec3_sub(mr_was, vec3_scale(n, vec3_dot(mr_was, n)));
    mr_e = vec3_add(vec3_scale(mr_e, loading ? 1.0 : fn_size / fn_old), vec3_scale(roll, kr * dt));
    struct vec3 drag = vec3_scale(roll, c->beta_r * kr);
    struct vec3 mr = vec3_add(mr_e, drag);
    double mr_size = sqrt(vec3_dot(mr, mr)), mr_cap = c->mu_r * fn_size * r;
    if (mr_size > mr_cap) {
        mr = scaled_to(mr, mr_size, mr_cap);
        mr_e = vec3_sub(mr, drag);
    }

    /* Force of 1 on 2 and torques on both, eqs 13, 18, 25. */
    struct vec3 arm = vec3_cross(ft, n);
    struct vec3 couple = vec3_add(vec3_scale(n, mn), mr);
    double half = 0.5 * m->overlap;
    vec3_store(out->force, vec3_add(vec3_scale(n, fn), ft));
    vec3_store(out->torque1, vec3_sub(vec3_scale(arm, r1 - half), couple));
    vec3_store(out->torque2, vec3_add(vec3_scale(arm, r2 - half), couple));

    if (loss) {
        /* What the contact takes in during this step less what its springs keep.
         * Springs are followed by the trapezoid between two steps, so that only the
         * viscous parts, smooth in time, are taken at one end. */
        struct contact_loss was = hertz_rolling_springs(c, ft_was, mn_was, mr_was, a_old, fn_old, r);
        struct contact_loss now = hertz_rolling_springs(c, ft_e, mn_e, mr_e, a, fn_size, r);
        loss->normal = c->normal * a * c->beta * (approach * approach) * dt;
        loss->tangential = (0.5 * vec3_dot(vec3_add(ft_was, ft_e), slide) + vec3_dot(vec3_sub(ft, ft_e), slide)) * dt -
                           (now.tangential - was.tangential);
        loss->torsion = (0.5 * (mn_was + mn_e) * twist + (mn - mn_e) * twist) * dt - (now.torsion - was.torsion);
        loss->rolling =
            (0.5 * vec3_dot(vec3_add(mr_was, mr_e), roll) + vec3_dot(vec3_sub(mr, mr_e), roll)) * dt - (now.rolling - was.rolling);
    }
    vec3_store3(&contact[CONTACT_FT_X], ft_e);
    contact[CONTACT_MN] = mn_e;
    vec3_store3(&contact[CONTACT_MR_X], mr_e);
    contact[CONTACT_FN] = fn_size;
    contact[CONTACT_A] = a;
}

static void hertz_rolling_pairs_reference(const struct law_coefs *coefs, const struct pair_batch *b)
{
    for (size_t k = 0; k < b->active_count; k++) {
        uint32_t p = b->active[k], i = b->first[p], j = b->second[p] & IMAGE_ROW;
        const double *shift = b->shift[b->second[p] >> IMAGE_SHIFT];
        struct vec3 x = vec3_add(vec3_sub(vec3_load(b->position[j]), vec3_load(b->position[i])), vec3_load(shift));
        double distance = sqrt(vec3_dot(x, x)), inverse = 1.0 / distance;
        double overlap = (b->contact[p][CONTACT_R1] + b->contact[p][CONTACT_R2]) - distance;
        struct meeting m = {
            .normal = vec3_scale(x, inverse),
            .overlap = overlap > 0 ? overlap : 0,
            .velocity = vec3_sub(vec3_load(b->velocity[i]), vec3_load(b->velocity[j])),
            .spin1 = vec3_load(b->spin[i]),
            .spin2 = vec3_load(b->spin[j]),
        };
        hertz_rolling_contact(coefs, &m, b->contact[p], &b->out[k], b->loss ? &b->loss[k] : NULL);
    }
}

/* A wall is a second body at rest: S4.4's definitions with the roles exchanged,
 * which eqs 1-26 allow since they change sign together. It has no rotation of
 * its normal, so the projection of the springs changes nothing. */
static void hertz_rolling_wall(const struct law_coefs *coefs, const double velocity[4], const double spin[4], const double arm[4],
                               int ledger, struct wall_pair *pair)
{
    (void)arm;
    struct meeting m = {
        .normal = vec3_load(pair->normal),
        .overlap = pair->overlap,
        .velocity = vec3_load(velocity),
        .spin1 = vec3_load(spin),
    };
    hertz_rolling_contact(coefs, &m, pair->contact, &pair->out, ledger ? &pair->loss : NULL);
}

static struct contact_loss hertz_rolling_elastic(const struct law_coefs *c, const double contact[CONTACT_SLOTS], double overlap)
{
    struct vec3 ft = {contact[CONTACT_FT_X], contact[CONTACT_FT_Y], contact[CONTACT_FT_Z]};
    struct vec3 mr = {contact[CONTACT_MR_X], contact[CONTACT_MR_Y], contact[CONTACT_MR_Z]};
    struct contact_loss e =
        hertz_rolling_springs(c, ft, contact[CONTACT_MN], mr, contact[CONTACT_A], contact[CONTACT_FN], contact[CONTACT_R]);
    e.normal = 0.4 * c->normal * contact[CONTACT_A] * overlap * overlap; // integral of normal * sqrt(r) x^(3/2)
    return e;
}

const struct law law_hertz_rolling = {
    .name = "hertz-mindlin-rolling",
    .doc = "viscoelastic Hertz-Mindlin with unloading rescale, torsion and rolling springs",
    .source = "seed 000 S3 eqs 1-26, corrected",
    .coefs = hertz_rolling_coefs,
    .pairs = {hertz_rolling_pairs_v2, hertz_rolling_pairs_v3, hertz_rolling_pairs_v4},
    .pairs_reference = hertz_rolling_pairs_reference,
    .wall = hertz_rolling_wall,
    .elastic = hertz_rolling_elastic,
};

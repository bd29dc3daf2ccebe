/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The contact law of seed 003 (Cagnoli and Piersanti 2015, eqs 2-13), as EDEM
 * words it: Hertz, Mindlin's tangential spring, Tsuji's damping, and a rolling
 * torque of constant size against each body's rotation. In plain C.
 *
 * Signs. eps of eq. 10 is negative, so that eq. 8 is right for a force and a
 * velocity counted positive for repulsion and approach, while eq. 9 would then
 * push along the sliding. Here both damping forces have the size
 * 2 sqrt(5/6) |eps| sqrt(S m) and oppose the relative velocity.
 *
 * Why this damping. With F = k x^(3/2), k = 4/3 E sqrt(R), and a force
 * 2 sqrt(5/6) |eps| sqrt(S m) x', S = 2 E sqrt(R x) = 3/2 k sqrt(x), the
 * equation of the overlap is, scaled, x'' + b x^(1/4) x' + x^(3/2) = 0 with
 * b = sqrt(5) |eps|: it has no velocity in it, so restitution is the same at
 * any speed, and it is exactly e (the substitution y = x^(5/4) makes it the
 * linear oscillator of damping ratio |eps|).
 * The force pulls at the end of a contact; clamped at zero instead, restitution
 * is larger (0.5423 for 0.49). Both can be had; as printed nothing is clamped.
 *
 * Coulomb's cap takes the spring and its damping together, mu_s F_n, and none is
 * left where F_n pulls. The spring alone is capped too, so that it never holds
 * more than friction can: were it left with what the cap leaves over damping,
 * which is strong here, it would push a grain on when sliding slows down. The
 * spring is an overlap in m (its force is S_t times it).
 *
 * Rolling, eq. 13: the torque mu_r F_n d acts against each body's own spin, d
 * from its centre of mass to the contact point, the middle of the overlap. A
 * body whose spin such torques would reverse within a step is slowed instead
 * (TSUJI_STOP), or it would rock for ever.
 *
 * The lanes of law_hertz_tsuji_kernel.c do the same operations in the same
 * order on four contacts at once; a test compares the two bit for bit. */
#include "dem/law_hertz_tsuji.h"

#include <math.h>

#include "base/vec3.h"

static double plane_strain(const struct fragment_matter *m) // (1 - nu^2) / E of eq. 3, 1/Pa
{
    return (1 - m->poisson * m->poisson) / fragment_young_modulus(m);
}

static void hertz_tsuji_coefs(const void *material, int partner, double step_s, struct law_coefs *out)
{
    const struct fragment_spec *m = material;
    const struct fragment_matter *other = fragment_matter_of(m, partner);
    const struct fragment_pair *pair = fragment_pair_of(m, partner);
    double young = 1 / (plane_strain(&m->clast) + plane_strain(other));
    double shear = 1 / ((2 - m->clast.poisson) / m->clast.shear_Pa + (2 - other->poisson) / other->shear_Pa);
    double logarithm = log(pair->restitution), eps = logarithm / sqrt(logarithm * logarithm + M_PI * M_PI); // eq. 10
    *out = (struct law_coefs){
        .normal = 4.0 / 3.0 * young / m->softening, // eq. 2, Pa
        .tangential = 8.0 * shear / m->softening,   // eq. 6, Pa
        .beta = 2.0 * sqrt(5.0 / 6.0) * fabs(eps),  // eqs 8, 9
        .mu_t = pair->friction,
        .mu_r = pair->rolling,
        .step = step_s,
        .least = m->clamp ? 0 : -INFINITY,
    };
}

/* Kinematics of one contact. */
struct meeting {
    struct vec3 normal;       // from 1 to 2
    double overlap;           // m
    struct vec3 velocity;     // v1 - v2
    struct vec3 spin1, spin2; // rad/s
    struct vec3 arm1, arm2;   // from each body's centre of mass to its sphere's centre, m
    double light1, light2;    // step over mass, s/kg
    double turn1, turn2;      // step over the smallest moment of inertia, s/(kg m2)
};

static double hertz_size(struct vec3 v)
{
    return sqrt(vec3_dot(v, v));
}

/* Eq. 13 as a factor of the spin: torque = -factor * spin. */
static double rolling_factor(double torque, double spin, double turn)
{
    double printed = torque / (spin + TSUJI_NOTHING), stop = 1.0 / (TSUJI_STOP * turn + TSUJI_NOTHING);
    return printed < stop ? printed : stop;
}

static void hertz_tsuji_contact(const struct law_coefs *c, const struct meeting *m, double contact[CONTACT_SLOTS],
                                struct contact_out *out, struct contact_loss *loss)
{
    const struct vec3 n = m->normal;
    const double r = contact[CONTACT_R], half = 0.5 * m->overlap;
    const double reach1 = contact[CONTACT_R1] - half, reach2 = contact[CONTACT_R2] - half; // to the contact point
    const double dt = c->step, a_old = contact[CONTACT_A];
    const struct vec3 slid_was = {contact[CONTACT_FT_X], contact[CONTACT_FT_Y], contact[CONTACT_FT_Z]};

    /* Normal force, eqs 2, 8, 12, with a = sqrt(R overlap) and the equivalent mass of eq. 11. */
    double mass = dt / (m->light1 + m->light2);
    double approach = vec3_dot(m->velocity, n);
    double a = sqrt(r * m->overlap);
    double damping = c->beta * sqrt(1.5 * c->normal * a * mass);
    double fn = c->normal * a * m->overlap + damping * approach;
    fn = fn > c->least ? fn : c->least;
    double press = fn > 0 ? fn : 0;

    /* Sliding, eqs 5, 6, 9; the history turns with the contact by projection. */
    double kt = c->tangential * a, drag = c->beta * sqrt(kt * mass);
    struct vec3 lever = vec3_add(vec3_scale(m->spin1, reach1), vec3_scale(m->spin2, reach2));
    struct vec3 slide = vec3_add(vec3_sub(m->velocity, vec3_scale(n, approach)), vec3_cross(lever, n));
    struct vec3 slid = vec3_sub(slid_was, vec3_scale(n, vec3_dot(slid_was, n)));
    slid = vec3_add(slid, vec3_scale(slide, dt));
    double spring = kt * hertz_size(slid), ft_cap = c->mu_t * press;
    if (spring > ft_cap)
        slid = vec3_scale(slid, ft_cap / spring);
    struct vec3 ft = vec3_add(vec3_scale(slid, kt), vec3_scale(slide, drag));
    double ft_size = hertz_size(ft);
    if (ft_size > ft_cap)
        ft = vec3_scale(ft, ft_cap / ft_size);

    /* Rolling, eq. 13. */
    struct vec3 arm1 = vec3_add(m->arm1, vec3_scale(n, reach1)), arm2 = vec3_sub(m->arm2, vec3_scale(n, reach2));
    double roll1 = rolling_factor(c->mu_r * press * hertz_size(arm1), hertz_size(m->spin1), m->turn1);
    double roll2 = rolling_factor(c->mu_r * press * hertz_size(arm2), hertz_size(m->spin2), m->turn2);

    struct vec3 twist = vec3_cross(ft, n), force = vec3_add(vec3_scale(n, fn), ft);
    vec3_store(out->force, force);
    vec3_store(out->torque1, vec3_sub(vec3_scale(twist, reach1), vec3_scale(m->spin1, roll1)));
    vec3_store(out->torque2, vec3_sub(vec3_scale(twist, reach2), vec3_scale(m->spin2, roll2)));

    if (loss) {
        /* What resists motion works at the mean of the velocities before and after its kick: half of what the contact changes
         * them by within the step, as if it were the bodies' only one and they were as light to turn as about their lightest
         * axis. At the velocities before it alone, impacts at usual steps would seem to lose 3 % more than they do. */
        struct vec3 spun1 = vec3_scale(vec3_add(vec3_cross(arm1, force), vec3_scale(m->spin1, roll1)), -0.5 * m->turn1);
        struct vec3 spun2 = vec3_scale(vec3_sub(vec3_cross(arm2, force), vec3_scale(m->spin2, roll2)), 0.5 * m->turn2);
        struct vec3 kick = vec3_sub(vec3_cross(spun1, arm1), vec3_cross(spun2, arm2));
        kick = vec3_sub(kick, vec3_scale(force, 0.5 * (m->light1 + m->light2)));
        double along = vec3_dot(kick, n);
        struct vec3 mean = vec3_add(slide, vec3_sub(kick, vec3_scale(n, along)));
        /* Sliding: the work put in less what the spring gained; the spring's force is
         * followed by the trapezoid. It may be negative while the normal load grows,
         * for the spring then stiffens under an overlap it holds. */
        struct vec3 was = vec3_scale(slid_was, c->tangential * a_old), now = vec3_scale(slid, kt);
        double stored = 0.5 * (c->tangential * a_old) * vec3_dot(slid_was, slid_was), stores = 0.5 * kt * vec3_dot(slid, slid);
        loss->normal = (fn - c->normal * a * m->overlap) * (approach + along) * dt;
        loss->tangential = (0.5 * vec3_dot(vec3_add(was, now), slide) + vec3_dot(vec3_sub(ft, now), mean)) * dt - (stores - stored);
        loss->torsion = 0;
        loss->rolling =
            (roll1 * vec3_dot(m->spin1, vec3_add(m->spin1, spun1)) + roll2 * vec3_dot(m->spin2, vec3_add(m->spin2, spun2))) * dt;
    }
    vec3_store3(&contact[CONTACT_FT_X], slid);
    contact[CONTACT_FN] = fabs(fn);
    contact[CONTACT_A] = a;
}

static void hertz_tsuji_pairs_reference(const struct law_coefs *coefs, const struct pair_batch *b)
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
            .arm1 = vec3_load(b->arm[i]),
            .arm2 = vec3_load(b->arm[j]),
            .light1 = b->velocity[i][3],
            .light2 = b->velocity[j][3],
            .turn1 = b->spin[i][3],
            .turn2 = b->spin[j][3],
        };
        hertz_tsuji_contact(coefs, &m, b->contact[p], &b->out[k], b->loss ? &b->loss[k] : NULL);
    }
}

/* A wall is a second body at rest, of any mass: 3.2 takes the sphere's radius for the equivalent one. */
static void hertz_tsuji_wall(const struct law_coefs *coefs, const double velocity[4], const double spin[4], const double arm[4],
                             int ledger, struct wall_pair *pair)
{
    struct meeting m = {
        .normal = vec3_load(pair->normal),
        .overlap = pair->overlap,
        .velocity = vec3_load(velocity),
        .spin1 = vec3_load(spin),
        .arm1 = vec3_load(arm),
        .light1 = velocity[3],
        .turn1 = spin[3],
    };
    hertz_tsuji_contact(coefs, &m, pair->contact, &pair->out, ledger ? &pair->loss : NULL);
}

static struct contact_loss hertz_tsuji_elastic(const struct law_coefs *c, const double contact[CONTACT_SLOTS], double overlap)
{
    struct vec3 slid = {contact[CONTACT_FT_X], contact[CONTACT_FT_Y], contact[CONTACT_FT_Z]};
    return (struct contact_loss){
        .normal = 0.4 * c->normal * contact[CONTACT_A] * overlap * overlap, // integral of normal sqrt(R) x^(3/2)
        .tangential = 0.5 * (c->tangential * contact[CONTACT_A]) * vec3_dot(slid, slid),
    };
}

const struct law law_hertz_tsuji = {
    .name = "hertz-mindlin-tsuji",
    .doc = "Hertz-Mindlin with restitution the same at any speed and rolling torque of constant direction",
    .source = "seed 003 3.2 eqs 2-13, signs corrected",
    .coefs = hertz_tsuji_coefs,
    .pairs = {hertz_tsuji_pairs_v2, hertz_tsuji_pairs_v3, hertz_tsuji_pairs_v4},
    .pairs_reference = hertz_tsuji_pairs_reference,
    .wall = hertz_tsuji_wall,
    .elastic = hertz_tsuji_elastic,
};

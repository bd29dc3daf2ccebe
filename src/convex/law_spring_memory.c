/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Spring, dashpot and memory.
 *
 * Where paper and published code differ: the clamp of eq. 5 is the paper's alone
 * and off unless asked for (restitution is eq. 11's only without it: targets
 * S1-01). The direction of friction is eq. 7's at any speed; the code goes by
 * -v_t above 1 mm/s, which makes the force jump there. The limit of A5 has the
 * reduced radius, as the code; A7 as printed has the grain's own.
 * Rolling is relative spin across the normal: spin about it is no rolling. */
#include "convex/law_spring_memory.h"

#include <math.h>

static double length_of(struct vec3 v)
{
    return sqrt(vec3_dot(v, v));
}

static struct vec3 across(struct vec3 v, struct vec3 normal)
{
    return vec3_sub(v, vec3_scale(normal, vec3_dot(v, normal)));
}

/* What the shortest turn from normal n to normal m makes of v, which lies across n: v - (v.m) (n + m) / (1 + n.m), the turn
 * by the quaternion (1 + n.m, n x m) of eq. 8 multiplied out. What rounding leaves along m is taken off, so that friction
 * stays in its plane for good. */
static struct vec3 turned(struct vec3 v, struct vec3 n, struct vec3 m, double over)
{
    return across(vec3_sub(v, vec3_scale(vec3_add(n, m), vec3_dot(v, m) * over)), m);
}

/* Between opposite normals there is no shortest turn: a contact that flips over in a step is another contact, and
 * remembers nothing. */
void spring_memory_turn(struct spring_memory *memory, struct vec3 normal)
{
    struct vec3 n = memory->normal;
    double half = 1 + vec3_dot(n, normal); // 1 where there was no normal
    if (half < 1e-6 || vec3_dot(n, n) == 0) {
        *memory = (struct spring_memory){.normal = normal};
        return;
    }
    memory->slip = turned(memory->slip, n, normal, 1 / half);
    memory->torque = turned(memory->torque, n, normal, 1 / half);
    memory->normal = normal;
}

/* Eqs 6-8. At the limit the spring is set to what, with the dashpot, gives just the limit: when the contact sticks again
 * the force goes on from there. */
static struct vec3 friction(const struct spring_pair *p, struct vec3 velocity, double normal, double step_s, struct vec3 *slip,
                            bool *slides)
{
    *slip = vec3_add(*slip, vec3_scale(velocity, step_s));
    struct vec3 viscous = vec3_scale(velocity, p->damping_t);
    struct vec3 force = vec3_scale(vec3_add(vec3_scale(*slip, p->stiffness_t), viscous), -1);
    double limit = p->friction * fabs(normal), size = length_of(force);
    *slides = size > limit;
    if (!*slides)
        return force;
    force = vec3_scale(force, limit / size);
    if (p->stiffness_t > 0)
        *slip = vec3_scale(vec3_add(force, viscous), -1 / p->stiffness_t);
    return force;
}

/* Eqs A1-A5: only the spring's part is limited, and at the limit nothing is damped. */
static struct vec3 rolling(const struct spring_pair *p, struct vec3 spin, double normal, double step_s, struct vec3 *spring,
                           bool *rolls)
{
    *rolls = false;
    if (!(p->rolling_friction > 0))
        return (struct vec3){0, 0, 0};
    *spring = vec3_sub(*spring, vec3_scale(spin, p->stiffness_r * step_s));
    double limit = p->rolling_friction * p->radius * fabs(normal), size = length_of(*spring);
    *rolls = size > limit;
    if (!*rolls)
        return vec3_sub(*spring, vec3_scale(spin, p->damping_r));
    *spring = vec3_scale(*spring, limit / size);
    return *spring;
}

struct spring_result spring_memory_step(const struct spring_pair *pair, const struct spring_motion *motion, double step_s,
                                        struct spring_memory *memory)
{
    struct spring_result out = {.slides = false};
    double approach = vec3_dot(motion->velocity, motion->normal); // d delta_n / dt
    out.normal = pair->stiffness * motion->overlap + pair->damping * approach;
    if (pair->clamp && out.normal < 0)
        out.normal = 0;
    spring_memory_turn(memory, motion->normal);
    struct vec3 push = vec3_scale(motion->normal, -out.normal);
    out.force =
        vec3_add(push, friction(pair, across(motion->velocity, motion->normal), out.normal, step_s, &memory->slip, &out.slides));
    out.torque = rolling(pair, across(motion->spin, motion->normal), out.normal, step_s, &memory->torque, &out.rolls);
    return out;
}

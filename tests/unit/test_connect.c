/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The base-connected set on graphs made by hand, and the extent of chains. */
#include "unit.h"

#include <math.h>

#include "measure/connect.h"
#include "measure/connectivity.h"

enum { MOVING = 6, FIXED = 2, ROWS = MOVING + FIXED };

/* Rows 0 .. 5 move, 6 and 7 are of the base; returns the set as bits. */
static unsigned joined(const struct view_contact *contact, size_t contacts, const struct view_body *body, size_t bodies,
                       enum connect_rule rule)
{
    struct view view = {.moving = MOVING, .fixed = FIXED, .contact = contact, .contacts = contacts, .body = body, .bodies = bodies};
    uint32_t root[ROWS + 1];
    unsigned set = 0;
    assert_int_equal(connect_rows(&view), ROWS + 1);
    connect_base(&view, rule, root);
    for (unsigned k = 0; k < ROWS; k++)
        set |= (root[k] == root[ROWS] ? 1u : 0u) << k;
    return set;
}
#define BASE 0xc0u

static void grains_of_the_base_belong(void **state)
{
    (void)state;
    assert_int_equal(joined(NULL, 0, NULL, 0, CONNECT_OVERLAP), BASE);
}

/* 0-1-2-6 is a chain to the base, in whatever order contacts come; 3-4 is an island. */
static void chains_reach_and_islands_do_not(void **state)
{
    (void)state;
    const struct view_contact all[] = {{.a = 0, .b = 1, .force_normal = 1},
                                       {.a = 3, .b = 4, .force_normal = 1},
                                       {.a = 1, .b = 2, .force_normal = 1},
                                       {.a = 2, .b = 6, .on_base = 1, .force_normal = 1}};
    assert_int_equal(joined(all, 4, NULL, 0, CONNECT_OVERLAP), BASE | 0x7);
    const struct view_contact back[] = {all[3], all[2], all[1], all[0]};
    assert_int_equal(joined(back, 4, NULL, 0, CONNECT_OVERLAP), BASE | 0x7);
    assert_int_equal(joined(all, 3, NULL, 0, CONNECT_OVERLAP), BASE); // without its foot the chain is an island
}

/* A wall of the base joins, a side wall does not: two grains at one side wall are not joined through it. */
static void floors_join_and_side_walls_do_not(void **state)
{
    (void)state;
    const struct view_contact all[] = {{.a = 0, .b = VIEW_WALL, .on_base = 1},
                                       {.a = 0, .b = VIEW_WALL + 1},
                                       {.a = 1, .b = VIEW_WALL + 1},
                                       {.a = 2, .b = VIEW_WALL + 1}};
    assert_int_equal(joined(all, 4, NULL, 0, CONNECT_OVERLAP), BASE | 0x1);
}

/* At the end of a damped contact eq. 5 pulls: such a contact counts by overlap alone. */
static void the_rule_decides_about_contacts_that_pull(void **state)
{
    (void)state;
    const struct view_contact all[] = {{.a = 0, .b = 6, .on_base = 1, .force_normal = 1},
                                       {.a = 0, .b = 1, .force_normal = -1e-6},
                                       {.a = 1, .b = 2, .force_normal = 1}};
    assert_int_equal(joined(all, 3, NULL, 0, CONNECT_OVERLAP), BASE | 0x7);
    assert_int_equal(joined(all, 3, NULL, 0, CONNECT_PUSH), BASE | 0x1);
}

static void members_of_a_body_are_joined(void **state)
{
    (void)state;
    const struct view_body bodies[] = {{.first = 0, .members = 3}, {.first = 3, .members = 3}};
    const struct view_contact foot = {.a = 2, .b = 7, .on_base = 1, .force_normal = 1};
    assert_int_equal(joined(&foot, 1, bodies, 2, CONNECT_PUSH), BASE | 0x7);
}

/* P_C = exp(-z / (lambda d)): found exactly, from heights over the base only, below `top`, while above 2 %. */
static void lambda_is_the_decay(void **state)
{
    (void)state;
    enum { N = 64 };
    double z[N], p[N], weight[N], d = 2e-3, lambda = 2.5;
    for (int k = 0; k < N; k++) {
        z[k] = (-0.875 + 0.25 * k) * d;
        p[k] = z[k] <= 0 ? 1 : exp(-z[k] / (lambda * d));
        weight[k] = 1 + k % 3;
        if (p[k] < 0.02)
            p[k] = 0.019; // noise that must not count
        if (z[k] > 8 * d)
            p[k] = 0.5; // above the flow
    }
    double found = connectivity_lambda(z, p, weight, N, 8 * d, d);
    assert_true(fabs(found / lambda - 1) < 1e-12);
    for (int k = 0; k < N; k++)
        p[k] = 1;
    assert_true(connectivity_lambda(z, p, weight, N, 8 * d, d) == 0); // does not fall
    assert_true(connectivity_lambda(z, p, weight, 4, 8 * d, d) == 0); // one height over the base is too few
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grains_of_the_base_belong),         cmocka_unit_test(chains_reach_and_islands_do_not),
        cmocka_unit_test(floors_join_and_side_walls_do_not), cmocka_unit_test(the_rule_decides_about_contacts_that_pull),
        cmocka_unit_test(members_of_a_body_are_joined),      cmocka_unit_test(lambda_is_the_decay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

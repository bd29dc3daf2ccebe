/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See connect.h. */
#include "measure/connect.h"

static uint32_t find(uint32_t *root, uint32_t k)
{
    while (root[k] != k)
        k = root[k] = root[root[k]];
    return k;
}

static void join(uint32_t *root, uint32_t a, uint32_t b)
{
    a = find(root, a);
    b = find(root, b);
    root[a > b ? a : b] = a > b ? b : a;
}

void connect_base(const struct view *view, enum connect_rule rule, uint32_t *root)
{
    uint32_t rows = (uint32_t)(view->moving + view->fixed), base = rows;
    for (uint32_t k = 0; k <= rows; k++)
        root[k] = k;
    for (uint32_t k = (uint32_t)view->moving; k < rows; k++)
        join(root, k, base);
    for (size_t k = 0; k < view->bodies; k++)
        for (uint32_t m = 1; m < view->body[k].members; m++)
            join(root, view->body[k].first, view->body[k].first + m);
    for (size_t k = 0; k < view->contacts; k++) {
        const struct view_contact *c = &view->contact[k];
        if (rule == CONNECT_PUSH && !(c->force_normal > 0))
            continue;
        if (c->b < VIEW_WALL)
            join(root, c->a, c->b);
        else if (c->on_base)
            join(root, c->a, base);
    }
    for (uint32_t k = 0; k <= rows; k++)
        root[k] = find(root, k);
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See packing.h. Walls are told apart by where they face: contacts' normals point
 * from bodies into them. */
#include "measure/packing.h"

#include <math.h>
#include <stdbool.h>

#include "base/vec3.h"

static bool in_region(int region, const double at[3], double length, double height)
{
    return region == 0 || (at[0] > 0.5 * length && (region == 1 || at[2] > 0.5 * height));
}

static double magnitude(const double v[3])
{
    return sqrt(vec3_square(v));
}

static void count_wall(const struct view_contact *c, struct packing_region *r)
{
    if (c->normal[2] < -0.5)
        r->ground++;
    else if (fabs(c->normal[1]) > 0.5)
        r->sides++;
    else if (c->normal[0] > 0.5)
        r->gate++;
}

static void count(const struct view *view, double length, double height, struct packing *out)
{
    for (int k = 0; k < PACKING_REGIONS; k++) {
        struct packing_region *r = &out->region[k];
        for (size_t b = 0; b < view->bodies; b++)
            r->bodies += in_region(k, view->body[b].position, length, height);
        for (size_t i = 0; i < view->contacts; i++) {
            const struct view_contact *c = &view->contact[i];
            if (!in_region(k, c->point, length, height))
                continue;
            if (c->b >= VIEW_WALL)
                count_wall(c, r);
            else
                r->contacts++;
        }
    }
}

/* The angle is that of a line: theta and theta + 180 degrees are one. */
static void add_branch(const struct view *view, const struct view_contact *c, double branches, struct packing *out)
{
    const double *a = view->body[c->a].position, *b = view->body[c->b].position;
    double x = b[0] - a[0], z = b[2] - a[2], square = x * x + z * z;
    if (!(square > 0))
        return;
    double theta = atan2(z, x) / M_PI;
    theta = theta < 0 ? theta + 1 : theta;
    out->fabric[(int)fmin(FABRIC_BINS - 1, floor(theta * FABRIC_BINS))] += 1 / branches;
    out->anisotropy += (x * x - z * z) / square / branches;
}

void packing_measure(const struct view *view, double length, double height, struct packing *out)
{
    *out = (struct packing){.force_mean = 0};
    count(view, length, height, out);
    double contacts = out->region[0].contacts, carried = 0, weight = 0, g = magnitude(view->gravity);
    for (size_t i = 0; i < view->contacts; i++) {
        const struct view_contact *c = &view->contact[i];
        if (c->b < VIEW_WALL)
            out->force_mean += magnitude(c->force) / contacts;
        else if (!c->on_base)
            carried -= c->force[2]; // a body that slides down drags its wall down
    }
    for (size_t i = 0; i < view->contacts; i++) {
        const struct view_contact *c = &view->contact[i];
        if (c->b >= VIEW_WALL)
            continue;
        double ratio = out->force_mean > 0 ? magnitude(c->force) / out->force_mean : 0;
        out->force_most = fmax(out->force_most, ratio);
        out->force_pdf[(int)fmin(FORCE_BINS - 1, floor(ratio / FORCE_BIN))] += 1 / (contacts * FORCE_BIN);
        add_branch(view, c, contacts, out);
    }
    for (size_t b = 0; b < view->bodies; b++)
        weight += view->body[b].mass * g;
    out->janssen = weight > 0 ? carried / weight : 0;
}

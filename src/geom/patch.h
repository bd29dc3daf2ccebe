/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where two cores under their crusts lie on each other with a face: the common part
 * of a face of one and a face of the other, seen along the first's normal, whose
 * corners press as deep as the crusts overlap there. A single nearest point wanders
 * between those corners as rounding has it; the corners themselves do not.
 *
 * With o_k the overlap of a corner and w_k half the length of the two sides of the
 * common part that meet there, it presses like k o_k with the share
 * w_k sum(w o^2) / (sum w o)^2: corners that press alike together as one of them
 * alone would, a corner that presses alone in full, and none comes, goes or splits in
 * two with a jump. */
#ifndef SCREE_GEOM_PATCH_H
#define SCREE_GEOM_PATCH_H

#include <stdbool.h>

#include "geom/composite.h"

enum { PATCH_POINTS_MAX = 8 }; // two boxes have no more

/* A part, and where it is from wherever the caller measures from. */
struct patch_side {
    const struct composite_part *part;
    struct turn turn;
    struct vec3 centre; // m
};

/* Which faces: all that is to be remembered of a patch. The plane is that of the face that is better aligned. */
enum { PATCH_NONE, PATCH_ON_A, PATCH_ON_B };
struct patch_faces {
    uint8_t a, b, plane;
};

struct patch {
    struct vec3 normal; // from a to b, unit length
    size_t points;      // that press
    struct {
        struct vec3 at; // midway between the crusts' surfaces, m
        double overlap; // m
        double share;   // of what its overlap alone would exert
    } point[PATCH_POINTS_MAX];
};

/* The faces that look at each other along a normal from a to b, of bodies that both have some. */
struct patch_faces patch_find(const struct patch_side *a, const struct patch_side *b, struct vec3 normal);

/* Corners of the common part that press; none where the cores themselves overlap there, which is for others to say. */
void patch_measure(const struct patch_side *a, const struct patch_side *b, struct patch_faces faces, struct patch *out);

#endif

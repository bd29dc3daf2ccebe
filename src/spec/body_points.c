/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lists of points in a body's text: "x y z, x y z; x y z", in metres. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spec/spec.h"

static const char path[] = "params.body.points_m";

static enum scree_status at(const char *what, const struct body_points *p, struct scree_error *err)
{
    return scree_fail(err, SCREE_INVALID, path, "%s: point %zu, in part %zu, %s", path, p->count, p->parts, what);
}

/* One number; only what JSON would take for one. */
static bool read_number(const char **text, double *out)
{
    char *end;
    *text += strspn(*text, " ");
    if (!**text || !strchr("-0123456789", **text))
        return false;
    *out = strtod(*text, &end);
    if (end == *text || strspn(*text, "+-.eE0123456789") < (size_t)(end - *text) || !(fabs(*out) <= 10))
        return false;
    *text = end + strspn(end, " ");
    return true;
}

enum scree_status body_points(const struct body_spec *body, struct body_points *out, struct scree_error *err)
{
    const char *text = body->points_m;
    int numbers = body->shape == BODY_SPHERES ? 4 : 3;
    *out = (struct body_points){.parts = 0};
    if (!text[strspn(text, " ")])
        return scree_fail(err, SCREE_INVALID, path, "%s: a body of %s needs points", path, numbers == 4 ? "spheres" : "hulls");
    for (bool more = true; more; text++) {
        if (out->count == BODY_POINTS_MAX)
            return scree_fail(err, SCREE_INVALID, path, "%s: more than %d points", path, BODY_POINTS_MAX);
        double *point = out->point[out->count];
        for (int k = 0; k < numbers; k++)
            if (!read_number(&text, &point[k]))
                return at(numbers == 4 ? "is not \"x y z r\", four numbers of at most 10 m"
                                       : "is not \"x y z\", three numbers of at most 10 m",
                          out, err);
        if (numbers == 4 && !(point[3] > 0))
            return at("has no radius above 0", out, err);
        if (*text && *text != ',' && *text != ';')
            return at("is followed by neither \",\" nor \";\"", out, err);
        out->count++;
        more = *text == ',' || *text == ';';
        if (*text == ',' && numbers == 3)
            continue; // of the same part; each sphere is a part of its own
        if (++out->parts > BODY_PARTS_MAX)
            return scree_fail(err, SCREE_INVALID, path, "%s: more than %d parts", path, BODY_PARTS_MAX);
        out->first[out->parts] = out->count;
    }
    return SCREE_OK;
}

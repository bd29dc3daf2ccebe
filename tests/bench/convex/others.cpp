// SPDX-License-Identifier: GPL-3.0-or-later
// FCL and libccd on the same pairs of boxes: FCL's own test of two boxes (separating axes, with contacts), its
// distance, and libccd's GJK and EPA.
#include "pairs.h"

#include <ccd/ccd.h>
#include <ccd/quat.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <cmath>

namespace
{
fcl::Transform3d pose_of(const placed_box &box)
{
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            pose.linear()(k, i) = box.axis[i][k];
        pose.translation()[i] = box.centre[i];
    }
    return pose;
}

fcl::Boxd shape_of(const placed_box &box)
{
    return fcl::Boxd(2 * box.half[0], 2 * box.half[1], 2 * box.half[2]);
}

template <class Test> double time_all(const box_pair *pair, unsigned long count, int rounds, unsigned long *overlapping, Test test)
{
    *overlapping = 0;
    double start = pairs_seconds();
    for (int round = 0; round < rounds; round++)
        for (unsigned long k = 0; k < count; k++)
            *overlapping += test(pair[k]) ? 1 : 0;
    double spent = pairs_seconds() - start;
    *overlapping /= static_cast<unsigned long>(rounds);
    return 1e9 * spent / (static_cast<double>(rounds) * static_cast<double>(count));
}

double fcl_collide(const box_pair *pair, unsigned long count, int rounds, unsigned long *overlapping)
{
    return time_all(pair, count, rounds, overlapping, [](const box_pair &p) {
        fcl::CollisionRequestd request(1, true);
        fcl::CollisionResultd result;
        fcl::Boxd a = shape_of(p.a), b = shape_of(p.b);
        return fcl::collide(&a, pose_of(p.a), &b, pose_of(p.b), request, result) > 0;
    });
}

double fcl_distance(const box_pair *pair, unsigned long count, int rounds, unsigned long *overlapping)
{
    return time_all(pair, count, rounds, overlapping, [](const box_pair &p) {
        fcl::DistanceRequestd request(true);
        fcl::DistanceResultd result;
        fcl::Boxd a = shape_of(p.a), b = shape_of(p.b);
        return fcl::distance(&a, pose_of(p.a), &b, pose_of(p.b), request, result) <= 0;
    });
}

void farthest(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const placed_box *box = static_cast<const placed_box *>(object);
    double at[3] = {box->centre[0], box->centre[1], box->centre[2]};
    for (int i = 0; i < 3; i++) {
        double along = 0;
        for (int k = 0; k < 3; k++)
            along += box->axis[i][k] * direction->v[k];
        for (int k = 0; k < 3; k++)
            at[k] += (along < 0 ? -box->half[i] : box->half[i]) * box->axis[i][k];
    }
    ccdVec3Set(out, at[0], at[1], at[2]);
}

double ccd_epa(const box_pair *pair, unsigned long count, int rounds, unsigned long *overlapping)
{
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = farthest;
    ccd.max_iterations = 100;
    ccd.epa_tolerance = 1e-7;
    return time_all(pair, count, rounds, overlapping, [&ccd](const box_pair &p) {
        ccd_real_t depth;
        ccd_vec3_t direction, position;
        return ccdGJKPenetration(&p.a, &p.b, &ccd, &depth, &direction, &position) == 0;
    });
}
} // namespace

extern "C" const other others[] = {{"FCL collide", fcl_collide}, {"FCL distance", fcl_distance}, {"libccd GJK and EPA", ccd_epa}};
extern "C" const int other_count = 3;

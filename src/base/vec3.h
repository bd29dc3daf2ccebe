/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Vectors of three doubles for scalar code. The order of operations is part of
 * the contract: sums run x, y, z, so that vector kernels can match the bits. */
#ifndef SCREE_BASE_VEC3_H
#define SCREE_BASE_VEC3_H

struct vec3 {
    double x, y, z;
};

static inline struct vec3 vec3_load(const double *a)
{
    return (struct vec3){a[0], a[1], a[2]};
}
static inline void vec3_store3(double *a, struct vec3 v)
{
    a[0] = v.x;
    a[1] = v.y;
    a[2] = v.z;
}
static inline void vec3_store(double a[4], struct vec3 v) // into a row, whose fourth element becomes 0
{
    vec3_store3(a, v);
    a[3] = 0;
}
static inline struct vec3 vec3_add(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline struct vec3 vec3_sub(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline struct vec3 vec3_scale(struct vec3 a, double s)
{
    return (struct vec3){a.x * s, a.y * s, a.z * s};
}
static inline double vec3_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
/* Square of the length of three doubles. */
static inline double vec3_square(const double *a)
{
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}
static inline struct vec3 vec3_cross(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

#endif

/* Vectors of space. */
#ifndef REFDEM_SPACE_H
#define REFDEM_SPACE_H

#include <math.h>

/* a.b. */
static inline double dot(const double *restrict a, const double *restrict b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* out = a x b. */
static inline void cross(const double *restrict a, const double *restrict b, double *restrict out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* a += factor b. */
static inline void add_scaled(double *restrict a, double factor, const double *restrict b)
{
    for (int c = 0; c < 3; c++)
        a[c] += factor * b[c];
}

/* |a|. */
static inline double size(const double *restrict a)
{
    return sqrt(dot(a, a));
}

#endif

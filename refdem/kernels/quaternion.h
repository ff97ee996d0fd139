/* Quaternions (w, x, y, z); unit ones rotate body vectors into space: r_s = q r_b q*. */
#ifndef REFDEM_QUATERNION_H
#define REFDEM_QUATERNION_H

#include "double_double.h"

/* The product q p: (a, u)(b, v) = (a b - u.v, a v + b u + u x v) (Hamilton 1843). */
static inline void quaternion_product(const double *restrict q, const double *restrict p,
                                      double *restrict out)
{
    out[0] = q[0] * p[0] - q[1] * p[1] - q[2] * p[2] - q[3] * p[3];
    out[1] = q[0] * p[1] + q[1] * p[0] + q[2] * p[3] - q[3] * p[2];
    out[2] = q[0] * p[2] - q[1] * p[3] + q[2] * p[0] + q[3] * p[1];
    out[3] = q[0] * p[3] + q[1] * p[2] - q[2] * p[1] + q[3] * p[0];
}

/* q = q/|q|. */
static inline void quaternion_normalised(double *restrict q)
{
    double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++)
        q[i] /= size;
}

/* The shortest rotation that takes the unit vector n to the unit vector e, not opposite to it: (1 +
 * n.e, n x e) normalised. */
static inline void quaternion_swing(const double *restrict n, const double *restrict e,
                                    double *restrict q)
{
    q[0] = 1.0 + (n[0] * e[0] + n[1] * e[1] + n[2] * e[2]);
    q[1] = n[1] * e[2] - n[2] * e[1];
    q[2] = n[2] * e[0] - n[0] * e[2];
    q[3] = n[0] * e[1] - n[1] * e[0];
    quaternion_normalised(q);
}

/* q v q* = v + 2 w (u x v) + 2 u x (u x v), u the vector part. */
static inline void quaternion_rotated(const double *restrict q, const double *restrict v,
                                      double *restrict out)
{
    /* t = 2 u x v,   out = v + w t + u x t. */
    double tx = 2.0 * (q[2] * v[2] - q[3] * v[1]);
    double ty = 2.0 * (q[3] * v[0] - q[1] * v[2]);
    double tz = 2.0 * (q[1] * v[1] - q[2] * v[0]);
    out[0] = v[0] + (q[0] * tx + (q[2] * tz - q[3] * ty));
    out[1] = v[1] + (q[0] * ty + (q[3] * tx - q[1] * tz));
    out[2] = v[2] + (q[0] * tz + (q[1] * ty - q[2] * tx));
}

/* The unit quaternion q = attitude/|attitude|, and omega in body axes, q* omega q = omega + q0 t +
 * u x t with u = -(q1, q2, q3) and t = 2 u x omega, in double-double. */
static inline void quaternion_body(const double *restrict attitude, const double *restrict omega,
                                   dd *restrict q, dd *restrict w)
{
    dd size = dd_of(0.0);
    dd twist[3];
    for (int i = 0; i < 4; i++)
        size = dd_add(size, two_product(attitude[i], attitude[i]));
    size = dd_sqrt(size);
    for (int i = 0; i < 4; i++)
        q[i] = dd_div(dd_of(attitude[i]), size);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        twist[i]
            = dd_scale(dd_sub(dd_scale(q[k + 1], omega[j]), dd_scale(q[j + 1], omega[k])), 2.0);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        dd more = dd_sub(dd_mul(q[k + 1], twist[j]), dd_mul(q[j + 1], twist[k]));
        w[i] = dd_add(dd_of(omega[i]), dd_add(dd_mul(q[0], twist[i]), more));
    }
}

#endif

/* The constants of a free body's motion, from its start (`prepare`): see free_body.c for the
 * formulas. */
#ifndef REFDEM_FREE_BODY_START_H
#define REFDEM_FREE_BODY_START_H

#include <string.h>

#include "elliptic.h"
#include "quaternion.h"

/* Kinds: constant omega; two equal moments; three different moments. */
enum { STEADY, SYMMETRIC, TUMBLING };
enum { THETA_TERMS = 5 };

typedef struct {
    int kind, axis[3];    /* axes of the labels 1, 2, 3 */
    dd w[3], rate, start; /* omega_body at the start; u = rate t + start, or the spin about axis 3
                             of a symmetric body */
    dd turn;              /* mean of Psi' / 2 */
    turns phase, mean;    /* u in periods of sn, the mean turn in half turns */
    double t0, attitude[4], omega[3]; /* the start, as given */
    double frame[4][4];               /* left product by `base`, vector parts by label */
    int64_t samples;
    const double *t;
    double *out_attitude, *out_omega;
    double base[4], along[3];     /* attitude before the turn, and its unit axis */
    double size[3], direction[3]; /* amplitudes of omega_body and of n, by label */
    double order;                 /* +1 if J3 is the largest moment, -1 if the smallest */
    double phase_shift;           /* of theta: how a enters it, or tan(a/2) */
    double slope;                 /* of theta: linear part of its argument */
    double rise[2][THETA_TERMS], fall[2][THETA_TERMS]; /* its coefficients, real and imaginary */
    double cos0, sin0, f0;                             /* its argument at the start */
    jacobi j;
} free_body;

/* n numbers in double-double, rounded. */
static void rounded(const dd *restrict from, int n, double *restrict to)
{
    for (int i = 0; i < n; i++)
        to[i] = dd_round(from[i]);
}

/* omega stays: q(t) = q0 exp(omega_body t/2), a turn at the rate |omega| about omega_body. */
static void prepare_steady(free_body *b)
{
    /* turn = |omega|/2, along = omega_body/|omega|. */
    dd speed = dd_sqrt(dd_dot(b->w, b->w));
    b->kind = STEADY;
    b->turn = dd_scale(speed, 0.5);
    for (int i = 0; i < 3; i++) {
        b->along[i] = 0.0; /* at rest there is no axis */
        if (speed.hi > 0.0)
            b->along[i] = dd_round(dd_div(b->w[i], speed));
    }
}

/* J1 = J2: q(t) = q0 exp(l t/(2 J1)) exp(e3 rate t/2), with rate = (1 - J3/J1) w3 and the angular
 * momentum l in body axes at the start; turn = |l|/(2 J1), along = l/|l|. */
static void prepare_symmetric(free_body *b, const double *restrict inertia)
{
    dd l[3], momentum;
    dd j1 = dd_of(inertia[b->axis[0]]);
    for (int i = 0; i < 3; i++)
        l[i] = dd_scale(b->w[i], inertia[i]);
    momentum = dd_sqrt(dd_dot(l, l));
    b->kind = SYMMETRIC;
    b->turn = dd_scale(dd_div(momentum, j1), 0.5);
    b->rate = dd_mul(b->w[b->axis[2]], dd_div(two_sum(j1.hi, -inertia[b->axis[2]]), j1));
    for (int i = 0; i < 3; i++)
        b->along[i] = dd_round(dd_div(l[i], momentum));
}

/* Coefficients of theta4(pi (u + ia)/(2K), nome^2), up to a positive factor, as a series in cosines
 * (real part) and sines (imaginary part) of 2 n pi f. With the shift s = pi a/(2K) the terms are
 *
 *   (-1)^n nome^(2 n^2) ((exp(2 n s) + exp(-2 n s)) cos - i (exp(2 n s) - exp(-2 n s)) sin),
 *
 * and 1 for n = 0. For m > 1/2 they are those of theta2 after z -> z/tau, with the shift s = pi
 * a/(4K') and the nome of m1,
 *
 *   rise: nome^(n^2/2) exp(i (2 n + 1) s),   fall: nome^(n (n + 1)/2) exp(-i (2 n + 1) s),
 *
 * and the argument has in addition a part linear in u, the slope. */
static void prepare_theta(free_body *b, double a, double c)
{
    const jacobi *j = &b->j;
    if (j->kind == SEPARATRIX) {
        b->phase_shift = sqrt((1.0 - c) / (1.0 + c));
        return;
    }
    b->phase_shift = DD_PI.hi * a / (2.0 * j->quarter.hi);
    b->slope = 0.0;
    if (j->kind == HYPERBOLIC) { /* after Jacobi's imaginary transformation */
        b->phase_shift = DD_PI.hi * a / (4.0 * j->other.hi);
        b->slope = -DD_PI.hi * a / (4.0 * j->quarter.hi * j->other.hi);
    }
    for (int n = 0; n < THETA_TERMS; n++) {
        double log_nome = j->log_nome;
        double sign = 1.0;
        if (n % 2 == 1)
            sign = -1.0;
        double angle = (2 * n + 1) * b->phase_shift;
        if (j->kind == CIRCULAR) {
            double grown = exp(2.0 * n * (log_nome * n + b->phase_shift));
            double shrunk = exp(2.0 * n * (log_nome * n - b->phase_shift));
            b->rise[0][n] = sign * (grown + shrunk);
            b->rise[1][n] = sign * (shrunk - grown);
            if (n == 0) { /* the middle term counts once */
                b->rise[0][0] = 1.0;
                b->rise[1][0] = 0.0;
            }
        } else {
            double up = exp(0.5 * log_nome * n * n);
            double down = exp(0.5 * log_nome * n * (n + 1));
            b->rise[0][n] = up * cos(angle);
            b->fall[0][n] = down * cos(angle);
            b->rise[1][n] = up * sin(angle);
            b->fall[1][n] = -down * sin(angle);
        }
    }
}

/* a[0] + .. + a[4] x^4. */
static inline double quartic(const double *restrict a, double x)
{
    return fma(x, fma(x, fma(x, fma(x, a[4], a[3]), a[2]), a[1]), a[0]);
}

/* The direction (x, y) of that theta function in the complex plane at count points, of any length
 * (DLMF 20.2.4; 20.2.2 with 20.7.33); on the separatrix that of 1 + i tan(a/2) tanh(u/2). Of the
 * circular series three terms suffice: the next one is nome^18 exp(6 s) < nome^15 < 1e-20. */
static inline void theta_direction(const free_body *restrict b, int count,
                                   const jacobi_points *restrict p, double *restrict x,
                                   double *restrict y)
{
    if (b->j.kind == SEPARATRIX)
        for (int k = 0; k < count; k++) {
            x[k] = 1.0;
            y[k] = b->phase_shift * tanh(0.5 * p->f[k]);
        }
    else if (b->j.kind == CIRCULAR)
        for (int k = 0; k < count; k++) {
            /* cos(2 y) = 2 c^2 - 1 and sin(2 y) = 2 s c for y = 2 pi f, c = cos y, s = sin y. */
            double c = p->first[k];
            double s = p->second[k];
            x[k] = fma(b->rise[0][2], fma(2.0 * c, c, -1.0), fma(b->rise[0][1], c, b->rise[0][0]));
            y[k] = s * fma(2.0 * c, b->rise[1][2], b->rise[1][1]);
        }
    else
        for (int k = 0; k < count; k++) {
            /* sum of rise_n up^n + fall_n down^(n + 1), which is conjugated for f < 0. */
            double down = p->first[k];
            double up = p->second[k];
            x[k] = fma(down, quartic(b->fall[0], down), quartic(b->rise[0], up));
            y[k] = copysign(1.0, p->f[k])
                   * fma(down, quartic(b->fall[1], down), quartic(b->rise[1], up));
        }
}

/* Mean of Psi'/2 = L/(2 J3) + X/(2 L J3) <1/(1 + c dn)>, with X = 2 E J3 - L^2 and the mean <> over
 * a period of dn. With the amplitudes n1^2 = 1 - c^2, n2^2 = 1 - c^2 m1, n3 = c and p of
 * prepare_tumbling, <1/(1 + c dn)> = (cel(m1, p)/n1^2 - n3 (pi/2)/(n1 n2))/K. */
static dd mean_turn(const free_body *b, dd l, dd j3, dd x, dd p, const dd *restrict n)
{
    dd across = dd_mul(n[0], n[1]);
    /* mean = <1/(1 + c dn)>; it is 1 on the separatrix, where dn tends to 0 */
    dd mean = dd_of(1.0);
    if (b->j.kind != SEPARATRIX) {
        mean = dd_div(complete_third(b->j.m1, p), dd_square(n[0]));
        mean = dd_sub(mean, dd_div(dd_mul(n[2], dd_scale(DD_PI, 0.5)), across));
        mean = dd_div(mean, b->j.quarter);
    }
    /* (L/J3 + X/(L J3) <1/(1 + c dn)>)/2 */
    mean = dd_mul(mean, dd_div(x, dd_mul(l, j3)));
    return dd_scale(dd_add(dd_div(l, j3), mean), 0.5);
}

/* Moments J1, J2, J3 and their differences J3 - J2, J3 - J1, J2 - J1, by label [kg m^2]. */
typedef struct {
    dd j[3], d32, d31, d21;
} moments;

/* The Jacobi functions and their rate, the amplitudes a of omega_body and n = J a/L of the
 * direction of L, and X = 2 E J3 - L^2 = J1 (J3 - J1) w1^2 + J2 (J3 - J2) w2^2, without
 * cancellation; returns L. Amplitudes: a1^2 = w1^2 + flat w2^2, a2^2 = w2^2 + w1^2/flat, a3^2 =
 * w3^2 + steep w2^2, flat = J2 (J3 - J2)/(J1 (J3 - J1)), steep = J2 (J2 - J1)/(J3 (J3 - J1)); m =
 * (J2 - J1) X/((J3 - J2) Y), Y = L^2 - 2 E J1. */
static dd amplitudes(free_body *b, const moments *k, const dd *restrict w, dd *restrict a,
                     dd *restrict n, dd *restrict x)
{
    dd square[3], l[3], momentum;
    for (int i = 0; i < 3; i++) {
        square[i] = dd_square(w[i]);
        l[i] = dd_mul(w[i], k->j[i]);
    }
    /* flat = J2 (J3 - J2)/(J1 (J3 - J1)), steep = J2 (J2 - J1)/(J3 (J3 - J1)) */
    dd flat = dd_div(dd_mul(k->j[1], k->d32), dd_mul(k->j[0], k->d31));
    dd steep = dd_div(dd_mul(k->j[1], k->d21), dd_mul(k->j[2], k->d31));
    /* Y = L^2 - 2 E J1 = J2 (J2 - J1) w2^2 + J3 (J3 - J1) w3^2,
     * Z = L^2 - 2 E J2 = J3 (J3 - J2) w3^2 - J1 (J2 - J1) w1^2,
     * X = 2 E J3 - L^2 = J1 (J3 - J1) w1^2 + J2 (J3 - J2) w2^2. */
    dd y = dd_add(dd_mul(dd_mul(k->j[1], k->d21), square[1]),
                  dd_mul(dd_mul(k->j[2], k->d31), square[2]));
    dd z = dd_sub(dd_mul(dd_mul(k->j[2], k->d32), square[2]),
                  dd_mul(dd_mul(k->j[0], k->d21), square[0]));
    *x = dd_add(dd_mul(dd_mul(k->j[0], k->d31), square[0]),
                dd_mul(dd_mul(k->j[1], k->d32), square[1]));
    /* a1^2 = w1^2 + flat w2^2, a2^2 = w2^2 + w1^2/flat, a3^2 = w3^2 + steep w2^2; n = J a/L */
    a[0] = dd_sqrt(dd_add(square[0], dd_mul(flat, square[1])));
    a[1] = dd_sqrt(dd_add(square[1], dd_div(square[0], flat)));
    a[2] = dd_sqrt(dd_add(square[2], dd_mul(steep, square[1])));
    momentum = dd_sqrt(dd_dot(l, l));
    for (int i = 0; i < 3; i++)
        n[i] = dd_div(dd_mul(k->j[i], a[i]), momentum);
    /* rate^2 = (J3 - J2) Y/(J1 J2 J3), m = (J2 - J1) X/((J3 - J2) Y), and m1 = 1 - m =
     * (J3 - J1) Z/((J3 - J2) Y) without cancellation */
    dd denominator = dd_mul(k->d32, y);
    b->rate = dd_sqrt(dd_div(denominator, dd_mul(k->j[0], dd_mul(k->j[1], k->j[2]))));
    b->j = jacobi_prepare(dd_div(dd_mul(k->d21, *x), denominator),
                          dd_div(dd_mul(k->d31, z), denominator));
    return momentum;
}

/* Signs of the amplitudes, and u at the start from cn = w1/A1, sn = w2/A2, dn = w3/A3, A = +-a.
 * With rate > 0 and dn > 0: A3 has the sign of w3, A1 is positive (on the separatrix it has the
 * sign of w1, as cn = sech u > 0), and A2 has the sign of +-(J3 - J1) A3 A1 by Euler's equation
 * J2 w2' = +-(J3 - J1) w3 w1, + where the axes 1, 2, 3 are in cyclic order. */
static void prepare_signs(free_body *b, dd *restrict w, const dd *restrict a, const dd *restrict n)
{
    double parity = -1.0;
    if ((b->axis[1] + 3 - b->axis[0]) % 3 == 1) /* the axes are in cyclic order */
        parity = 1.0;
    double sign[3] = {1.0, 1.0, copysign(1.0, w[2].hi)};
    if (b->j.kind == SEPARATRIX)
        sign[0] = copysign(1.0, w[0].hi);
    sign[1] = sign[0] * sign[2] * parity * b->order;
    for (int i = 0; i < 3; i++) {
        b->size[i] = sign[i] * dd_round(a[i]);
        b->direction[i] = sign[i] * dd_round(n[i]);
        w[i] = dd_scale(dd_div(w[i], a[i]), sign[i]);
    }
    b->start = jacobi_inverse(&b->j, w[1], w[0], w[2]);
    b->along[b->axis[0]] = 0.0;
    b->along[b->axis[1]] = 0.0;
    b->along[b->axis[2]] = sign[2];
}

/* The attitude `base` of q(t) = base exp(e Psi/2) swing(n -> e): with Psi = 0 at the start, where
 * the attitude is q0 and n is n0,
 *
 *   base = q0 swing(n0 -> e)^-1,   n0 = (N1 cn, N2 sn, N3 dn) by label, N = J A/L.
 *
 * `frame` is the matrix of the product base q, for a q whose vector part is by label. cos0 and sin0
 * are the direction of the theta function at the start, from which Psi is counted. */
static void prepare_frame(free_body *b)
{
    jacobi_points p;
    double direction[3], tilt[4], q[4], column[4];
    jacobi_at(&b->j, b->phase, 0.0, 1, &(double){0.0}, &p);
    theta_direction(b, 1, &p, &b->cos0, &b->sin0);
    double size = sqrt(b->cos0 * b->cos0 + b->sin0 * b->sin0);
    b->cos0 /= size;
    b->sin0 /= size;
    b->f0 = p.f[0];
    direction[b->axis[0]] = b->direction[0] * p.cn[0];
    direction[b->axis[1]] = b->direction[1] * p.sn[0];
    direction[b->axis[2]] = b->direction[2] * p.dn[0];
    quaternion_swing(direction, b->along, tilt);
    /* the inverse of a unit quaternion is its conjugate */
    double back[4] = {tilt[0], -tilt[1], -tilt[2], -tilt[3]};
    memcpy(q, b->base, sizeof q);
    quaternion_product(q, back, b->base);
    quaternion_normalised(b->base);
    /* column k of the matrix is base times unit quaternion k */
    for (int k = 0; k < 4; k++) {
        double unit[4] = {0};
        int component = 0; /* the scalar part, then the labels 1, 2, 3 */
        if (k > 0)
            component = 1 + b->axis[k - 1];
        unit[component] = 1.0;
        quaternion_product(b->base, unit, column);
        for (int i = 0; i < 4; i++)
            b->frame[i][k] = column[i];
    }
}

/* Three different moments: Jacobi functions for omega, theta series for the turn about L.
 *
 * The poles +-ia of Psi' have dn(ia | m) = 1/c, which is sn(a | m1) = 1/sqrt(p):
 *
 *   p = J2 (J3 - J1)/(J1 (J3 - J2)),   a = R_F(cn^2, dn^2, 1)/sqrt(p),
 *   cn^2 = 1 - 1/p = J3 (J2 - J1)/(J2 (J3 - J1)),   dn^2 = 1 - m1/p   at (a | m1). */
static void prepare_tumbling(free_body *b, const double *restrict inertia)
{
    moments k;
    dd w[3], a[3], n[3], x;
    dd one = dd_of(1.0);
    for (int i = 0; i < 3; i++) {
        w[i] = b->w[b->axis[i]];
        k.j[i] = dd_of(inertia[b->axis[i]]);
    }
    k.d32 = two_sum(k.j[2].hi, -k.j[1].hi);
    k.d31 = two_sum(k.j[2].hi, -k.j[0].hi);
    k.d21 = two_sum(k.j[1].hi, -k.j[0].hi);
    b->kind = TUMBLING;
    b->order = copysign(1.0, k.d31.hi);
    dd size = amplitudes(b, &k, w, a, n, &x);
    /* p = J2 (J3 - J1)/below, above/p = cn^2 = J3 (J2 - J1)/(J2 (J3 - J1)), dn^2 = 1 - m1/p, with
     * below = J1 (J3 - J2) and above = J3 (J2 - J1)/below; a = R_F(cn^2, dn^2, 1)/sqrt(p) */
    dd below = dd_mul(k.j[0], k.d32);
    dd p = dd_div(dd_mul(k.j[1], k.d31), below);
    dd above = dd_div(dd_mul(k.j[2], k.d21), below);
    dd dn = dd_sub(one, dd_div(b->j.m1, p));
    b->turn = mean_turn(b, size, k.j[2], x, p, n);
    double arc = dd_round(dd_div(carlson_rf(dd_div(above, p), dn, one), dd_sqrt(p)));
    prepare_theta(b, arc, n[2].hi);
    prepare_signs(b, w, a, n);
    b->phase = jacobi_turns(&b->j, b->rate, b->start);
    b->mean = (turns){dd_div(b->turn, DD_PI), dd_of(0.0)};
    prepare_frame(b);
}

/* Swaps two numbers. */
static void exchange(int *a, int *b)
{
    int kept = *a;
    *a = *b;
    *b = kept;
}

/* Gives the axes their labels: 2 the middle moment; 3 the axis that omega_body circles, the one on
 * whose side of the separatrix J1 (J2 - J1) w1^2 = J3 (J3 - J2) w3^2 the body is, or the axis of
 * symmetry. */
static void label(free_body *b, const double *restrict inertia)
{
    int *axis = b->axis;
    axis[0] = 0;
    axis[1] = 1;
    axis[2] = 2;
    for (int i = 0; i < 3; i++)
        if (inertia[axis[i % 2]] > inertia[axis[i % 2 + 1]])
            exchange(&axis[i % 2], &axis[i % 2 + 1]);
    double low = inertia[axis[0]];
    double middle = inertia[axis[1]];
    double high = inertia[axis[2]];
    /* first = J1 (J2 - J1) w1^2, third = J3 (J3 - J2) w3^2: omega_body circles the axis of the
     * lowest moment if the first is larger, and that of the highest if the third is. */
    dd first = dd_mul(dd_scale(two_sum(middle, -low), low), dd_square(b->w[axis[0]]));
    dd third = dd_mul(dd_scale(two_sum(high, -middle), high), dd_square(b->w[axis[2]]));
    if (low != middle && (middle == high || dd_sub(first, third).hi > 0.0))
        exchange(&axis[0], &axis[2]);
}

/* The constants of the motion from attitude and omega (space axes). The rotation is treated as
 * steady if it is about a principal axis, or if omega is within 1e-30 rad of the stable axis 3,
 * which is below the rounding of double-double. */
static void prepare(free_body *b, const double *restrict inertia, const double *restrict attitude,
                    const double *restrict omega)
{
    dd q[4];
    quaternion_body(attitude, omega, q, b->w);
    rounded(q, 4, b->base);
    label(b, inertia);
    double j1 = inertia[b->axis[0]];
    double j2 = inertia[b->axis[1]];
    double j3 = inertia[b->axis[2]];
    double w3 = b->w[b->axis[2]].hi;
    double across = dd_add(dd_square(b->w[b->axis[0]]), dd_square(b->w[b->axis[1]])).hi;
    int is_middle = b->w[b->axis[0]].hi == 0.0 && w3 == 0.0;
    int is_symmetric = j1 == j2;
    if (j1 == j3 || is_middle || across <= 1e-60 * w3 * w3 || (is_symmetric && w3 == 0.0))
        prepare_steady(b);
    else if (is_symmetric)
        prepare_symmetric(b, inertia);
    else
        prepare_tumbling(b, inertia);
}

#endif

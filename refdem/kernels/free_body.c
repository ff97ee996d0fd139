/* One free rigid body in closed form: omega_body by Jacobi functions, attitude by one theta function.
 *
 * Euler's equations: C. G. J. Jacobi (1849); Landau and Lifshitz, Mechanics, section 37. Labels 1, 2, 3 by moment of inertia, 3 the
 * axis that omega_body circles: w1 = A1 cn u, w2 = A2 sn u, w3 = A3 dn u, u = rate t + start.
 * Attitude: van Zon and Schofield, J. Comput. Phys. 225 (2007) 145, here in swing-twist form, which is nowhere singular:
 * q(t) = base exp(e Psi / 2) quaternion_swing(n -> e), n the direction of L in body axes, e = +-e3 with n.e > 0, and
 * Psi' = (2E + L w.e) / (L + l.e) = L/J3 + B rate / (1 + c dn u), B rate = (2 E J3 - L^2)/(L J3), c = |J3 A3|/L.
 * 1/(1 + c dn) has simple poles at u = 2iK' +- ia (mod 2K, 4iK'), dn(ia) = 1/c, with residues that make
 * Psi/2 = turn t -+ [arg theta4(pi (u + ia)/(2K), nome^2)], the mean rate by complete integrals of the first and third kind.
 */
#include <string.h>

#include "elliptic.h"
#include "kernels.h"
#include "quaternion.h"

enum { STEADY, SYMMETRIC, TUMBLING };
enum { THETA_TERMS = 6 };

typedef struct {
    int kind, axis[3];                 /* axes of the labels 1, 2, 3 */
    dd w[3], rate, start;              /* omega_body at the start; u = rate t + start, or the spin about axis 3 of a symmetric body */
    dd turn;                           /* mean of Psi' / 2 */
    double base[4], along[3];          /* attitude before the turn, and its unit axis */
    double size[3], direction[3];      /* amplitudes of omega_body and of n, by label */
    double order;                      /* +1 if J3 is the largest moment, -1 if the smallest */
    double phase, slope;               /* of theta: tan(a/2), or how a enters; linear part of its argument */
    double rise[2][THETA_TERMS], fall[2][THETA_TERMS]; /* its coefficients, real and imaginary */
    double cos0, sin0, slope0;         /* its argument at the start */
    jacobi j;
} free_body;

static void rounded(const dd *restrict from, int n, double *restrict to)
{
    for (int i = 0; i < n; i++)
        to[i] = dd_round(from[i]);
}

/* omega stays: q(t) = q0 exp(omega_body t / 2). */
static void prepare_steady(free_body *b)
{
    dd size = dd_sqrt(dd_dot(b->w, b->w));
    b->kind = STEADY;
    b->turn = dd_scale(size, 0.5);
    for (int i = 0; i < 3; i++)
        b->along[i] = size.hi > 0.0 ? dd_round(dd_div(b->w[i], size)) : 0.0;
}

/* J1 = J2: q(t) = q0 exp(l t / (2 J1)) exp(e3 (1 - J3/J1) w3 t / 2), l the angular momentum in body axes at the start. */
static void prepare_symmetric(free_body *b, const double *restrict inertia)
{
    dd l[3], size, across = dd_of(inertia[b->axis[0]]);
    for (int i = 0; i < 3; i++)
        l[i] = dd_scale(b->w[i], inertia[i]);
    size = dd_sqrt(dd_dot(l, l));
    b->kind = SYMMETRIC;
    b->turn = dd_scale(dd_div(size, across), 0.5);
    b->rate = dd_mul(b->w[b->axis[2]], dd_div(two_sum(across.hi, -inertia[b->axis[2]]), across));
    for (int i = 0; i < 3; i++)
        b->along[i] = dd_round(dd_div(l[i], size));
}

/* Coefficients of theta4 of nome^2 at pi (u + ia)/(2K), up to a positive factor; of theta2 after z -> z/tau where m > 1/2. */
static void prepare_theta(free_body *b, double a, double c)
{
    const jacobi *j = &b->j;
    if (j->kind == SEPARATRIX) {
        b->phase = sqrt((1.0 - c) / (1.0 + c));
        return;
    }
    b->phase = DD_PI.hi * a / (j->kind == CIRCULAR ? 2.0 * j->quarter.hi : 4.0 * j->other.hi);
    b->slope = j->kind == CIRCULAR ? 0.0 : -DD_PI.hi * a / (4.0 * j->quarter.hi * j->other.hi);
    for (int n = 0; n < THETA_TERMS; n++) {
        double log_nome = j->log_nome, sign = n % 2 ? -1.0 : 1.0, angle = (2 * n + 1) * b->phase;
        if (j->kind == CIRCULAR) {
            double grown = exp(2.0 * n * (log_nome * n + b->phase)), shrunk = exp(2.0 * n * (log_nome * n - b->phase));
            b->rise[0][n] = n ? sign * (grown + shrunk) : 1.0;
            b->rise[1][n] = n ? sign * (shrunk - grown) : 0.0;
        } else {
            double up = exp(0.5 * log_nome * n * n), down = exp(0.5 * log_nome * n * (n + 1));
            b->rise[0][n] = up * cos(angle), b->fall[0][n] = down * cos(angle);
            b->rise[1][n] = up * sin(angle), b->fall[1][n] = -down * sin(angle);
        }
    }
}

/* Its direction in the complex plane (DLMF 20.2.4; 20.2.2 with 20.7.33); on the separatrix that of 1 + i tan(a/2) tanh(u/2). */
static void theta_direction(const free_body *b, const jacobi_point *p, double *restrict c, double *restrict s)
{
    double x = 0.0, y = 0.0;
    if (b->j.kind == SEPARATRIX) {
        x = 1.0, y = b->phase * tanh(0.5 * p->u);
    } else if (b->j.kind == CIRCULAR) {
        double ce = 1.0, se = 0.0, next;
        for (int n = 0; n < THETA_TERMS; n++) {
            x += b->rise[0][n] * ce, y += b->rise[1][n] * se;
            next = ce * p->c - se * p->s, se = se * p->c + ce * p->s, ce = next;
        }
    } else {
        double growth = sqrt(p->growth), up = 1.0, down = p->decay;
        for (int n = 0; n < THETA_TERMS; n++) {
            x += b->rise[0][n] * up + b->fall[0][n] * down;
            y += b->rise[1][n] * up + b->fall[1][n] * down;
            up *= growth, down *= p->decay;
        }
        y = copysign(1.0, p->u) * y;
    }
    double size = sqrt(x * x + y * y);
    *c = x / size, *s = y / size;
}

/* n in body axes at a point. */
static void direction_at(const free_body *b, const jacobi_point *p, double *restrict n)
{
    n[b->axis[0]] = b->direction[0] * p->cn;
    n[b->axis[1]] = b->direction[1] * p->sn;
    n[b->axis[2]] = b->direction[2] * p->dn;
}

/* Mean of Psi'/2 = L/(2 J3) + X/(2 L J3) <1/(1 + c dn)>, X = 2 E J3 - L^2; 1 - c^2 = n1^2, 1 - c^2 m1 = n2^2 (amplitudes). */
static dd mean_turn(const free_body *b, dd l, dd j3, dd x, dd p, const dd *restrict n)
{
    dd across = dd_mul(n[0], n[1]), mean = dd_of(1.0);
    if (b->j.kind != SEPARATRIX) {
        mean = dd_div(complete_third(b->j.m1, p), dd_square(n[0]));
        mean = dd_sub(mean, dd_div(dd_mul(n[2], dd_scale(DD_PI, 0.5)), across));
        mean = dd_div(mean, b->j.quarter);
    }
    mean = dd_mul(mean, dd_div(x, dd_mul(l, j3)));
    return dd_scale(dd_add(dd_div(l, j3), mean), 0.5);
}

/* Moments and their differences by label. */
typedef struct {
    dd j[3], d32, d31, d21;
} moments;

/* The parameter m and 1 - m, amplitudes a of omega_body and n of the direction of L; X = 2 E J3 - L^2, without cancellation. */
static dd amplitudes(free_body *b, const moments *k, const dd *restrict w, dd *restrict a, dd *restrict n, dd *restrict x)
{
    dd square[3], l[3], size;
    for (int i = 0; i < 3; i++)
        square[i] = dd_square(w[i]), l[i] = dd_mul(w[i], k->j[i]);
    dd flat = dd_div(dd_mul(k->j[1], k->d32), dd_mul(k->j[0], k->d31)), steep = dd_div(dd_mul(k->j[1], k->d21), dd_mul(k->j[2], k->d31));
    dd y = dd_add(dd_mul(dd_mul(k->j[1], k->d21), square[1]), dd_mul(dd_mul(k->j[2], k->d31), square[2]));
    dd z = dd_sub(dd_mul(dd_mul(k->j[2], k->d32), square[2]), dd_mul(dd_mul(k->j[0], k->d21), square[0]));
    *x = dd_add(dd_mul(dd_mul(k->j[0], k->d31), square[0]), dd_mul(dd_mul(k->j[1], k->d32), square[1]));
    a[0] = dd_sqrt(dd_add(square[0], dd_mul(flat, square[1])));
    a[1] = dd_sqrt(dd_add(square[1], dd_div(square[0], flat)));
    a[2] = dd_sqrt(dd_add(square[2], dd_mul(steep, square[1])));
    size = dd_sqrt(dd_dot(l, l));
    for (int i = 0; i < 3; i++)
        n[i] = dd_div(dd_mul(k->j[i], a[i]), size);
    dd below = dd_mul(k->d32, y);
    b->rate = dd_sqrt(dd_div(below, dd_mul(k->j[0], dd_mul(k->j[1], k->j[2]))));
    b->j = jacobi_prepared(dd_div(dd_mul(k->d21, *x), below), dd_div(dd_mul(k->d31, z), below));
    return size;
}

/* Signs of the amplitudes, and u at the start. */
static void prepare_signs(free_body *b, dd *restrict w, const dd *restrict a, const dd *restrict n)
{
    double parity = (b->axis[1] + 3 - b->axis[0]) % 3 == 1 ? 1.0 : -1.0;
    double sign[3] = {b->j.kind == SEPARATRIX ? copysign(1.0, w[0].hi) : 1.0, 1.0, copysign(1.0, w[2].hi)};
    sign[1] = sign[0] * sign[2] * parity * b->order;
    for (int i = 0; i < 3; i++) {
        b->size[i] = sign[i] * dd_round(a[i]), b->direction[i] = sign[i] * dd_round(n[i]);
        w[i] = dd_scale(dd_div(w[i], a[i]), sign[i]);
    }
    b->start = jacobi_inverse(&b->j, w[1], w[0], w[2]);
    b->along[b->axis[0]] = b->along[b->axis[1]] = 0.0;
    b->along[b->axis[2]] = sign[2];
}

static void prepare_tumbling(free_body *b, const double *restrict inertia)
{
    moments k;
    dd w[3], a[3], n[3], x, one = dd_of(1.0);
    for (int i = 0; i < 3; i++)
        w[i] = b->w[b->axis[i]], k.j[i] = dd_of(inertia[b->axis[i]]);
    k.d32 = two_sum(k.j[2].hi, -k.j[1].hi), k.d31 = two_sum(k.j[2].hi, -k.j[0].hi), k.d21 = two_sum(k.j[1].hi, -k.j[0].hi);
    b->kind = TUMBLING, b->order = copysign(1.0, k.d31.hi);
    dd size = amplitudes(b, &k, w, a, n, &x), below = dd_mul(k.j[0], k.d32);
    dd p = dd_div(dd_mul(k.j[1], k.d31), below), above = dd_div(dd_mul(k.j[2], k.d21), below);
    dd dn = dd_sub(one, dd_div(b->j.m1, p));
    b->turn = mean_turn(b, size, k.j[2], x, p, n);
    double arc = dd_round(dd_div(carlson_rf(dd_div(above, p), dn, one), dd_sqrt(p)));
    prepare_theta(b, arc, n[2].hi);
    prepare_signs(b, w, a, n);
    jacobi_point point = jacobi_at(&b->j, b->start);
    double direction[3], q[4], back[4];
    direction_at(b, &point, direction);
    theta_direction(b, &point, &b->cos0, &b->sin0);
    b->slope0 = b->slope * point.u;
    quaternion_swing(direction, b->along, q);
    back[0] = q[0], back[1] = -q[1], back[2] = -q[2], back[3] = -q[3];
    for (int i = 0; i < 4; i++)
        q[i] = b->base[i];
    quaternion_product(q, back, b->base);
    quaternion_normalised(b->base);
}

static void exchange(int *a, int *b)
{
    int kept = *a;
    *a = *b, *b = kept;
}

/* Labels: 2 the middle axis, 3 the one whose side of the separatrix J1 (J2-J1) w1^2 = J3 (J3-J2) w3^2 the body is on, or the axis
 * of symmetry. */
static void label(free_body *b, const double *restrict inertia)
{
    int *axis = b->axis;
    axis[0] = 0, axis[1] = 1, axis[2] = 2;
    for (int i = 0; i < 3; i++)
        if (inertia[axis[i % 2]] > inertia[axis[i % 2 + 1]])
            exchange(&axis[i % 2], &axis[i % 2 + 1]);
    double low = inertia[axis[0]], middle = inertia[axis[1]], high = inertia[axis[2]];
    dd first = dd_mul(dd_scale(two_sum(middle, -low), low), dd_square(b->w[axis[0]]));
    dd third = dd_mul(dd_scale(two_sum(high, -middle), high), dd_square(b->w[axis[2]]));
    if (low != middle && (middle == high || dd_sub(first, third).hi > 0.0))
        exchange(&axis[0], &axis[2]);
}

/* Steady: about a principal axis, or so close to a stable one that the tilt, 1e-30, is beyond all digits. */
static void prepare(free_body *b, const double *restrict inertia, const double *restrict attitude, const double *restrict omega)
{
    dd q[4];
    quaternion_body(attitude, omega, q, b->w);
    rounded(q, 4, b->base);
    label(b, inertia);
    double j1 = inertia[b->axis[0]], j2 = inertia[b->axis[1]], j3 = inertia[b->axis[2]], w3 = b->w[b->axis[2]].hi;
    double across = dd_add(dd_square(b->w[b->axis[0]]), dd_square(b->w[b->axis[1]])).hi;
    int is_middle = b->w[b->axis[0]].hi == 0.0 && w3 == 0.0, is_symmetric = j1 == j2;
    if (j1 == j3 || is_middle || across <= 1e-60 * w3 * w3 || (is_symmetric && w3 == 0.0))
        prepare_steady(b);
    else if (is_symmetric)
        prepare_symmetric(b, inertia);
    else
        prepare_tumbling(b, inertia);
}

/* The turn about b->along, then omega_body. */
static void tumbling_at(const free_body *b, dd time, double *restrict q, double *restrict w)
{
    double direction[3], c, s, ct, st, re, im, way[4], tilt[4];
    jacobi_point p = jacobi_at(&b->j, dd_add(b->start, dd_mul(b->rate, time)));
    for (int i = 0; i < 3; i++)
        w[b->axis[i]] = b->size[i] * (i == 0 ? p.cn : i == 1 ? p.sn : p.dn);
    turned(dd_add(dd_mul(b->turn, time), dd_of(-b->order * (b->slope * p.u - b->slope0))), &c, &s);
    theta_direction(b, &p, &ct, &st);
    re = ct * b->cos0 + st * b->sin0, im = -b->order * (st * b->cos0 - ct * b->sin0);
    double cosine = c * re - s * im, sine = s * re + c * im;
    double turn[4] = {cosine, sine * b->along[0], sine * b->along[1], sine * b->along[2]};
    direction_at(b, &p, direction);
    quaternion_swing(direction, b->along, tilt);
    quaternion_product(b->base, turn, way);
    quaternion_product(way, tilt, q);
}

static void turning_at(const free_body *b, dd time, double *restrict q, double *restrict w)
{
    double c, s, way[4];
    rounded(b->w, 3, w);
    turned(dd_mul(b->turn, time), &c, &s);
    double turn[4] = {c, s * b->along[0], s * b->along[1], s * b->along[2]};
    quaternion_product(b->base, turn, b->kind == STEADY ? q : way);
    if (b->kind == STEADY)
        return;
    dd half = dd_scale(dd_mul(b->rate, time), 0.5);
    turned(half, &c, &s);
    double spin[4] = {c, 0.0, 0.0, 0.0}, back[4] = {c, 0.0, 0.0, 0.0}, still[3] = {w[0], w[1], w[2]};
    spin[1 + b->axis[2]] = s, back[1 + b->axis[2]] = -s;
    quaternion_product(way, spin, q);
    quaternion_rotated(back, still, w);
}

int refdem_free_body(const double *inertia, const double *attitude, const double *omega, double t0, int64_t samples, const double *t,
                     double *out_attitude, double *out_omega)
{
    free_body b = {.kind = STEADY};
    prepare(&b, inertia, attitude, omega);
    for (int64_t k = 0; k < samples; k++, out_attitude += 4, out_omega += 3) {
        double w[3];
        memcpy(out_attitude, attitude, 4 * sizeof(double));
        memcpy(out_omega, omega, 3 * sizeof(double));
        if (t[k] == t0)
            continue;
        dd time = two_sum(t[k], -t0);
        if (b.kind == TUMBLING)
            tumbling_at(&b, time, out_attitude, w);
        else
            turning_at(&b, time, out_attitude, w);
        quaternion_normalised(out_attitude);
        if (b.kind != STEADY)
            quaternion_rotated(out_attitude, w, out_omega);
    }
    return 0;
}

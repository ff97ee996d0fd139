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
enum { THETA_TERMS = 5 };

typedef struct {
    int kind, axis[3];                 /* axes of the labels 1, 2, 3 */
    dd w[3], rate, start;              /* omega_body at the start; u = rate t + start, or the spin about axis 3 of a symmetric body */
    dd turn;                           /* mean of Psi' / 2 */
    turns phase, mean;                 /* u in periods of sn, the mean turn in half turns */
    double t0, attitude[4], omega[3];  /* the start, as given */
    double frame[4][4];                /* left product by `base`, vector parts by label */
    int64_t samples;
    const double *t;
    double *out_attitude, *out_omega;
    double base[4], along[3];          /* attitude before the turn, and its unit axis */
    double size[3], direction[3];      /* amplitudes of omega_body and of n, by label */
    double order;                      /* +1 if J3 is the largest moment, -1 if the smallest */
    double phase_shift, slope;             /* of theta: tan(a/2), or how a enters; linear part of its argument */
    double rise[2][THETA_TERMS], fall[2][THETA_TERMS]; /* its coefficients, real and imaginary */
    double cos0, sin0, f0;             /* its argument at the start */
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
        b->phase_shift = sqrt((1.0 - c) / (1.0 + c));
        return;
    }
    b->phase_shift = DD_PI.hi * a / (j->kind == CIRCULAR ? 2.0 * j->quarter.hi : 4.0 * j->other.hi);
    b->slope = j->kind == CIRCULAR ? 0.0 : -DD_PI.hi * a / (4.0 * j->quarter.hi * j->other.hi);
    for (int n = 0; n < THETA_TERMS; n++) {
        double log_nome = j->log_nome, sign = n % 2 ? -1.0 : 1.0, angle = (2 * n + 1) * b->phase_shift;
        if (j->kind == CIRCULAR) {
            double grown = exp(2.0 * n * (log_nome * n + b->phase_shift)), shrunk = exp(2.0 * n * (log_nome * n - b->phase_shift));
            b->rise[0][n] = n ? sign * (grown + shrunk) : 1.0;
            b->rise[1][n] = n ? sign * (shrunk - grown) : 0.0;
        } else {
            double up = exp(0.5 * log_nome * n * n), down = exp(0.5 * log_nome * n * (n + 1));
            b->rise[0][n] = up * cos(angle), b->fall[0][n] = down * cos(angle);
            b->rise[1][n] = up * sin(angle), b->fall[1][n] = -down * sin(angle);
        }
    }
}

static inline double quartic(const double *restrict a, double x)
{
    return fma(x, fma(x, fma(x, fma(x, a[4], a[3]), a[2]), a[1]), a[0]);
}

/* Its direction in the complex plane, of any length (DLMF 20.2.4; 20.2.2 with 20.7.33); on the separatrix that of
 * 1 + i tan(a/2) tanh(u/2). The first three terms of the circular series are all that binary64 can hold. */
static inline void theta_direction(const free_body *restrict b, int count, const jacobi_points *restrict p, double *restrict x,
                                   double *restrict y)
{
    if (b->j.kind == SEPARATRIX)
        for (int k = 0; k < count; k++)
            x[k] = 1.0, y[k] = b->phase_shift * tanh(0.5 * p->f[k]);
    else if (b->j.kind == CIRCULAR)
        for (int k = 0; k < count; k++) {
            double c = p->first[k], s = p->second[k];
            x[k] = fma(b->rise[0][2], fma(2.0 * c, c, -1.0), fma(b->rise[0][1], c, b->rise[0][0]));
            y[k] = s * fma(2.0 * c, b->rise[1][2], b->rise[1][1]);
        }
    else
        for (int k = 0; k < count; k++) {
            double down = p->first[k], up = p->second[k];
            x[k] = fma(down, quartic(b->fall[0], down), quartic(b->rise[0], up));
            y[k] = copysign(1.0, p->f[k]) * fma(down, quartic(b->fall[1], down), quartic(b->rise[1], up));
        }
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

/* What the motion is counted from: with turn and tilt at the start taken away, `base` is the given attitude. */
static void prepare_frame(free_body *b)
{
    jacobi_points p;
    double direction[3], tilt[4], q[4], column[4];
    jacobi_at(&b->j, b->phase, 0.0, 1, &(double){0.0}, &p);
    theta_direction(b, 1, &p, &b->cos0, &b->sin0);
    double size = sqrt(b->cos0 * b->cos0 + b->sin0 * b->sin0);
    b->cos0 /= size, b->sin0 /= size, b->f0 = p.f[0];
    direction[b->axis[0]] = b->direction[0] * p.cn[0];
    direction[b->axis[1]] = b->direction[1] * p.sn[0];
    direction[b->axis[2]] = b->direction[2] * p.dn[0];
    quaternion_swing(direction, b->along, tilt);
    double back[4] = {tilt[0], -tilt[1], -tilt[2], -tilt[3]};
    memcpy(q, b->base, sizeof q);
    quaternion_product(q, back, b->base);
    quaternion_normalised(b->base);
    for (int k = 0; k < 4; k++) {
        double unit[4] = {0};
        unit[k ? 1 + b->axis[k - 1] : 0] = 1.0;
        quaternion_product(b->base, unit, column);
        for (int i = 0; i < 4; i++)
            b->frame[i][k] = column[i];
    }
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
    b->phase = jacobi_turns(&b->j, b->rate, b->start);
    b->mean = (turns){dd_div(b->turn, DD_PI), dd_of(0.0)};
    prepare_frame(b);
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

/* Attitude, its vector part by component, and omega in body axes by label; none of them unit. */
typedef struct {
    double q[4][BLOCK], w[3][BLOCK];
} states;

/* base, the turn about b->along, the tilt back: count <= BLOCK times. */
static inline void tumbling_at(const free_body *restrict b, int count, const double *restrict t, states *restrict out)
{
    jacobi_points p;
    double x[BLOCK], y[BLOCK];
    jacobi_at(&b->j, b->phase, b->t0, count, t, &p);
    theta_direction(b, count, &p, x, y);
    double e = b->along[b->axis[2]], hand = (b->axis[1] + 3 - b->axis[0]) % 3 == 1 ? e : -e, order = b->order;
    double slope = -order * b->slope * (b->j.kind == SEPARATRIX ? 1.0 : 2.0 * b->j.quarter.hi) / DD_PI.hi;
    for (int k = 0; k < count; k++) {
        double sign, c, s, part = fraction(b->mean, two_sum(t[k], -b->t0), &sign);
        part = fma(slope, p.f[k] - b->f0, part);
        double whole = nearest(part), odd = whole - 2.0 * nearest(0.5 * whole);
        sine_cosine_pi(part - whole, &s, &c);
        sign = fma(-2.0 * fabs(odd), sign, sign);
        double re = fma(x[k], b->cos0, y[k] * b->sin0), im = -order * fma(y[k], b->cos0, -(x[k] * b->sin0));
        double turn = sign * fma(c, re, -(s * im)), twist = sign * fma(s, re, c * im);
        double n1 = b->direction[0] * p.cn[k], n2 = b->direction[1] * p.sn[k], a = fma(e, b->direction[2] * p.dn[k], 1.0);
        double tall = hand * turn, q0 = turn * a, q1 = fma(tall, n2, twist * n1), q2 = fma(twist, n2, -(tall * n1)), q3 = twist * e * a;
        out->w[0][k] = b->size[0] * p.cn[k], out->w[1][k] = b->size[1] * p.sn[k], out->w[2][k] = b->size[2] * p.dn[k];
        out->q[0][k] = q0, out->q[1][k] = q1, out->q[2][k] = q2, out->q[3][k] = q3;
    }
}

/* Steady or symmetric bodies. */
static void turning_at(const free_body *b, dd time, double *restrict q, double *restrict omega)
{
    double c, s, way[4], w[3];
    turned(dd_mul(b->turn, time), &c, &s);
    double turn[4] = {c, s * b->along[0], s * b->along[1], s * b->along[2]};
    quaternion_product(b->base, turn, b->kind == STEADY ? q : way);
    if (b->kind == STEADY) {
        quaternion_normalised(q);
        return;
    }
    double still[3];
    rounded(b->w, 3, still);
    turned(dd_scale(dd_mul(b->rate, time), 0.5), &c, &s);
    double spin[4] = {c, 0.0, 0.0, 0.0}, back[4] = {c, 0.0, 0.0, 0.0};
    spin[1 + b->axis[2]] = s, back[1 + b->axis[2]] = -s;
    quaternion_product(way, spin, q);
    quaternion_normalised(q);
    quaternion_rotated(back, still, w);
    quaternion_rotated(q, w, omega);
}

/* Unit attitudes and omega in space axes. */
static inline void turned_out(const free_body *restrict b, int count, const states *restrict from, double *restrict attitude,
                              double *restrict omega)
{
    const double *w[3];
    for (int i = 0; i < 3; i++)
        w[b->axis[i]] = from->w[i];
    const double *p = w[0], *q = w[1], *r = w[2];
    for (int k = 0; k < count; k++) {
        double u[4];
        for (int i = 0; i < 4; i++)
            u[i] = fma(b->frame[i][0], from->q[0][k], fma(b->frame[i][1], from->q[1][k],
                   fma(b->frame[i][2], from->q[2][k], b->frame[i][3] * from->q[3][k])));
        double scale = 1.0 / sqrt(fma(u[0], u[0], fma(u[1], u[1], fma(u[2], u[2], u[3] * u[3]))));
        double a = scale * u[0], x = scale * u[1], y = scale * u[2], z = scale * u[3];
        double cx = 2.0 * fma(y, r[k], -(z * q[k])), cy = 2.0 * fma(z, p[k], -(x * r[k])), cz = 2.0 * fma(x, q[k], -(y * p[k]));
        attitude[4 * k] = a, attitude[4 * k + 1] = x, attitude[4 * k + 2] = y, attitude[4 * k + 3] = z;
        omega[3 * k] = p[k] + fma(a, cx, fma(y, cz, -(z * cy)));
        omega[3 * k + 1] = q[k] + fma(a, cy, fma(z, cx, -(x * cz)));
        omega[3 * k + 2] = r[k] + fma(a, cz, fma(x, cy, -(y * cx)));
    }
}

int64_t refdem_free_body_size(void)
{
    return (sizeof(free_body) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_free_body_prepare(const double *inertia, const double *attitude, const double *omega, double t0, int64_t samples,
                             const double *t, double *out_attitude, double *out_omega, double *motion)
{
    free_body *b = (free_body *)motion;
    *b = (free_body){.kind = STEADY, .t0 = t0, .samples = samples, .t = t, .out_attitude = out_attitude, .out_omega = out_omega};
    memcpy(b->attitude, attitude, sizeof b->attitude);
    memcpy(b->omega, omega, sizeof b->omega);
    prepare(b, inertia, attitude, omega);
    return 0;
}

REFDEM_EVERY_CPU
int refdem_free_body_run(const double *motion)
{
    const free_body *b = (const free_body *)motion;
    for (int64_t first = 0; first < b->samples && b->kind == TUMBLING; first += BLOCK) {
        int count = b->samples - first < BLOCK ? (int)(b->samples - first) : BLOCK;
        states found;
        tumbling_at(b, count, b->t + first, &found);
        turned_out(b, count, &found, b->out_attitude + 4 * first, b->out_omega + 3 * first);
    }
    for (int64_t k = 0; k < b->samples; k++) {
        int is_start = b->t[k] == b->t0;
        if (b->kind != TUMBLING && !is_start)
            turning_at(b, two_sum(b->t[k], -b->t0), b->out_attitude + 4 * k, b->out_omega + 3 * k);
        if (is_start)
            memcpy(b->out_attitude + 4 * k, b->attitude, sizeof b->attitude);
        if (is_start || b->kind == STEADY)
            memcpy(b->out_omega + 3 * k, b->omega, sizeof b->omega);
    }
    return 0;
}

int refdem_free_body(const double *inertia, const double *attitude, const double *omega, double t0, int64_t samples, const double *t,
                     double *out_attitude, double *out_omega)
{
    free_body b;
    refdem_free_body_prepare(inertia, attitude, omega, t0, samples, t, out_attitude, out_omega, (double *)&b);
    return refdem_free_body_run((const double *)&b);
}

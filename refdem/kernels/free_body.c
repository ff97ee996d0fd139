/* One free rigid body in closed form: omega_body by Jacobi functions, attitude by one theta
 * function.
 *
 * Euler's equations (C. G. J. Jacobi 1849; Landau and Lifshitz, Mechanics, section 37). Labels 1,
 * 2, 3 by moment of inertia, 3 the axis that omega_body circles:
 *
 *   w1 = A1 cn u,   w2 = A2 sn u,   w3 = A3 dn u,   u = rate t + start.
 *
 * Attitude (van Zon and Schofield, J. Comput. Phys. 225 (2007) 145), here in swing-twist form,
 * which is nowhere singular, with n the direction of L in body axes and e = +-e3 such that n.e >
 * 0:
 *
 *   q(t) = base exp(e Psi/2) swing(n -> e),
 *   Psi' = (2E + L w.e)/(L + l.e) = L/J3 + B rate/(1 + c dn u),
 *   B rate = (2 E J3 - L^2)/(L J3),   c = |J3 A3|/L.
 *
 * 1/(1 + c dn) has simple poles at u = 2iK' +- ia (mod 2K, 4iK'), dn(ia) = 1/c, with residues that
 * make
 *
 *   Psi/2 = turn t -+ [arg theta4(pi (u + ia)/(2K), nome^2)],
 *
 * the mean rate `turn` by complete integrals of the first and third kind. A body with two equal
 * moments turns about L and about its axis at constant rates.
 */
#include <assert.h>

#include "free_body_start.h"
#include "kernels.h"

/* Attitude, its vector part by component, and omega in body axes by label; none of them unit. */
typedef struct {
    double q[4][BLOCK], w[3][BLOCK];
} states;

/* The states at count <= BLOCK times t [s]: q = (turn + twist e) swing(n -> e) before the product
 * by base, of any length, and omega_body. turn and twist are cos and sin of Psi/2: its mean part in
 * half turns, reduced to its fraction, times the unit complex number of theta over that of the
 * start. */
static inline void tumbling_state_at(const free_body *restrict b, int count,
                                     const double *restrict t, states *restrict out)
{
    jacobi_points p;
    double theta_re[BLOCK], theta_im[BLOCK];
    jacobi_at(&b->j, b->phase, b->t0, count, t, &p);
    theta_direction(b, count, &p, theta_re, theta_im);
    /* e = +-1: the sign of e3 in e; hand = +-1: n x e = hand (n2, -n1, 0) by label. */
    double e = b->along[b->axis[2]];
    double hand = -e;
    if ((b->axis[1] + 3 - b->axis[0]) % 3 == 1) /* the axes are in cyclic order */
        hand = e;
    double order = b->order;
    double period = 2.0 * b->j.quarter.hi;
    if (b->j.kind == SEPARATRIX) /* no period: phases count in 1 */
        period = 1.0;
    /* Half turns x = Psi/(2 pi) = turn t/pi - order slope 2K (f - f0)/pi, but for the argument of
     * theta; f is the fraction of u/(2K). */
    double slope = -order * b->slope * period / DD_PI.hi;
    for (int k = 0; k < count; k++) {
        double sign, cosine, sine;
        /* Psi/2 but for the argument of theta, in half turns x. With the whole number n next to x,
         * cos(pi x) = (-1)^n cos(pi (x - n)), and alike for the sine. */
        double half_turns = fraction(b->mean, two_sum(t[k], -b->t0), &sign);
        half_turns = fma(slope, p.f[k] - b->f0, half_turns);
        double whole = nearest(half_turns);
        double odd = whole - 2.0 * nearest(0.5 * whole);
        sine_cosine_pi(half_turns - whole, &sine, &cosine);
        sign = fma(-2.0 * fabs(odd), sign, sign);
        /* turn + i twist = exp(i pi x) z up to a factor > 0, with z = theta conj(theta(t0)) or, for
         * order 1, its conjugate. */
        double re = fma(theta_re[k], b->cos0, theta_im[k] * b->sin0);
        double im = -order * fma(theta_im[k], b->cos0, -(theta_re[k] * b->sin0));
        double turn = sign * fma(cosine, re, -(sine * im));
        double twist = sign * fma(sine, re, cosine * im);
        /* (turn + twist e) (a + n x e) with a = 1 + n.e: the scalar part is turn a, the vector
         * part turn n x e + twist (n - (n.e) e) + twist a e; with e = +-e3, n x e is
         * hand (n2, -n1, 0) by label */
        double n1 = b->direction[0] * p.cn[k];
        double n2 = b->direction[1] * p.sn[k];
        double a = fma(e, b->direction[2] * p.dn[k], 1.0);
        double tall = hand * turn;
        double q0 = turn * a;
        double q1 = fma(tall, n2, twist * n1);
        double q2 = fma(twist, n2, -(tall * n1));
        double q3 = twist * e * a;
        /* w = (A1 cn, A2 sn, A3 dn) by label. */
        out->w[0][k] = b->size[0] * p.cn[k];
        out->w[1][k] = b->size[1] * p.sn[k];
        out->w[2][k] = b->size[2] * p.dn[k];
        out->q[0][k] = q0;
        out->q[1][k] = q1;
        out->q[2][k] = q2;
        out->q[3][k] = q3;
    }
}

/* Attitude and omega of steady or symmetric bodies at `time` after the start: base, the turn about
 * b->along, and for a symmetric body the spin about its axis; omega_body turns back about that
 * axis. */
static void turning_state_at(const free_body *b, dd time, double *restrict q,
                             double *restrict omega)
{
    double cosine, sine, turned_base[4], omega_body[3];
    /* turn: (cos a, sin a along) with the half angle a = turn time. */
    turned(dd_mul(b->turn, time), &cosine, &sine);
    double turn[4] = {cosine, sine * b->along[0], sine * b->along[1], sine * b->along[2]};
    if (b->kind == STEADY) { /* omega stays as given */
        quaternion_product(b->base, turn, q);
        quaternion_normalised(q);
        return;
    }
    quaternion_product(b->base, turn, turned_base);
    double omega_body_start[3];
    rounded(b->w, 3, omega_body_start);
    /* q = base turn spin with spin = (cos b, sin b e3), b = rate time/2, and omega_body(t) = spin*
     * omega_body(0) spin; omega in space axes is q omega_body q*. */
    turned(dd_scale(dd_mul(b->rate, time), 0.5), &cosine, &sine);
    double spin[4] = {cosine, 0.0, 0.0, 0.0};
    double back[4] = {cosine, 0.0, 0.0, 0.0};
    spin[1 + b->axis[2]] = sine;
    back[1 + b->axis[2]] = -sine;
    quaternion_product(turned_base, spin, q);
    quaternion_normalised(q);
    quaternion_rotated(back, omega_body_start, omega_body);
    quaternion_rotated(q, omega_body, omega);
}

/* Attitudes base q, normalised, and omega in space axes, q w q* = w + 2 q0 (u x w) + 2 u x (u x w),
 * for count states. */
static inline void to_space(const free_body *restrict b, int count, const states *restrict from,
                            double *restrict attitude, double *restrict omega)
{
    const double *w[3];
    for (int i = 0; i < 3; i++)
        w[b->axis[i]] = from->w[i];
    const double *p = w[0];
    const double *q = w[1];
    const double *r = w[2];
    for (int k = 0; k < count; k++) {
        /* base q is the product of the matrix `frame` and q; u = base q/|base q| = (a, x, y, z). */
        double u[4];
        for (int i = 0; i < 4; i++)
            u[i] = fma(b->frame[i][0], from->q[0][k],
                       fma(b->frame[i][1], from->q[1][k],
                           fma(b->frame[i][2], from->q[2][k], b->frame[i][3] * from->q[3][k])));
        double scale = 1.0 / sqrt(fma(u[0], u[0], fma(u[1], u[1], fma(u[2], u[2], u[3] * u[3]))));
        double a = scale * u[0];
        double x = scale * u[1];
        double y = scale * u[2];
        double z = scale * u[3];
        /* t = 2 u x w,   omega = w + a t + u x t, with the vector part u = (x, y, z) and w =
         * omega_body = (p, q, r). */
        double cx = 2.0 * fma(y, r[k], -(z * q[k]));
        double cy = 2.0 * fma(z, p[k], -(x * r[k]));
        double cz = 2.0 * fma(x, q[k], -(y * p[k]));
        attitude[4 * k] = a;
        attitude[4 * k + 1] = x;
        attitude[4 * k + 2] = y;
        attitude[4 * k + 3] = z;
        omega[3 * k] = p[k] + fma(a, cx, fma(y, cz, -(z * cy)));
        omega[3 * k + 1] = q[k] + fma(a, cy, fma(z, cx, -(x * cz)));
        omega[3 * k + 2] = r[k] + fma(a, cz, fma(x, cy, -(y * cx)));
    }
}

/* Doubles that a prepared motion takes. */
int64_t refdem_free_body_size(void)
{
    return (sizeof(free_body) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_free_body_prepare(const double *inertia, const double *attitude, const double *omega,
                             double t0, int64_t samples, const double *t, double *out_attitude,
                             double *out_omega, double *motion)
{
    assert(inertia && attitude && omega && motion);
    assert(samples == 0 || (t && out_attitude && out_omega)); /* (samples), (.., 4), (.., 3) */
    free_body *b = (free_body *)motion;
    *b = (free_body){.kind = STEADY,
                     .t0 = t0,
                     .samples = samples,
                     .t = t,
                     .out_attitude = out_attitude,
                     .out_omega = out_omega};
    memcpy(b->attitude, attitude, sizeof b->attitude);
    memcpy(b->omega, omega, sizeof b->omega);
    prepare(b, inertia, attitude, omega);
    return 0;
}

REFDEM_EVERY_CPU
int refdem_free_body_run(const double *motion)
{
    assert(motion);
    const free_body *b = (const free_body *)motion;
    for (int64_t first = 0; first < b->samples && b->kind == TUMBLING; first += BLOCK) {
        int count = BLOCK;
        if (b->samples - first < BLOCK) /* the last ones */
            count = (int)(b->samples - first);
        states found;
        tumbling_state_at(b, count, b->t + first, &found);
        to_space(b, count, &found, b->out_attitude + 4 * first, b->out_omega + 3 * first);
    }
    for (int64_t k = 0; k < b->samples; k++) {
        int is_start = b->t[k] == b->t0; /* the start is as it was given */
        if (b->kind != TUMBLING && !is_start)
            turning_state_at(b, two_sum(b->t[k], -b->t0), b->out_attitude + 4 * k,
                             b->out_omega + 3 * k);
        if (is_start)
            memcpy(b->out_attitude + 4 * k, b->attitude, sizeof b->attitude);
        if (is_start || b->kind == STEADY)
            memcpy(b->out_omega + 3 * k, b->omega, sizeof b->omega);
    }
    return 0;
}

int refdem_free_body(const double *inertia, const double *attitude, const double *omega, double t0,
                     int64_t samples, const double *t, double *out_attitude, double *out_omega)
{
    free_body b;
    double *prepared = (double *)&b; /* callers know a prepared run as doubles */
    refdem_free_body_prepare(inertia, attitude, omega, t0, samples, t, out_attitude, out_omega,
                             prepared);
    return refdem_free_body_run(prepared);
}

/* Elliptic integrals and Jacobi functions: double-double where phases are made, theta series in
 * binary64 where they are used.
 *
 * Complete integrals: arithmetic-geometric mean (DLMF 19.8.5) and Bulirsch's cel (Numer. Math. 13
 * (1969) 305). Incomplete ones: Carlson's duplication (DLMF 19.36.1). Functions: theta series
 * (DLMF 20.2, 22.2), after Jacobi's imaginary transformation (DLMF 22.6.1) where m > 1/2, so that
 * the nome never exceeds exp(-pi).
 */
#ifndef REFDEM_ELLIPTIC_H
#define REFDEM_ELLIPTIC_H

#include "simd.h"

/* K(m) = (pi/2)/agm(1, sqrt(m1)) for the complementary parameter m1 = 1 - m > 0; agm: a, b -> (a +
 * b)/2, sqrt(a b). */
static inline dd quarter_period(dd m1)
{
    dd a = dd_of(1.0);
    dd b = dd_sqrt(m1);
    /* agm(1, sqrt(m1)) = (a + b)/2 - (a - b)^2/(16 a) + ...: once a and b agree to 1e-17, the
     * second term is below the rounding of double-double. Convergence is quadratic: 40 steps are
     * more than the smallest m1 needs. */
    for (int i = 0; i < 40 && fabs(a.hi - b.hi) > 1e-17 * a.hi; i++) {
        dd mean = dd_scale(dd_add(a, b), 0.5);
        b = dd_sqrt(dd_mul(a, b));
        a = mean;
    }
    return dd_div(DD_PI, dd_add(a, b));
}

/* Bulirsch's cel(sqrt(m1), p, 1, 1): the integral over 0..pi/2 of dx/((cos^2 x + p sin^2 x)
 * sqrt(cos^2 x + m1 sin^2 x)), p > 0, m1 > 0, by his transformation (the names are those of his
 * program). */
static inline dd complete_third(dd m1, dd p)
{
    dd kc = dd_sqrt(m1);
    dd e = kc;
    dd m = dd_of(1.0);
    dd a = dd_of(1.0);
    dd b;
    p = dd_sqrt(p);
    b = dd_div(dd_of(1.0), p);
    /* A step keeps the value of the integral, and kc/m tends to 1. In the limit the value is
     * (pi/2) (b + a m)/(m (m + p)). With e = kc m, a step is
     *
     *   a -> a + b/p,   b -> 2 (b + a e/p),   p -> p + e/p,   m -> m + kc,   kc -> 2 sqrt(e),
     *
     * where the right-hand sides have the values before the step. */
    for (int i = 0;; i++) {
        dd f = a;
        dd g = dd_div(e, p);
        a = dd_add(a, dd_div(b, p));
        b = dd_scale(dd_add(b, dd_mul(f, g)), 2.0);
        p = dd_add(g, p);
        g = m;
        m = dd_add(kc, m);
        if (i == 40 || fabs(dd_sub(g, kc).hi) <= 1e-16 * g.hi)
            return dd_div(dd_mul(dd_scale(DD_PI, 0.5), dd_add(b, dd_mul(a, m))),
                          dd_mul(m, dd_add(m, p)));
        kc = dd_scale(dd_sqrt(e), 2.0);
        e = dd_mul(kc, m);
    }
}

/* Carlson's R_F(x, y, z) = 1/2 integral over 0..inf of dt/sqrt((t + x)(t + y)(t + z)), at most one
 * of them zero: x -> (x + s)/4 with s = sqrt(x y) + sqrt(x z) + sqrt(y z) until they are alike,
 * then the series in the symmetric functions e2, e3 of what they differ by (DLMF 19.36.1). */
static inline dd carlson_rf(dd x, dd y, dd z)
{
    dd mean, dx, dy, dz;
    for (int i = 0;; i++) {
        mean = dd_div(dd_add(dd_add(x, y), z), dd_of(3.0));
        dx = dd_sub(mean, x);
        dy = dd_sub(mean, y);
        dz = dd_sub(mean, z);
        if (i == 60 || fmax(fabs(dx.hi), fmax(fabs(dy.hi), fabs(dz.hi))) < 1e-6 * mean.hi)
            break;
        dd sx = dd_sqrt(x);
        dd sy = dd_sqrt(y);
        dd sz = dd_sqrt(z);
        dd shift = dd_add(dd_mul(sx, dd_add(sy, sz)), dd_mul(sy, sz));
        x = dd_scale(dd_add(x, shift), 0.25);
        y = dd_scale(dd_add(y, shift), 0.25);
        z = dd_scale(dd_add(z, shift), 0.25);
    }
    /* X = 1 - x/A and so on for the mean A; e2 = X Y - Z^2, e3 = X Y Z, as X + Y + Z = 0:
     * R_F = (1 - e2/10 + e3/14 + e2^2/24 - 3 e2 e3/44)/sqrt(A). */
    dx = dd_div(dx, mean);
    dy = dd_div(dy, mean);
    dz = dd_div(dz, mean);
    dd e2 = dd_sub(dd_mul(dx, dy), dd_square(dz));
    dd e3 = dd_mul(dx, dd_mul(dy, dz));
    dd sum = dd_sub(dd_of(1.0), dd_div(e2, dd_of(10.0)));
    sum = dd_add(sum, dd_div(e3, dd_of(14.0)));
    sum = dd_add(sum, dd_div(dd_square(e2), dd_of(24.0)));
    sum = dd_sub(sum, dd_div(dd_scale(dd_mul(e2, e3), 3.0), dd_of(44.0)));
    return dd_div(sum, dd_sqrt(mean));
}

/* The angle in (-pi, pi] [rad] whose sine and cosine are proportional to s and c: |s| R_F(c^2, 1,
 * 1) for an acute one, continued to the other quadrants; 0 for s = c = 0. */
static inline dd angle_of(dd s, dd c)
{
    dd one = dd_of(1.0);
    dd size = dd_sqrt(dd_add(dd_square(s), dd_square(c)));
    if (size.hi == 0.0) /* no direction */
        return dd_of(0.0);
    s = dd_div(s, size);
    c = dd_div(c, size);
    /* arcsin x = x R_F(1 - x^2, 1, 1) (DLMF 19.2.18, 19.16.6): the angle is arcsin |s|, or
     * pi/2 - arcsin |c| where |s| >= |c|; then pi - angle for c < 0, and -angle for s < 0. */
    dd acute;
    if (fabs(s.hi) < fabs(c.hi)) {
        acute = dd_mul(dd_abs(s), carlson_rf(dd_square(c), one, one));
    } else { /* closer to a right angle: pi/2 - arcsin |c| */
        dd rest = dd_mul(dd_abs(c), carlson_rf(dd_square(s), one, one));
        acute = dd_sub(dd_scale(DD_PI, 0.5), rest);
    }
    if (c.hi < 0.0)
        acute = dd_sub(DD_PI, acute);
    if (s.hi < 0.0)
        return dd_neg(acute);
    return acute;
}

/* Series of the Jacobi functions: circular for m <= 1/2, hyperbolic for m > 1/2, tanh and sech at m
 * = 1. */
enum { CIRCULAR, HYPERBOLIC, SEPARATRIX };
enum { TERMS = 4 }; /* nome <= exp(-pi): nome^(n^2) is below an ulp from n = 4 on */

/* The constants of the Jacobi functions of one parameter. */

typedef struct {
    int kind;              /* of series */
    dd m1, quarter, other; /* 1 - m, K(m), K(1 - m) */
    double log_nome;       /* of the nome that is used */
    double square[TERMS];  /* nome^(n^2) */
    double oblong[TERMS];  /* nome^(n (n + 1)) */
    double sn, cn, dn;     /* factors of the quotients of theta functions (DLMF 22.2.4-6) */
    double theta[4][4]; /* circular: theta1 / sin x, theta2 / cos x, theta3, theta4 as polynomials
                           in sin^2 x, with the factors */
} jacobi;

/* Points u = 2K (f + n), n whole, by columns: f in -1/2..1/2, sn, cn, dn, and what theta functions
 * of the same point need: cos and sin of 2 pi f if circular; exp(-|xi|) and sqrt(nome) exp(|xi|),
 * xi = pi K f/K', both at most 1, if hyperbolic. */
typedef struct {
    double f[BLOCK], sn[BLOCK], cn[BLOCK], dn[BLOCK], first[BLOCK], second[BLOCK];
} jacobi_points;

/* theta1 = 2 sum (-1)^n q^((n+1/2)^2) sin((2n+1) x) and so on (DLMF 20.2.1-4), as polynomials in
 * sin^2 x: sines, cosines and doubles have the multiple angles sin((2n+1) x)/sin x, cos((2n+1)
 * x)/cos x, cos(2n x) by rows n and powers (4.21.28). */
static inline void theta_polynomials(jacobi *j)
{
    /* theta1 and theta2 are divided by 2 nome^(1/4), the unit of theta2(0) in j->sn and j->cn:
     *   theta1 = sum (-1)^n nome^(n (n + 1)) sin((2n+1) x),
     *   theta2 = sum nome^(n (n + 1)) cos((2n+1) x),
     *   theta3 = 1 + 2 sum nome^(n^2) cos(2n x),   theta4 alike with the signs (-1)^n. */
    static const double sines[4][4] = {{1}, {3, -4}, {5, -20, 16}, {7, -56, 112, -64}};
    static const double cosines[4][4] = {{1}, {1, -4}, {1, -12, 16}, {1, -24, 80, -64}};
    static const double doubles[4][4] = {{0.5}, {1, -2}, {1, -8, 8}, {1, -18, 48, -32}};
    for (int n = 0; n < TERMS; n++)
        for (int k = 0; k <= n; k++) {
            double sign = 1.0;
            if (n % 2 == 1)
                sign = -1.0;
            j->theta[0][k] += j->sn * sign * j->oblong[n] * sines[n][k];
            j->theta[1][k] += j->cn * j->oblong[n] * cosines[n][k];
            j->theta[2][k] += j->dn * 2.0 * j->square[n] * doubles[n][k];
            j->theta[3][k] += sign * 2.0 * j->square[n] * doubles[n][k];
        }
}

/* The series of a parameter m and m1 = 1 - m >= 0: nome exp(-pi K'/K), or exp(-pi K/K') of m1 where
 * m > 1/2, its powers, and the values at 0 of theta3, theta4 and theta2. */
static inline jacobi jacobi_prepare(dd m, dd m1)
{
    jacobi j = {.kind = SEPARATRIX, .m1 = m1};
    if (m1.hi <= 0.0)
        return j;
    j.quarter = quarter_period(m1);
    j.other = dd_of(INFINITY);
    if (m.hi > 0.0)
        j.other = quarter_period(m);
    /* log nome = -pi K(1 - m)/K(m) for m <= 1/2, and -pi K(m)/K(1 - m) for m > 1/2 (DLMF
     * 22.2.1). */
    double ratio;
    if (m.hi <= 0.5) {
        j.kind = CIRCULAR;
        ratio = j.other.hi / j.quarter.hi;
    } else {
        j.kind = HYPERBOLIC;
        ratio = j.quarter.hi / j.other.hi;
    }
    j.log_nome = -DD_PI.hi * ratio;
    double nome = exp(j.log_nome);
    double power = 1.0;
    double odd = nome;
    double theta3_0 = 1.0;
    double theta4_0 = 1.0;
    double theta2_0 = 1.0;
    j.square[0] = 1.0;
    j.oblong[0] = 1.0;
    /* Values at 0, with theta2 in units of 2 nome^(1/4):
     * theta3 = 1 + 2 sum nome^(n^2), theta4 = 1 + 2 sum (-1)^n nome^(n^2),
     * theta2 = 1 + sum nome^(n (n + 1)).
     * The powers are products, nome^(n^2) = nome^((n - 1)^2) nome^(2n - 1) and
     * nome^(n (n + 1)) = nome^(n^2) nome^n. */
    for (int n = 1; n < TERMS; n++) {
        power *= nome;
        j.square[n] = j.square[n - 1] * odd;
        odd *= nome * nome;
        j.oblong[n] = j.square[n] * power;
        theta3_0 += 2.0 * j.square[n];
        if (n % 2 == 1)
            theta4_0 -= 2.0 * j.square[n];
        else
            theta4_0 += 2.0 * j.square[n];
        theta2_0 += j.oblong[n];
    }
    /* Factors of theta1/theta4, theta2/theta4, theta3/theta4 (DLMF 22.2.4-6); after the imaginary
     * transformation those of theta1/theta2, theta4/theta2, theta3/theta2. */
    if (j.kind == CIRCULAR) {
        j.sn = theta3_0 / theta2_0;
        j.cn = theta4_0 / theta2_0;
        j.dn = theta4_0 / theta3_0;
        theta_polynomials(&j);
    } else {
        j.sn = theta3_0 / theta4_0;
        j.cn = theta2_0 / theta4_0;
        j.dn = theta2_0 / theta3_0;
    }
    return j;
}

/* a[0] + a[1] x + a[2] x^2 + a[3] x^3. */
static inline double cubic(const double *restrict a, double x)
{
    return fma(x, fma(x, fma(x, a[3], a[2]), a[1]), a[0]);
}

/* sn = sn_0 theta1/theta4, cn = cn_0 theta2/theta4, dn = dn_0 theta3/theta4 at x = pi f
 * (DLMF 22.2.4-6). sn and cn have the sign (-1)^n of the period, which is in p->sn at entry. */
static inline void circular_series(const jacobi *restrict j, int count, jacobi_points *restrict p)
{
    for (int k = 0; k < count; k++) {
        double sine, cosine;
        sine_cosine_pi(p->f[k], &sine, &cosine);
        double square = sine * sine;
        double inverse_theta4 = 1.0 / cubic(j->theta[3], square);
        double sign = p->sn[k];
        p->sn[k] = sign * sine * cubic(j->theta[0], square) * inverse_theta4;
        p->cn[k] = sign * cosine * cubic(j->theta[1], square) * inverse_theta4;
        p->dn[k] = cubic(j->theta[2], square) * inverse_theta4;
        p->first[k] = fma(-2.0, square, 1.0);
        p->second[k] = 2.0 * sine * cosine;
    }
}

/* The same of m1 at i u (DLMF 22.6.1): sn(u|m) = -i sc(iu|m1), cn = nc, dn = dc, theta functions of
 * an imaginary argument (20.2.1-4). With the nome q, xi = pi K f/K' and |f| <= 1/2, every
 * exponential is scaled to be at most 1:
 *
 *   decay = exp(-|xi|),   growth = sqrt(q) exp(|xi|),   low = decay^2,   high = growth^2,
 *   theta1 = sum (-1)^n (q^(n^2) high^n - q^(n(n+1)) low^(n+1)),
 *   theta2 = sum (q^(n^2) high^n + q^(n(n+1)) low^(n+1)),
 *   theta3 = sum (q^(n^2) low^n + q^(n(n+1)) high^(n+1)),
 *   theta4 = sum (-1)^n (q^(n^2) low^n - q^(n(n+1)) high^(n+1)).
 *
 * theta3 and theta4 are the theta functions at i xi; theta1, but for its factor i, and theta2 are
 * theirs over q^(1/4) exp(|xi|). Hence sn = sn_0 theta1/theta2, cn = cn_0 2 decay theta4/theta2 and
 * dn = dn_0 2 decay theta3/theta2. */
static inline void hyperbolic_series(const jacobi *restrict j, int count, jacobi_points *restrict p)
{
    double root = exp(0.5 * j->log_nome);
    for (int k = 0; k < count; k++) {
        double decay = exponential(j->log_nome * fabs(p->f[k]));
        double growth = root / decay;
        double low = decay * decay;
        double high = growth * growth;
        double low2 = low * low;
        double high2 = high * high;
        double sign = p->sn[k];
        /* The sums over even and over odd n, for n = 0 .. 3. */
        double even_high = fma(high2, j->square[2], 1.0);
        double odd_high = high * fma(high2, j->square[3], j->square[1]);
        double even_low = fma(low2, j->square[2], 1.0);
        double odd_low = low * fma(low2, j->square[3], j->square[1]);
        double more_low = low * fma(low2, j->oblong[2], 1.0);
        double less_low = low2 * fma(low2, j->oblong[3], j->oblong[1]);
        double more_high = high * fma(high2, j->oblong[2], 1.0);
        double less_high = high2 * fma(high2, j->oblong[3], j->oblong[1]);
        double theta1 = (even_high - more_low) + (less_low - odd_high);
        double theta2 = (even_high + more_low) + (odd_high + less_low);
        double theta3 = (even_low + more_high) + (odd_low + less_high);
        double theta4 = (even_low - more_high) + (less_high - odd_low);
        /* sn has the sign of f; sn and cn have in addition the sign (-1)^n of the half periods. */
        double inverse_theta2 = 1.0 / theta2;
        double twice = 2.0 * decay * inverse_theta2;
        p->sn[k] = copysign(j->sn * theta1 * inverse_theta2, p->f[k]) * sign;
        p->cn[k] = j->cn * theta4 * twice * sign;
        p->dn[k] = j->dn * theta3 * twice;
        p->first[k] = decay;
        p->second[k] = growth;
    }
}

/* sn, cn, dn at u = start + rate (t - t0) for count <= BLOCK times t [s], with absolute errors of a
 * few ulp of 1 however large u is; `phase` counts u in 2K, on the separatrix in 1. */
static inline void jacobi_at(const jacobi *restrict j, turns phase, double t0, int count,
                             const double *restrict t, jacobi_points *restrict p)
{
    /* m = 1: sn = tanh u, cn = dn = sech u, u = start + rate (t - t0) (DLMF, table 22.5.4). */
    if (j->kind == SEPARATRIX) {
        for (int k = 0; k < count; k++) {
            p->f[k] = dd_add(phase.start, dd_mul(phase.rate, two_sum(t[k], -t0))).hi;
            p->sn[k] = tanh(p->f[k]);
            p->cn[k] = 1.0 / cosh(p->f[k]);
            p->dn[k] = p->cn[k];
        }
        return;
    }
    for (int k = 0; k < count; k++)
        p->f[k] = fraction(phase, two_sum(t[k], -t0), &p->sn[k]);
    if (j->kind == CIRCULAR)
        circular_series(j, count, p);
    else
        hyperbolic_series(j, count, p);
}

/* The phase u = rate t + start in periods of sn: in 2K, on the separatrix in 1. */
static inline turns jacobi_turns(const jacobi *j, dd rate, dd start)
{
    dd period = dd_scale(j->quarter, 2.0);
    if (j->kind == SEPARATRIX) /* sn is not periodic */
        period = dd_of(1.0);
    return (turns){dd_div(rate, period), dd_div(start, period)};
}

/* The u in (-2K, 2K] with these sn, cn, dn (dn > 0): |sn| R_F(cn^2, dn^2, 1) in the first quarter
 * (DLMF 22.15, 19.25), measured from K, by K - cd-1, where that is nearer; continued by symmetry.
 * On the separatrix sn = tanh u, so that sinh u = sn/cn. */
static inline dd jacobi_inverse(const jacobi *j, dd sn, dd cn, dd dn)
{
    dd one = dd_of(1.0);
    dd kc = dd_sqrt(j->m1);
    dd u;
    if (j->kind == SEPARATRIX)
        return dd_of(copysign(asinh(fabs(sn.hi) / fmax(fabs(cn.hi), dn.hi)), sn.hi));
    /* The first half of the quarter period ends at sn^2 = 1/(1 + sqrt(m1)). */
    if ((1.0 + kc.hi) * sn.hi * sn.hi <= 1.0) {
        u = dd_mul(dd_abs(sn), carlson_rf(dd_square(cn), dd_square(dn), one));
    } else {
        /* K - u has the functions sn(K - u) = cn/dn, cn = sqrt(m1) sn/dn, dn = sqrt(m1)/dn
         * (DLMF, table 22.4.3). */
        dd ratio = dd_div(kc, dn);
        dd s = dd_div(dd_abs(cn), dn);
        u = dd_sub(j->quarter,
                   dd_mul(s, carlson_rf(dd_square(dd_mul(sn, ratio)), dd_square(ratio), one)));
    }
    /* sn(2K - u) = sn u and cn(2K - u) = -cn u; sn is odd (DLMF 22.4). */
    if (cn.hi < 0.0)
        u = dd_sub(dd_scale(j->quarter, 2.0), u);
    if (sn.hi < 0.0)
        return dd_neg(u);
    return u;
}

#endif

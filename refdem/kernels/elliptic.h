/* Elliptic integrals and Jacobi functions: double-double where phases are made, theta series in binary64 where they are used.
 *
 * Complete integrals: arithmetic-geometric mean (DLMF 19.8.5) and Bulirsch's cel (Numer. Math. 13 (1969) 305).
 * Incomplete ones: Carlson's duplication (DLMF 19.36.1). Functions: theta series (DLMF 20.2, 22.2), after Jacobi's imaginary
 * transformation (DLMF 22.6.1) where m > 1/2, so that the nome never exceeds exp(-pi).
 */
#ifndef REFDEM_ELLIPTIC_H
#define REFDEM_ELLIPTIC_H

#include "double_double.h"

/* K(m) = (pi/2) / agm(1, sqrt(1 - m)) for the complementary parameter m1 = 1 - m > 0. */
static inline dd quarter_period(dd m1)
{
    dd a = dd_of(1.0), b = dd_sqrt(m1);
    for (int i = 0; i < 40 && fabs(a.hi - b.hi) > 1e-17 * a.hi; i++) {
        dd mean = dd_scale(dd_add(a, b), 0.5);
        b = dd_sqrt(dd_mul(a, b));
        a = mean;
    }
    return dd_div(DD_PI, dd_add(a, b));
}

/* Bulirsch: integral over 0..pi/2 of dx / ((cos^2 + p sin^2) sqrt(cos^2 + m1 sin^2)), p > 0, m1 > 0. */
static inline dd complete_third(dd m1, dd p)
{
    dd kc = dd_sqrt(m1), e = kc, m = dd_of(1.0), a = dd_of(1.0), b;
    p = dd_sqrt(p);
    b = dd_div(dd_of(1.0), p);
    for (int i = 0;; i++) {
        dd f = a, g = dd_div(e, p);
        a = dd_add(a, dd_div(b, p));
        b = dd_scale(dd_add(b, dd_mul(f, g)), 2.0);
        p = dd_add(g, p);
        g = m;
        m = dd_add(kc, m);
        if (i == 40 || fabs(dd_sub(g, kc).hi) <= 1e-16 * g.hi)
            return dd_div(dd_mul(dd_scale(DD_PI, 0.5), dd_add(b, dd_mul(a, m))), dd_mul(m, dd_add(m, p)));
        kc = dd_scale(dd_sqrt(e), 2.0);
        e = dd_mul(kc, m);
    }
}

/* Carlson's R_F(x, y, z), at most one of them zero. */
static inline dd carlson_rf(dd x, dd y, dd z)
{
    dd mean, dx, dy, dz;
    for (int i = 0;; i++) {
        mean = dd_div(dd_add(dd_add(x, y), z), dd_of(3.0));
        dx = dd_sub(mean, x), dy = dd_sub(mean, y), dz = dd_sub(mean, z);
        if (i == 60 || fmax(fabs(dx.hi), fmax(fabs(dy.hi), fabs(dz.hi))) < 1e-6 * mean.hi)
            break;
        dd sx = dd_sqrt(x), sy = dd_sqrt(y), sz = dd_sqrt(z);
        dd shift = dd_add(dd_mul(sx, dd_add(sy, sz)), dd_mul(sy, sz));
        x = dd_scale(dd_add(x, shift), 0.25);
        y = dd_scale(dd_add(y, shift), 0.25);
        z = dd_scale(dd_add(z, shift), 0.25);
    }
    dx = dd_div(dx, mean), dy = dd_div(dy, mean), dz = dd_div(dz, mean);
    dd e2 = dd_sub(dd_mul(dx, dy), dd_square(dz)), e3 = dd_mul(dx, dd_mul(dy, dz));
    dd sum = dd_sub(dd_of(1.0), dd_div(e2, dd_of(10.0)));
    sum = dd_add(sum, dd_div(e3, dd_of(14.0)));
    sum = dd_add(sum, dd_div(dd_square(e2), dd_of(24.0)));
    sum = dd_sub(sum, dd_div(dd_scale(dd_mul(e2, e3), 3.0), dd_of(44.0)));
    return dd_div(sum, dd_sqrt(mean));
}

/* The angle (-pi, pi] [rad] whose sine and cosine these are: s R_F(c^2, 1, 1) and its continuation. */
static inline dd angle_of(dd s, dd c)
{
    dd one = dd_of(1.0), size = dd_sqrt(dd_add(dd_square(s), dd_square(c)));
    if (size.hi == 0.0)
        return dd_of(0.0);
    s = dd_div(s, size), c = dd_div(c, size);
    dd acute = fabs(s.hi) < fabs(c.hi) ? dd_mul(dd_abs(s), carlson_rf(dd_square(c), one, one))
                                       : dd_sub(dd_scale(DD_PI, 0.5), dd_mul(dd_abs(c), carlson_rf(dd_square(s), one, one)));
    if (c.hi < 0.0)
        acute = dd_sub(DD_PI, acute);
    return s.hi < 0.0 ? dd_neg(acute) : acute;
}

/* What the Jacobi functions of one parameter need. Circular series for m <= 1/2, hyperbolic for m > 1/2, tanh and sech at 1. */
enum { CIRCULAR, HYPERBOLIC, SEPARATRIX };
enum { TERMS = 5 };

typedef struct {
    int kind;
    dd m1, quarter, other; /* 1 - m, K(m), K(1 - m) */
    double log_nome;       /* of the nome that is used */
    double square[TERMS];  /* nome^(n^2) */
    double oblong[TERMS];  /* nome^(n (n + 1)) */
    double sn, cn, dn;     /* factors */
} jacobi;

/* A point u: reduced to -K..K, with what the series there have in common. */
typedef struct {
    double u, sn, cn, dn;
    double c, s;           /* circular: cos and sin of pi u / K */
    double decay, growth;  /* hyperbolic: exp(-|xi|) and nome exp(2 |xi|), xi = pi u / (2 K') */
} jacobi_point;

static inline jacobi jacobi_prepared(dd m, dd m1)
{
    jacobi j = {.kind = SEPARATRIX, .m1 = m1};
    if (m1.hi <= 0.0)
        return j;
    j.quarter = quarter_period(m1);
    j.other = m.hi > 0.0 ? quarter_period(m) : dd_of(INFINITY);
    j.kind = m.hi <= 0.5 ? CIRCULAR : HYPERBOLIC;
    double ratio = j.kind == CIRCULAR ? j.other.hi / j.quarter.hi : j.quarter.hi / j.other.hi;
    j.log_nome = -DD_PI.hi * ratio;
    double plus = 1.0, minus = 1.0, twos = 0.0;
    for (int n = 0; n < TERMS; n++) {
        j.square[n] = n ? exp(j.log_nome * n * n) : 1.0;
        j.oblong[n] = n ? exp(j.log_nome * n * (n + 1)) : 1.0;
        plus += n ? 2.0 * j.square[n] : 0.0;
        minus += n ? (n % 2 ? -2.0 : 2.0) * j.square[n] : 0.0;
        twos += j.oblong[n];
    }
    j.sn = j.kind == CIRCULAR ? plus / twos : plus / minus;
    j.cn = j.kind == CIRCULAR ? minus / twos : twos / minus;
    j.dn = j.kind == CIRCULAR ? minus / plus : twos / plus;
    return j;
}

/* DLMF 22.2.4-6 with 20.2.1-4. */
static inline void circular_series(const jacobi *j, jacobi_point *p)
{
    double x = 0.5 * DD_PI.hi * (p->u / j->quarter.hi), c1 = cos(x), s1 = sin(x);
    p->c = 1.0 - 2.0 * s1 * s1, p->s = 2.0 * s1 * c1;
    double one = 0.0, two = 0.0, three = 1.0, four = 1.0, c = c1, s = s1, ce = 1.0, se = 0.0;
    for (int n = 0; n < TERMS; n++) {
        double sign = n % 2 ? -1.0 : 1.0, next;
        one += sign * j->oblong[n] * s;
        two += j->oblong[n] * c;
        three += n ? 2.0 * j->square[n] * ce : 0.0;
        four += n ? sign * 2.0 * j->square[n] * ce : 0.0;
        next = c * p->c - s * p->s, s = s * p->c + c * p->s, c = next;
        next = ce * p->c - se * p->s, se = se * p->c + ce * p->s, ce = next;
    }
    p->sn = j->sn * one / four, p->cn = j->cn * two / four, p->dn = j->dn * three / four;
}

/* The same of m1 at i u (DLMF 22.6.1): sn = -i sc(iu|m1), cn = nc, dn = dc; every exponential is scaled to be at most 1. */
static inline void hyperbolic_series(const jacobi *j, jacobi_point *p)
{
    double size = 0.5 * DD_PI.hi * fabs(p->u) / j->other.hi;
    p->decay = exp(-size);
    p->growth = exp(2.0 * size + j->log_nome);
    double square = p->decay * p->decay, up = 1.0, down = 1.0;
    double one = 0.0, two = 0.0, three = 1.0, four = 1.0;
    for (int n = 0; n < TERMS; n++) {
        double sign = n % 2 ? -1.0 : 1.0, rise = up * j->square[n], fall = j->oblong[n] * down * square;
        if (n) {
            double even = up * j->oblong[n - 1] + j->square[n] * down;
            three += even, four += sign * even;
        }
        one += sign * (rise - fall), two += rise + fall;
        up *= p->growth, down *= square;
    }
    p->sn = copysign(j->sn * one / two, p->u);
    p->cn = j->cn * four * 2.0 * p->decay / two;
    p->dn = j->dn * three * 2.0 * p->decay / two;
}

/* sn, cn, dn at u, absolute errors a few ulp of 1 however large u is. */
static inline jacobi_point jacobi_at(const jacobi *j, dd u)
{
    jacobi_point p = {.u = u.hi};
    if (j->kind == SEPARATRIX) {
        p.sn = tanh(u.hi);
        p.cn = p.dn = 1.0 / cosh(u.hi);
        return p;
    }
    int odd;
    p.u = dd_round(dd_reduced(u, dd_scale(j->quarter, 2.0), &odd));
    if (j->kind == CIRCULAR)
        circular_series(j, &p);
    else
        hyperbolic_series(j, &p);
    if (odd)
        p.sn = -p.sn, p.cn = -p.cn;
    return p;
}

/* The u in (-2K, 2K] with these sn, cn, dn (dn > 0): sn R_F(cn^2, dn^2, 1), measured from K where that is nearer. */
static inline dd jacobi_inverse(const jacobi *j, dd sn, dd cn, dd dn)
{
    dd one = dd_of(1.0), kc = dd_sqrt(j->m1), u;
    if (j->kind == SEPARATRIX)
        return dd_of(copysign(asinh(fabs(sn.hi) / fmax(fabs(cn.hi), dn.hi)), sn.hi));
    if ((1.0 + kc.hi) * sn.hi * sn.hi <= 1.0) {
        u = dd_mul(dd_abs(sn), carlson_rf(dd_square(cn), dd_square(dn), one));
    } else {
        dd ratio = dd_div(kc, dn), s = dd_div(dd_abs(cn), dn);
        u = dd_sub(j->quarter, dd_mul(s, carlson_rf(dd_square(dd_mul(sn, ratio)), dd_square(ratio), one)));
    }
    if (cn.hi < 0.0)
        u = dd_sub(dd_scale(j->quarter, 2.0), u);
    return sn.hi < 0.0 ? dd_neg(u) : u;
}

#endif

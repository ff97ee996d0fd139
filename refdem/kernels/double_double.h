/* Double-double arithmetic: an unevaluated sum hi + lo of two doubles, some 32 digits (Dekker 1971;
 * Knuth, TAOCP 4.2.2).
 *
 * A phase that grows with time is kept in double-double, reduced by a period known to the same
 * precision, and only then rounded: the error of functions of it does not grow with time.
 */
#ifndef REFDEM_DOUBLE_DOUBLE_H
#define REFDEM_DOUBLE_DOUBLE_H

#include <math.h>

typedef struct {
    double hi, lo;
} dd;

static const dd DD_PI = {3.141592653589793116, 1.2246467991473532e-16};

static inline dd dd_of(double a)
{
    return (dd){a, 0.0};
}

/* a + b = hi + lo exactly (Knuth). */
static inline dd two_sum(double a, double b)
{
    double s = a + b;
    double v = s - a;
    return (dd){s, (a - (s - v)) + (b - v)};
}

/* The same for |a| >= |b| (Dekker). */
static inline dd quick_two_sum(double a, double b)
{
    double s = a + b;
    return (dd){s, b - (s - a)};
}

/* a b = hi + lo exactly, since fma rounds only once. */
static inline dd two_product(double a, double b)
{
    double p = a * b;
    return (dd){p, fma(a, b, -p)};
}

/* a + b within 3 u^2 of the sum, relatively (Joldes, Muller and Popescu 2017, algorithm 6). */
static inline dd dd_add(dd a, dd b)
{
    dd s = two_sum(a.hi, b.hi);
    dd t = two_sum(a.lo, b.lo);
    s = quick_two_sum(s.hi, s.lo + t.hi);
    return quick_two_sum(s.hi, s.lo + t.lo);
}

static inline dd dd_neg(dd a)
{
    return (dd){-a.hi, -a.lo};
}

static inline dd dd_sub(dd a, dd b)
{
    return dd_add(a, dd_neg(b));
}

/* a b without the product of the low parts: a_hi b_hi exactly, + a_hi b_lo + a_lo b_hi. */
static inline dd dd_mul(dd a, dd b)
{
    dd p = two_product(a.hi, b.hi);
    return quick_two_sum(p.hi, p.lo + fma(a.hi, b.lo, a.lo * b.hi));
}

/* a b for a double b: a_hi b exactly, + a_lo b. */
static inline dd dd_scale(dd a, double b)
{
    dd p = two_product(a.hi, b);
    return quick_two_sum(p.hi, fma(a.lo, b, p.lo));
}

/* a/b as the sum of three quotients of leading parts, each of the remainder: q_1 = a_hi/b_hi,
 * q_2 = (a - b q_1)_hi/b_hi, q_3 alike. */
static inline dd dd_div(dd a, dd b)
{
    double first = a.hi / b.hi;
    dd rest = dd_sub(a, dd_scale(b, first));
    double second = rest.hi / b.hi;
    rest = dd_sub(rest, dd_scale(b, second));
    dd q = quick_two_sum(first, second);
    return dd_add(q, dd_of(rest.hi / b.hi));
}

/* Two Newton steps r += (a - r^2)/(2 r) from the rounded root; 0 for a <= 0. */
static inline dd dd_sqrt(dd a)
{
    if (a.hi <= 0.0)
        return dd_of(0.0);
    double root = sqrt(a.hi);
    /* rest = a - r^2, before each of the two steps. */
    dd rest = dd_sub(a, two_product(root, root));
    dd first = quick_two_sum(root, rest.hi / (2.0 * root));
    rest = dd_sub(a, dd_mul(first, first));
    return dd_add(first, dd_of(rest.hi / (2.0 * root)));
}

static inline dd dd_square(dd a)
{
    return dd_mul(a, a);
}

static inline dd dd_abs(dd a)
{
    if (a.hi < 0.0)
        return dd_neg(a);
    return a;
}

static inline dd dd_dot(const dd *restrict a, const dd *restrict b)
{
    return dd_add(dd_add(dd_mul(a[0], b[0]), dd_mul(a[1], b[1])), dd_mul(a[2], b[2]));
}

static inline double dd_round(dd a)
{
    return a.hi + a.lo;
}

/* a - n period in [-period/2, period/2], n the whole number nearest to a/period, and n modulo 2 in
 * `odd`. */
static inline dd dd_reduced(dd a, dd period, int *odd)
{
    double n = nearbyint(a.hi / period.hi);
    *odd = fmod(n, 2.0) != 0.0;
    return dd_sub(a, dd_scale(period, n));
}

/* cos and sin of an angle [rad] of any size, to an ulp or two: reduced by 2 pi to hi + lo, then
 * cos(hi + lo) = cos hi - lo sin hi, sin(hi + lo) = sin hi + lo cos hi. */
static inline void turned(dd angle, double *restrict c, double *restrict s)
{
    int odd;
    dd x = dd_reduced(angle, dd_add(DD_PI, DD_PI), &odd);
    double c0 = cos(x.hi);
    double s0 = sin(x.hi);
    *c = fma(-x.lo, s0, c0);
    *s = fma(x.lo, c0, s0);
}

#endif

/* m x'' + k |x|^n sgn x = 0 in closed form, n >= 1, by incomplete beta functions and their inverse.
 *
 * With the amplitude A, p = n + 1, y = x/A and w = -v/u, u = sqrt(2 k/(m p)) A^(p/2), the energy is
 * y^p + w^2 = 1. The time in units of A/u is
 *   from the centre          q(y) = y 2F1(1/2, 1/p; 1 + 1/p; y^p),
 *   from the turning point   s(w) = (2/p) w 2F1(1/2, 1 - 1/p; 3/2; w^2),
 * each used up to y^p = w^2 = 1/2, where both meet: a quarter of the period is their sum there
 * (DLMF 8.17.7).
 */
#include <assert.h>

#include "double_double.h"
#include "kernels.h"

enum { TERMS = 120 }; /* terms of a series: 2^-120 is beyond double-double */

typedef struct {
    double p, inverse_p;     /* n + 1, 1/p */
    double amplitude, speed; /* A [m], u [m/s] */
    dd rate;                 /* u/A [1/s] */
    dd quarter,
        start;   /* a quarter of the period; phase of the start since the turning point, in A/u */
    double turn; /* s(sqrt(1/2)) */
} power_law;

/* 2F1(a, b; b + 1; z) = sum over i of (a)_i/i! b/(b + i) z^i, for z <= 1/2. */
static dd hypergeometric(double a, dd b, double z)
{
    dd sum = dd_of(1.0);
    dd factor = dd_of(1.0);
    for (int i = 0; i < TERMS && factor.hi > 1e-34; i++) {
        factor = dd_scale(dd_scale(factor, z), (a + i) / (1.0 + i));
        sum = dd_add(sum, dd_div(dd_mul(factor, b), dd_add(b, dd_of(i + 1.0))));
    }
    return sum;
}

/* q(y). */
static dd from_centre(const power_law *b, double y)
{
    dd share = dd_div(dd_of(1.0), dd_of(b->p));
    return dd_scale(hypergeometric(0.5, share, pow(fabs(y), b->p)), y);
}

/* s(w) = (2/p) w sum over i of (1 - 1/p)_i/i! w^(2i)/(2i + 1), with (1/2)_i/(3/2)_i = 1/(2i + 1).
 * 1 - 1/p is not a double, so that the factors are computed in double-double. */
static dd from_turning(const power_law *b, double w)
{
    dd share = dd_div(dd_of(b->p - 1.0), dd_of(b->p));
    dd sum = dd_of(1.0);
    dd factor = dd_of(1.0);
    double z = w * w;
    for (int i = 0; i < TERMS && factor.hi > 1e-34; i++) {
        factor = dd_div(dd_mul(dd_scale(factor, z), dd_add(share, dd_of(i))), dd_of(1.0 + i));
        sum = dd_add(sum, dd_div(factor, dd_of(2.0 * i + 3.0)));
    }
    return dd_scale(dd_div(dd_scale(sum, 2.0), dd_of(b->p)), w);
}

/* y with q(y) = q, by Newton's rule; dq/dy = 1/sqrt(1 - y^p) >= 1. */
static double centre_inverse(const power_law *b, double q)
{
    double y = q;
    for (int i = 0; i < 60; i++) {
        double change = (q - from_centre(b, y).hi) * sqrt(1.0 - pow(fabs(y), b->p));
        y += change;
        if (fabs(change) <= 0x1p-53 * fabs(y))
            break;
    }
    return y;
}

/* w with s(w) = s, by Newton's rule, |w| <= sqrt(1/2) < 0.8; ds/dw = (2/p) (1 - w^2)^(1/p - 1). */
static double turning_inverse(const power_law *b, double s)
{
    double w = 0.0;
    for (int i = 0; i < 60; i++) {
        double change
            = (s - from_turning(b, w).hi) * 0.5 * b->p * pow(1.0 - w * w, 1.0 - b->inverse_p);
        w = fmax(-0.8, fmin(0.8, w + change));
        if (fabs(change) <= 0x1p-53 * fabs(w))
            break;
    }
    return w;
}

/* The phase of (y, w) in units of A/u, 0 at the turning point y = 1. */
static dd phase(const power_law *b, double y, double w)
{
    if (w * w <= 0.5) { /* nearer to a turning point */
        if (y < 0.0)    /* from the other turning point */
            return dd_add(dd_scale(b->quarter, 2.0), from_turning(b, -w));
        return from_turning(b, w);
    }
    dd left = dd_sub(b->quarter, from_centre(b, y));
    if (w < 0.0)
        return dd_neg(left);
    return left;
}

/* The motion with the state x, v [m, m/s]. A^p = |x|^p + (v/speed)^2, with the larger of both sizes
 * factored out, so that no power overflows. */
static power_law prepare(double mass, double stiffness, double exponent, double x, double v)
{
    power_law b = {.p = exponent + 1.0, .inverse_p = 1.0 / (exponent + 1.0)};
    /* y^p = w^2 = 1/2 at y = 2^(-1/p); the quarter is q(y) + s(sqrt(1/2)) there. */
    double y_middle = exp2(-b.inverse_p);
    double speed = sqrt(2.0 * stiffness / (mass * b.p));
    b.turn = from_turning(&b, sqrt(0.5)).hi;
    b.quarter = dd_add(from_centre(&b, y_middle), from_turning(&b, sqrt(0.5)));
    double size = fmax(fabs(x), pow(fabs(v) / speed, 2.0 * b.inverse_p));
    double x_part = fabs(x) / size;
    double v_part = fabs(v) / speed / pow(size, 0.5 * b.p);
    b.amplitude = fabs(x); /* at rest it is at a turning point */
    if (v != 0.0)
        b.amplitude = size * pow(pow(x_part, b.p) + v_part * v_part, b.inverse_p);
    b.speed = speed * pow(b.amplitude, 0.5 * b.p);
    /* u/A = sqrt(2 k/(m p)) A^((n-1)/2) */
    dd unit = dd_sqrt(dd_div(dd_of(2.0 * stiffness), dd_mul(dd_of(mass), dd_of(b.p))));
    b.rate = dd_scale(unit, pow(b.amplitude, 0.5 * (exponent - 1.0)));
    b.start = phase(&b, x / b.amplitude, -v / b.speed);
    return b;
}

/* x [m] and v [m/s] at `since` [s] the start. The phase is reduced to the nearest turning point;
 * every other one is at -A. */
static void state_at(const power_law *b, dd since, double *restrict x, double *restrict v)
{
    int odd;
    dd s = dd_reduced(dd_add(b->start, dd_mul(b->rate, since)), dd_scale(b->quarter, 2.0), &odd);
    double y, w;
    double sign = 1.0;
    if (odd)
        sign = -1.0;
    /* x = +-A y, v = -+u w, with y^p + w^2 = 1 */
    if (fabs(s.hi) <= b->turn) {
        w = turning_inverse(b, dd_round(s));
        y = pow(1.0 - w * w, b->inverse_p);
    } else {
        y = centre_inverse(b, dd_round(dd_sub(b->quarter, dd_abs(s))));
        w = copysign(sqrt(1.0 - pow(fabs(y), b->p)), s.hi);
    }
    *x = sign * b->amplitude * y;
    *v = -sign * b->speed * w;
}

int refdem_power_oscillator(double mass, double stiffness, double exponent, double x0, double v0,
                            double t0, int64_t samples, const double *t, double *out)
{
    assert(samples == 0 || (t && out)); /* (samples, 2) doubles */
    if (x0 == 0.0 && v0 == 0.0) {       /* at rest in the centre, where it has no amplitude */
        for (int64_t i = 0; i < 2 * samples; i++)
            out[i] = 0.0;
        return 0;
    }
    power_law b = prepare(mass, stiffness, exponent, x0, v0);
    for (int64_t row = 0; row < samples; row++, out += 2) {
        out[0] = x0; /* the start as it was given */
        out[1] = v0;
        if (t[row] != t0)
            state_at(&b, two_sum(t[row], -t0), out, out + 1);
    }
    return 0;
}

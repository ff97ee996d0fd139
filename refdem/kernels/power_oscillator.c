/* m x'' + k |x|^n sgn x = 0 in closed form, n >= 1, by incomplete beta functions and their inverse.
 *
 * p = n + 1; y = x/A, w = -v/u, y^p + w^2 = 1 with u = sqrt(2 k/(m p)) A^(p/2); time in units of
 * A/u. From the centre q(y) = y 2F1(1/2, 1/p; 1 + 1/p; y^p),   from the turning point   s(w) =
 * (2/p) w 2F1(1/2, 1 - 1/p; 3/2; w^2), each used up to y^p = w^2 = 1/2, where both meet: a quarter
 * of the period is their sum there (DLMF 8.17.7).
 */
#include "double_double.h"
#include "kernels.h"

enum { MOST = 120 };

typedef struct {
    double p, rise; /* n + 1, 1/p */
    double reach, fastest;
    dd rate, quarter,
        start; /* 1/time unit; a quarter of the period and the phase of the start, in time units */
    double turn; /* s(sqrt(1/2)) */
} power_law;

/* 2F1(1/2, b; b + 1; z)-like sums: c_0 = 1 and c_(i+1)/c_i = (a + i)/(1 + i), each over (b + i)/b;
 * z <= 1/2. */
static dd hyper(double a, dd b, double z)
{
    dd sum = dd_of(1.0);
    dd factor = dd_of(1.0);
    for (int i = 0; i < MOST && factor.hi > 1e-34; i++) {
        factor = dd_scale(dd_scale(factor, z), (a + i) / (1.0 + i));
        sum = dd_add(sum, dd_div(dd_mul(factor, b), dd_add(b, dd_of(i + 1.0))));
    }
    return sum;
}

static dd from_centre(const power_law *b, double y)
{
    dd share = dd_div(dd_of(1.0), dd_of(b->p));
    return dd_scale(hyper(0.5, share, pow(fabs(y), b->p)), y);
}

/* (1 - 1/p)_i/i! is not a ratio of doubles: its factors are made in double-double. */
static dd from_turning(const power_law *b, double w)
{
    dd share = dd_div(dd_of(b->p - 1.0), dd_of(b->p));
    dd sum = dd_of(1.0);
    dd factor = dd_of(1.0);
    double z = w * w;
    for (int i = 0; i < MOST && factor.hi > 1e-34; i++) {
        factor = dd_div(dd_mul(dd_scale(factor, z), dd_add(share, dd_of(i))), dd_of(1.0 + i));
        sum = dd_add(sum, dd_div(factor, dd_of(2.0 * i + 3.0)));
    }
    return dd_scale(dd_div(dd_scale(sum, 2.0), dd_of(b->p)), w);
}

/* y with q(y) = q; dq/dy = 1/sqrt(1 - y^p) >= 1. */
static double centre_inverse(const power_law *b, double q)
{
    double y = q;
    for (int i = 0; i < 60; i++) {
        double by = (q - from_centre(b, y).hi) * sqrt(1.0 - pow(fabs(y), b->p));
        y += by;
        if (fabs(by) <= 0x1p-53 * fabs(y))
            break;
    }
    return y;
}

/* w with s(w) = s; ds/dw = (2/p) (1 - w^2)^(1/p - 1). */
static double turning_inverse(const power_law *b, double s)
{
    double w = 0.0;
    for (int i = 0; i < 60; i++) {
        double by = (s - from_turning(b, w).hi) * 0.5 * b->p * pow(1.0 - w * w, 1.0 - b->rise);
        w = fmax(-0.8, fmin(0.8, w + by));
        if (fabs(by) <= 0x1p-53 * fabs(w))
            break;
    }
    return w;
}

/* The phase of y, w, 0 at the turning point y = 1. */
static dd phase(const power_law *b, double y, double w)
{
    if (w * w <= 0.5) {
        if (y < 0.0) /* from the other turning point */
            return dd_add(dd_scale(b->quarter, 2.0), from_turning(b, -w));
        return from_turning(b, w);
    }
    dd left = dd_sub(b->quarter, from_centre(b, y));
    if (w < 0.0)
        return dd_neg(left);
    return left;
}

static power_law prepared(double mass, double stiffness, double exponent, double x, double v)
{
    power_law b = {.p = exponent + 1.0, .rise = 1.0 / (exponent + 1.0)};
    double middle = exp2(-b.rise);
    double speed = sqrt(2.0 * stiffness / (mass * b.p));
    b.turn = from_turning(&b, sqrt(0.5)).hi;
    b.quarter = dd_add(from_centre(&b, middle), from_turning(&b, sqrt(0.5)));
    double size = fmax(fabs(x), pow(fabs(v) / speed, 2.0 * b.rise));
    double a = fabs(x) / size;
    double c = fabs(v) / speed / pow(size, 0.5 * b.p);
    b.reach = fabs(x); /* at rest it is at a turning point */
    if (v != 0.0)
        b.reach = size * pow(pow(a, b.p) + c * c, b.rise);
    b.fastest = speed * pow(b.reach, 0.5 * b.p);
    dd unit = dd_sqrt(dd_div(dd_of(2.0 * stiffness), dd_mul(dd_of(mass), dd_of(b.p))));
    b.rate = dd_scale(unit, pow(b.reach, 0.5 * (exponent - 1.0)));
    b.start = phase(&b, x / b.reach, -v / b.fastest);
    return b;
}

static void at(const power_law *b, dd since, double *restrict x, double *restrict v)
{
    int odd;
    dd s = dd_reduced(dd_add(b->start, dd_mul(b->rate, since)), dd_scale(b->quarter, 2.0), &odd);
    double y, w;
    double side = 1.0;
    if (odd)
        side = -1.0;
    if (fabs(s.hi) <= b->turn) {
        w = turning_inverse(b, dd_round(s));
        y = pow(1.0 - w * w, b->rise);
    } else {
        y = centre_inverse(b, dd_round(dd_sub(b->quarter, dd_abs(s))));
        w = copysign(sqrt(1.0 - pow(fabs(y), b->p)), s.hi);
    }
    *x = side * b->reach * y;
    *v = -side * b->fastest * w;
}

int refdem_power_oscillator(double mass, double stiffness, double exponent, double x0, double v0,
                            double t0, int64_t samples, const double *t, double *out)
{
    if (x0 == 0.0 && v0 == 0.0) {
        for (int64_t i = 0; i < 2 * samples; i++)
            out[i] = 0.0;
        return 0;
    }
    power_law b = prepared(mass, stiffness, exponent, x0, v0);
    for (int64_t row = 0; row < samples; row++, out += 2) {
        out[0] = x0;
        out[1] = v0;
        if (t[row] != t0)
            at(&b, two_sum(t[row], -t0), out, out + 1);
    }
    return 0;
}

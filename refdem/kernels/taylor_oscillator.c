/* A point on a line under polynomial forces and periodic ones, by Taylor series of order 24 whose
 * step keeps them at round-off:
 *   m X'' = -(k X + q X^2 + c X^3) - (d + e (X + r)^2) X' + m g + sum F cos(w t + phase),
 * and the work done by the motion against damping and drives. Coefficients by the recurrences of
 * products (Jorba and Zou 2005, proposition 1). The phases of the drives are computed from the time
 * in double-double in every step. The state is summed in double-double (Knuth, TAOCP 4.2.2).
 * Samples are values of the series.
 */
#include <assert.h>

#include "double_double.h"
#include "kernels.h"

enum { ORDER = 24 };

typedef refdem_oscillator oscillator;

/* Series of X, X' and the work in the time since the start of the step. */
typedef struct {
    double x[ORDER + 2], v[ORDER + 1], work[ORDER + 2];
} series;

/* Coefficient n of the product a b (Cauchy). */
static double product(const double *restrict a, const double *restrict b, int n)
{
    double sum = 0.0;
    for (int i = 0; i <= n; i++)
        sum += a[i] * b[n - i];
    return sum;
}

/* Taylor coefficients F w^n/n! (cos, -sin, -cos, sin) [N] of all drives about t. */
static void expand_drives(const oscillator *p, dd t, double *restrict force)
{
    for (int n = 0; n <= ORDER; n++)
        force[n] = 0.0;
    for (int64_t k = 0; k < p->drives; k++) {
        double cosine, sine;
        double w = p->drive[3 * k + 1];
        double factor = p->drive[3 * k];
        turned(dd_add(dd_scale(t, w), dd_of(p->drive[3 * k + 2])), &cosine, &sine);
        double wave[4] = {cosine, -sine, -cosine, sine}; /* the cosine and its derivatives */
        for (int n = 0; n <= ORDER; n++) {
            force[n] += factor * wave[n % 4];
            factor *= w / (n + 1);
        }
    }
}

/* The series of the motion from (x, v) at t, and of the work, with pull = k X + q X^2 + c X^3 and
 * drag = (d + e (X + r)^2) v:
 *
 *   (n + 1) v_(n+1) = (m g - pull - drag + drive)_n/m,   (n + 1) work_(n+1) = ((drag - drive) v)_n.
 */
static void expand(const oscillator *p, dd t, double x, double v, series *restrict y)
{
    double force[ORDER + 1], x_squared[ORDER + 1], distance_squared[ORDER + 1], distance[ORDER + 1],
        drag_less_drive[ORDER + 1];
    expand_drives(p, t, force);
    y->x[0] = x;
    y->v[0] = v;
    y->work[0] = 0.0;
    for (int n = 0; n < ORDER; n++) {
        /* What is constant in time has a coefficient of order 0 only. */
        double offset = 0.0;
        double weight = 0.0;
        if (n == 0) {
            offset = p->offset;
            weight = p->weight;
        }
        distance[n] = y->x[n] + offset;
        x_squared[n] = product(y->x, y->x, n);
        double pull = p->linear * y->x[n] + p->quadratic * x_squared[n];
        double drag = p->damping * y->v[n];
        if (p->cubic != 0.0)
            pull += p->cubic * product(x_squared, y->x, n);
        if (p->van_der_pol != 0.0) {
            distance_squared[n] = product(distance, distance, n);
            drag += p->van_der_pol * product(distance_squared, y->v, n);
        }
        drag_less_drive[n] = drag - force[n];
        double rest = weight - pull;
        y->work[n + 1] = product(drag_less_drive, y->v, n) / (n + 1);
        y->x[n + 1] = y->v[n] / (n + 1);
        y->v[n + 1] = (rest - drag_less_drive[n]) / (p->mass * (n + 1));
    }
    y->x[ORDER + 1] = y->v[ORDER] / (ORDER + 1);
}

/* The factor by which a step h may grow for the last two terms of a series to stay at round-off,
 * 2^-57, of its largest of the first half: (2^-57 largest/tail)^(1/last). */
static double growth_factor(const double *restrict a, int last, double h)
{
    double largest = 0.0;
    double tail = 0.0;
    double power = 1.0;
    for (int n = 0; n <= last; n++, power *= h) {
        double size = fabs(a[n]) * power;
        if (n <= last / 2)
            largest = fmax(largest, size);
        if (n >= last - 1)
            tail += size;
    }
    if (tail > 0.0)
        return pow(0x1p-57 * largest / tail, 1.0 / last);
    return 2.0; /* the last two terms are 0: the step may grow at least by this factor */
}

/* A step [s] for all three series: a first guess, multiplied by 0.95 times the least growth factor
 * until this factor is between 1 and 1.25. */
static double step_size(const series *y, double first)
{
    double h = first;
    for (int tries = 0; tries < 8; tries++) {
        double factor = fmin(growth_factor(y->x, ORDER + 1, h),
                             fmin(growth_factor(y->v, ORDER, h), growth_factor(y->work, ORDER, h)));
        if (factor >= 1.0 && (factor < 1.25 || tries > 4)) /* allowed, and long enough */
            break;
        h *= fmin(fmax(0.95 * factor, 0.0625), 8.0);
    }
    return h;
}

/* Whether the last coefficients of all three series are numbers. */
static int last_are_finite(const series *y)
{
    return isfinite(y->x[ORDER + 1]) && isfinite(y->v[ORDER]) && isfinite(y->work[ORDER]);
}

/* a(h) - a(0) = sum over n >= 1 of a_n h^n, by Horner's rule. */
static double gained(const double *restrict a, int last, double h)
{
    double sum = 0.0;
    for (int n = last; n >= 1; n--)
        sum = (sum + a[n]) * h;
    return sum;
}

/* from + by in double-double, |by| small against from. */
static dd add_small(dd from, double by)
{
    dd sum = two_sum(from.hi, by);
    return quick_two_sum(sum.hi, sum.lo + from.lo);
}

/* The shortest time [s] of the motion over `span`, the first guess of a step. */
static double shortest_time(const oscillator *p, double span)
{
    double rate = sqrt(fabs(p->linear) / p->mass) + fabs(p->damping) / p->mass + 1.0 / fabs(span);
    for (int64_t k = 0; k < p->drives; k++)
        rate = fmax(rate, p->drive[3 * k + 1]);
    return 1.0 / rate;
}

int refdem_taylor_oscillator(const refdem_oscillator *p, double x0, double v0, double t0,
                             int64_t samples, const double *t, double *out)
{
    assert(p && (p->drives == 0 || p->drive)); /* (drives, 3) doubles */
    assert(samples >= 1 && t && out);          /* (samples), (samples, 3) doubles */
    series y;
    double span = t[samples - 1] - t0;
    double direction = 1.0;
    if (span < 0.0) /* backwards */
        direction = -1.0;
    if (span == 0.0) /* only the start is requested */
        span = 1.0;
    double h = shortest_time(p, span);
    dd x = dd_of(x0);
    dd v = dd_of(v0);
    dd work = dd_of(0.0);
    dd now = dd_of(t0);
    for (int64_t row = 0; row < samples;) {
        expand(p, now, x.hi, v.hi, &y);
        h = step_size(&y, h);
        /* Near infinity the steps shrink until the clock no longer moves, or the last coefficients,
         * which grow as distance^-ORDER, leave the range of binary64 before. */
        if (!(h > 1e-15 * fabs(span)) || !last_are_finite(&y))
            return (int)(row + 1);
        for (; row < samples; row++, out += 3) {
            double since = dd_round(dd_sub(dd_of(t[row]), now));
            if (since * direction > h)
                break;
            out[0] = dd_round(add_small(x, gained(y.x, ORDER + 1, since)));
            out[1] = dd_round(add_small(v, gained(y.v, ORDER, since)));
            out[2] = dd_round(add_small(work, gained(y.work, ORDER, since)));
        }
        /* Accept: the end of the step becomes the state. */
        x = add_small(x, gained(y.x, ORDER + 1, direction * h));
        v = add_small(v, gained(y.v, ORDER, direction * h));
        work = add_small(work, gained(y.work, ORDER, direction * h));
        now = dd_add(now, dd_of(direction * h));
    }
    return 0;
}

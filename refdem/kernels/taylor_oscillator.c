/* A point on a line under polynomial forces and periodic ones, by Taylor series of order 24 whose
 * step keeps them at round-off.
 *
 * m X'' = -(k X + q X^2 + c X^3) - (d + e (X + r)^2) X' + m g + sum F cos(w t + phase).
 * Coefficients by the recurrences of products (Jorba and Zou 2005, proposition 1); the phases of
 * the drives are kept in double-double and made anew in every step; what a step adds to the state
 * is summed with what rounding loses (Knuth, TAOCP 4.2.2). Samples are read off the series.
 */
#include "double_double.h"
#include "kernels.h"

enum { ORDER = 24 };

typedef refdem_oscillator oscillator;

typedef struct {
    double x[ORDER + 2], v[ORDER + 1], work[ORDER + 2];
} series;

static double product(const double *restrict a, const double *restrict b, int n)
{
    double sum = 0.0;
    for (int i = 0; i <= n; i++)
        sum += a[i] * b[n - i];
    return sum;
}

/* Taylor coefficients [N] of all drives about t. */
static void driven(const oscillator *p, dd t, double *restrict force)
{
    for (int n = 0; n <= ORDER; n++)
        force[n] = 0.0;
    for (int64_t k = 0; k < p->drives; k++) {
        double c, s;
        double w = p->drive[3 * k + 1];
        double factor = p->drive[3 * k];
        turned(dd_add(dd_scale(t, w), dd_of(p->drive[3 * k + 2])), &c, &s);
        double wave[4] = {c, -s, -c, s}; /* the cosine and its derivatives */
        for (int n = 0; n <= ORDER; n++) {
            force[n] += factor * wave[n % 4];
            factor *= w / (n + 1);
        }
    }
}

/* The series of the motion from (x, v) at t, and of the work done on what is outside: damping less
 * drives. */
static void expand(const oscillator *p, dd t, double x, double v, series *restrict y)
{
    double force[ORDER + 1], square[ORDER + 1], far[ORDER + 1], from[ORDER + 1], lost[ORDER + 1];
    driven(p, t, force);
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
        from[n] = y->x[n] + offset;
        square[n] = product(y->x, y->x, n);
        double pull = p->linear * y->x[n] + p->quadratic * square[n];
        double drag = p->damping * y->v[n];
        if (p->cubic != 0.0)
            pull += p->cubic * product(square, y->x, n);
        if (p->van_der_pol != 0.0) {
            far[n] = product(from, from, n);
            drag += p->van_der_pol * product(far, y->v, n);
        }
        lost[n] = drag - force[n];
        double rest = weight - pull;
        y->work[n + 1] = product(lost, y->v, n) / (n + 1);
        y->x[n + 1] = y->v[n] / (n + 1);
        y->v[n + 1] = (rest - lost[n]) / (p->mass * (n + 1));
    }
    y->x[ORDER + 1] = y->v[ORDER] / (ORDER + 1);
}

/* Largest factor by which a step h of one series may be longer for its last two terms to stay at
 * round-off of its largest. */
static double slack(const double *restrict a, int last, double h)
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
    return 2.0; /* the series has ended before: twice as far at least */
}

static double step_of(const series *y, double first)
{
    double h = first;
    for (int tries = 0; tries < 8; tries++) {
        double factor = fmin(slack(y->x, ORDER + 1, h),
                             fmin(slack(y->v, ORDER, h), slack(y->work, ORDER, h)));
        if (factor >= 1.0 && (factor < 1.25 || tries > 4))
            break;
        h *= fmin(fmax(0.95 * factor, 0.0625), 8.0);
    }
    return h;
}

/* sum over n >= 1 of a_n h^n. */
static double gained(const double *restrict a, int last, double h)
{
    double sum = 0.0;
    for (int n = last; n >= 1; n--)
        sum = (sum + a[n]) * h;
    return sum;
}

static dd grown(dd from, double by)
{
    dd sum = two_sum(from.hi, by);
    return quick_two_sum(sum.hi, sum.lo + from.lo);
}

/* The shortest time of the motion, to begin with. */
static double shortest(const oscillator *p, double span)
{
    double rate = sqrt(fabs(p->linear) / p->mass) + fabs(p->damping) / p->mass + 1.0 / fabs(span);
    for (int64_t k = 0; k < p->drives; k++)
        rate = fmax(rate, p->drive[3 * k + 1]);
    return 1.0 / rate;
}

int refdem_taylor_oscillator(const refdem_oscillator *p, double x0, double v0, double t0,
                             int64_t samples, const double *t, double *out)
{
    series y;
    double span = t[samples - 1] - t0;
    double side = 1.0;
    if (span < 0.0) /* backwards */
        side = -1.0;
    if (span == 0.0)
        span = 1.0;
    double h = shortest(p, span);
    dd x = dd_of(x0);
    dd v = dd_of(v0);
    dd work = dd_of(0.0);
    dd now = dd_of(t0);
    for (int64_t row = 0; row < samples;) {
        expand(p, now, x.hi, v.hi, &y);
        h = step_of(&y, h);
        if (!(h > 1e-15 * fabs(span)) && span != 0.0)
            return (int)(row + 1);
        for (; row < samples; row++, out += 3) {
            double since = dd_round(dd_sub(dd_of(t[row]), now));
            if (since * side > h)
                break;
            out[0] = dd_round(grown(x, gained(y.x, ORDER + 1, since)));
            out[1] = dd_round(grown(v, gained(y.v, ORDER, since)));
            out[2] = dd_round(grown(work, gained(y.work, ORDER, since)));
        }
        x = grown(x, gained(y.x, ORDER + 1, side * h));
        v = grown(v, gained(y.v, ORDER, side * h));
        work = grown(work, gained(y.work, ORDER, side * h));
        now = dd_add(now, dd_of(side * h));
    }
    return 0;
}

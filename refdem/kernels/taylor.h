/* Integration of y' = f(y, t) by Taylor series of order TERMS from recurrences, with steps from
 * their last coefficients.
 *
 * Jorba and Zou, Experimental Mathematics 14 (2005) 99: the radius of convergence is taken from the
 * last two coefficients and the step is radius / e^2, so that what is cut off is e^-(2 TERMS),
 * below an ulp. Samples inside a step come from its polynomial; the state is kept as hi + lo, so
 * that rounding does not pile up with the steps.
 */
#ifndef REFDEM_TAYLOR_H
#define REFDEM_TAYLOR_H

#include "double_double.h"

enum { TERMS = 20 };
typedef double series[TERMS + 1];

static const double STEP_PART = 0.1353352832366127; /* exp(-2) */
static const double SHORTEST
    = 1e-12; /* of the time to the next sample: the motion has run into a singularity */

/* Fills y[i][1 ..] from y[i][0] at a time; scale[i] > 0 is the size against which y[i] counts for
 * the step, 0 not at all. */
typedef void (*expansion)(const void *system, dd time, series *y, double *scale);

static inline double cauchy(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int k = 0; k <= n; k++)
        sum += a[k] * b[n - k];
    return sum;
}

/* sum over k >= 1: the part of a product's coefficient in which the first factor is not the leading
 * one. */
static inline double cauchy_rest(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int k = 1; k <= n; k++)
        sum += a[k] * b[n - k];
    return sum;
}

/* Coefficient n of sine and cosine of an angle whose rate is known to n - 1: s' = c w, c' = -s w.
 */
static inline void sine_cosine(const double *angle, const double *rate, double *s, double *c, int n)
{
    if (n == 0) {
        s[0] = sin(angle[0]);
        c[0] = cos(angle[0]);
        return;
    }
    s[n] = cauchy(rate, c, n - 1) / n;
    c[n] = -cauchy(rate, s, n - 1) / n;
}

static inline double taylor_step(int n, series *y, const double *scale)
{
    double radius = INFINITY;
    for (int k = TERMS - 1; k <= TERMS; k++) {
        double worst = 0.0;
        for (int i = 0; i < n; i++)
            if (scale[i] > 0.0)
                worst = fmax(worst, fabs(y[i][k]) / scale[i]);
        if (worst > 0.0)
            radius = fmin(radius, pow(worst, -1.0 / k));
    }
    return radius * STEP_PART;
}

/* y(h) - y(0) of one coordinate. */
static inline double gained(const double *y, double h)
{
    double sum = y[TERMS];
    for (int k = TERMS - 1; k >= 1; k--)
        sum = sum * h + y[k];
    return sum * h;
}

/* States (samples, n) at times t [s], t[0] being the start in row 0, of either direction. Returns
 * 0, or the sample not reached. */
static inline int taylor_run(expansion expand, const void *system, int n, series *y,
                             int64_t samples, const double *t, double *out)
{
    double low[64] = {0.0};
    double scale[64];
    dd now = dd_of(t[0]);
    double reach = 0.0;
    double sense = 1.0;
    if (t[samples - 1] < t[0]) /* backwards */
        sense = -1.0;
    for (int i = 0; i < n; i++)
        y[i][0] = out[i];
    for (int64_t k = 1; k < samples; k++) {
        double left = dd_round(dd_sub(dd_of(t[k]), now)) * sense;
        double least = SHORTEST * fabs(t[k] - t[k - 1]);
        while (left > reach || reach == 0.0) {
            if (reach > 0.0) {
                for (int i = 0; i < n; i++) {
                    dd sum = two_sum(y[i][0], low[i] + gained(y[i], sense * reach));
                    y[i][0] = sum.hi;
                    low[i] = sum.lo;
                }
                now = dd_add(now, dd_of(sense * reach));
                left = dd_round(dd_sub(dd_of(t[k]), now)) * sense;
            }
            expand(system, now, y, scale);
            reach = taylor_step(n, y, scale);
            if (!(reach > least))
                return (int)k + 1;
        }
        for (int i = 0; i < n; i++)
            out[k * n + i] = y[i][0] + (low[i] + gained(y[i], sense * left));
    }
    return 0;
}

#endif

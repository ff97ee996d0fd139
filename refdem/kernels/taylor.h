/* Integration of y' = f(y, t) by Taylor series of order TERMS from recurrences, with steps from
 * their last coefficients (Jorba and Zou, Experimental Mathematics 14 (2005) 99).
 *
 * The radius of convergence is estimated as rho = min over the last two orders k of
 * |y_k/scale|^(-1/k), and the step is rho/e^2, so that what is cut off is e^-(2 TERMS), below an
 * ulp. Samples inside a step come from its polynomial; the state is kept as hi + lo, so that
 * rounding errors do not accumulate. A kernel supplies the recurrence, `expand`.
 */
#ifndef REFDEM_TAYLOR_H
#define REFDEM_TAYLOR_H

#include <assert.h>

#include "double_double.h"

enum { TERMS = 20 };
typedef double series[TERMS + 1];

static const double STEP_PART = 0.1353352832366127; /* exp(-2) */
/* Shortest step, over the time between samples: below it the motion has run into a singularity. */
static const double SHORTEST = 1e-12;

/* Fills y[i][1 ..] from y[i][0] at a time [s]; scale[i] > 0 is the size with which the last
 * coefficients of y[i] are compared for the step, 0 leaves y[i] out. */
typedef void (*expansion)(const void *system, dd time, series *y, double *scale);

/* Coefficient n of the product a b (Cauchy). */
static inline double cauchy(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int k = 0; k <= n; k++)
        sum += a[k] * b[n - k];
    return sum;
}

/* The same without its term a_0 b_n, so that a b = c has the solution b_n = (c_n - rest)/a_0. */
static inline double cauchy_rest(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int k = 1; k <= n; k++)
        sum += a[k] * b[n - k];
    return sum;
}

/* Coefficient n of s = sine and c = cosine of an angle whose rate w is known to n - 1: s' = c w, c'
 * = -s w. */
static inline void sine_cosine(const double *angle, const double *rate, double *s, double *c, int n)
{
    if (n == 0) {
        s[0] = sin(angle[0]);
        c[0] = cos(angle[0]);
        return;
    }
    /* n s_n = sum over k of w_k c_(n-1-k),   n c_n = -sum over k of w_k s_(n-1-k). */
    s[n] = cauchy(rate, c, n - 1) / n;
    c[n] = -cauchy(rate, s, n - 1) / n;
}

/* The step rho/e^2 [s] of n series, rho = min over k = TERMS - 1, TERMS of (max_i
 * |y_k/scale|)^(-1/k).
 */
static inline double step_size(int n, series *y, const double *scale)
{
    double radius = INFINITY;
    for (int k = TERMS - 1; k <= TERMS; k++) {
        double largest = 0.0;
        for (int i = 0; i < n; i++)
            if (scale[i] > 0.0)
                largest = fmax(largest, fabs(y[i][k]) / scale[i]);
        if (largest > 0.0)
            radius = fmin(radius, pow(largest, -1.0 / k));
    }
    return radius * STEP_PART;
}

/* y(h) - y(0) of one coordinate, by Horner's rule. */
static inline double gained(const double *y, double h)
{
    double sum = y[TERMS];
    for (int k = TERMS - 1; k >= 1; k--)
        sum = sum * h + y[k];
    return sum * h;
}

/* States (samples, n) at the times t (samples) [s], in either direction; row 0 is the start, given,
 * at t[0]. y: room for n series, at most 64. Returns 0, or the sample (from 1) that was not
 * reached. */
static inline int taylor_run(expansion expand, const void *system, int n, series *y,
                             int64_t samples, const double *t, double *out)
{
    assert(n <= 64 && samples >= 1 && t && out);
    double low[64] = {0.0}; /* what rounding has lost of the state */
    double scale[64];
    dd now = dd_of(t[0]);
    double step = 0.0;
    double direction = 1.0;
    if (t[samples - 1] < t[0]) /* backwards */
        direction = -1.0;
    for (int i = 0; i < n; i++)
        y[i][0] = out[i];
    for (int64_t k = 1; k < samples; k++) {
        double to_sample = dd_round(dd_sub(dd_of(t[k]), now)) * direction;
        double shortest = SHORTEST * fabs(t[k] - t[k - 1]);
        while (to_sample > step || step == 0.0) {
            if (step > 0.0) { /* accept: the end of the step becomes the state */
                for (int i = 0; i < n; i++) {
                    dd sum = two_sum(y[i][0], low[i] + gained(y[i], direction * step));
                    y[i][0] = sum.hi;
                    low[i] = sum.lo;
                }
                now = dd_add(now, dd_of(direction * step));
                to_sample = dd_round(dd_sub(dd_of(t[k]), now)) * direction;
            }
            expand(system, now, y, scale);
            step = step_size(n, y, scale);
            if (!(step > shortest)) /* a singularity */
                return (int)k + 1;
        }
        for (int i = 0; i < n; i++)
            out[k * n + i] = y[i][0] + (low[i] + gained(y[i], direction * to_sample));
    }
    return 0;
}

#endif

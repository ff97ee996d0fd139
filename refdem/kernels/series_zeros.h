/* Taylor series of order 20: products, values, and their first zeros to the last bit.
 *
 * A series is a(s) = a_0 + a_1 s + .. + a_20 s^20. That an interval (0, w] has no zero is proven
 * by bounds, never by its ends alone:
 *
 *   a(s)  >= a_0 + sum of min(0, a_n w^n) over n >= 1,
 *   a'(s) <= a_1 + sum of max(0, n a_n w^(n-1)) over n >= 2.
 *
 * If the first bound is positive there is no zero. If the second is not positive there is at most
 * one. Otherwise the interval is halved.
 */
#ifndef REFDEM_SERIES_ZEROS_H
#define REFDEM_SERIES_ZEROS_H

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum {
    ORDER = 20,
    LANES = 4,                       /* numbers in a short vector of the processor */
    PADDED_ORDER = ORDER + 2 * LANES /* room for a whole vector beyond the last coefficient */
};

/* The product c = a b of two series whose coefficients become known one by one, c_n = sum over k of
 * a_k b_(n-k) (Cauchy). sum[n] holds the terms of c_n that are known so far, but for those with a_0
 * or b_0. Each new pair is added to all later sums at once, in short vectors without a sum across
 * them: the next coefficient waits for a single multiplication and addition. */
typedef struct {
    double a[PADDED_ORDER], b[PADDED_ORDER], sum[PADDED_ORDER];
} running_product;

/* An empty product. Loops of the width of a vector: a single memset of the structure took a quarter
 * of an expansion. */
static inline void clear(running_product *g)
{
    for (int k = 0; k < PADDED_ORDER; k += LANES) {
        for (int i = 0; i < LANES; i++)
            g->a[k + i] = 0.0;
        for (int i = 0; i < LANES; i++)
            g->b[k + i] = 0.0;
        for (int i = 0; i < LANES; i++)
            g->sum[k + i] = 0.0;
    }
}

/* Takes in the coefficients a_n and b_n, in turn from n = 0: adds a_n b_k + a_k b_n to sum[n + k]
 * for 1 <= k < n, and a_n b_n to sum[2 n]. */
static inline void take_in(running_product *restrict g, double a, double b, int n)
{
    int last = n - 1; /* the last k < n for which n + k is within the order */
    if (ORDER - n < last)
        last = ORDER - n;
    for (int k = 1; k <= last; k += LANES)
        for (int i = 0; i < LANES; i++)
            g->sum[n + k + i] = fma(a, g->b[k + i], fma(b, g->a[k + i], g->sum[n + k + i]));
    if (n > 0 && 2 * n <= ORDER)
        g->sum[2 * n] = fma(a, b, g->sum[2 * n]);
    g->a[n] = a;
    g->b[n] = b;
}

/* Coefficient n of the product, from a_n and b_n, which are not yet taken in: a_n b_0 + a_0 b_n and
 * the sum. */
static inline double coefficient(const running_product *g, double a, double b, int n)
{
    if (n == 0)
        return a * b;
    return fma(a, g->b[0], fma(b, g->a[0], g->sum[n]));
}

/* 1/n: a multiplication is ready sooner than a division. */
static const double INVERSE[ORDER + 1] = {
    0.0,      1.0 / 1,  1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,
    1.0 / 7,  1.0 / 8,  1.0 / 9,  1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13,
    1.0 / 14, 1.0 / 15, 1.0 / 16, 1.0 / 17, 1.0 / 18, 1.0 / 19, 1.0 / 20,
};

/* Coefficient n of the product a b, by four sums that do not wait for each other. */
static inline double product(const double *restrict a, const double *restrict b, int n)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    int i = 0;
    for (; i + 3 <= n; i += 4)
        for (int k = 0; k < 4; k++)
            sum[k] += a[i + k] * b[n - i - k];
    for (; i <= n; i++)
        sum[0] += a[i] * b[n - i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Coefficient n of a^2: 2 (a_0 a_n + a_1 a_(n-1) + ..), the middle term once. */
static inline double square(const double *a, int n)
{
    double sum = 0.0;
    for (int i = 0; 2 * i < n; i++)
        sum += a[i] * a[n - i];
    if (n % 2 == 1)
        return 2.0 * sum;
    return 2.0 * sum + a[n / 2] * a[n / 2];
}

/* a[0] + a[1] s + .. + a[count - 1] s^(count - 1), by four sums in s^4 that do not wait for each
 * other. */
static inline double polynomial(const double *restrict a, int count, double s)
{
    double square = s * s;
    double fourth = square * square;
    double sum[LANES] = {0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < count % LANES; i++)
        sum[i] = a[count - count % LANES + i];
    for (int n = count - count % LANES - LANES; n >= 0; n -= LANES)
        for (int i = 0; i < LANES; i++)
            sum[i] = fma(sum[i], fourth, a[n + i]);
    return fma(fma(sum[3], s, sum[2]), square, fma(sum[1], s, sum[0]));
}

/* a(s). */
static inline double value(const double *restrict a, double s)
{
    return polynomial(a, ORDER + 1, s);
}

/* a(s) - a(0). */
static inline double gained(const double *restrict a, double s)
{
    return polynomial(a + 1, ORDER, s) * s;
}

/* b(s) = a(s)/s^skip, for a series whose first `skip` coefficients are zeros. */
static inline void divide_by_power(const double *restrict a, int skip, double *restrict b)
{
    for (int n = 0; n <= ORDER - skip; n++)
        b[n] = a[n + skip];
    for (int n = ORDER - skip + 1; n <= ORDER; n++)
        b[n] = 0.0;
}

/* b(s) = a(s + at), by repeated synthetic division (Horner's shift). */
static inline void shift(const double *restrict a, double at, double *restrict b)
{
    for (int n = 0; n <= ORDER; n++)
        b[n] = a[n];
    for (int k = 0; k < ORDER; k++)
        for (int n = ORDER - 1; n >= k; n--)
            b[n] += at * b[n + 1];
}

/* A bracket [low, high] of a zero through which a function falls, and the place `at` to evaluate it
 * next: Newton's steps; once they are shorter than `beyond`, a few ulps past the zero, so that the
 * other end closes in too; then bisection, to the last bit. */
typedef struct {
    double low, high, at, beyond;
} bracket;

static inline bracket bracketed(double low, double high)
{
    return (bracket){low, high, 0.5 * (low + high), 0x1p-52 * high};
}

/* True if there is a number left between the ends; it is then `at`: where Newton's step led, or the
 * middle if that was out of the bracket, or if the bracket has nearly closed. */
static inline int is_open(bracket *b)
{
    if (!(b->at > b->low && b->at < b->high) || b->high - b->low <= 0x1p-50 * b->high)
        b->at = 0.5 * (b->low + b->high);
    return b->at > b->low && b->at < b->high;
}

/* Takes in the value f and the slope at `at`, and chooses the next place. */
static inline void narrow(bracket *b, double f, double slope)
{
    double step = -f / slope; /* Newton's step; infinite for a slope of 0, see zero_between */
    if (f > 0.0)
        b->low = b->at;
    else
        b->high = b->at;
    if (fabs(step) < b->beyond) { /* a few ulps beyond the zero, so that the other end moves too */
        step = -b->beyond;
        if (f > 0.0)
            step = b->beyond;
        b->beyond *= 4.0;
    }
    b->at += step;
}

/* The zero of a series in [low, high] through which it falls, to the last bit: the smallest number
 * at which it is no longer positive, by Newton's method kept in a bracket. */
static inline double zero_between(const double *restrict a, double low, double high)
{
    bracket b = bracketed(low, high);
    double rate[ORDER];
    for (int n = 0; n < ORDER; n++)
        rate[n] = (n + 1) * a[n + 1];
    for (int i = 0; i < 200 && is_open(&b); i++) {
        /* Every eighth step is a bisection, in case Newton's steps creep: a slope of 0 makes a step
         * without end, which `is_open` replaces by the middle. */
        bool is_bisection = i % 8 == 7;
        double slope = 0.0;
        if (!is_bisection)
            slope = polynomial(rate, ORDER, b.at);
        narrow(&b, value(a, b.at), slope);
    }
    return b.high;
}

/* A lower bound of the series on (0, w]: max(0, b0) + sum of min(0, b_n w^n), by four sums. */
static inline double lower_bound(const double *restrict b, double w)
{
    double square = w * w;
    double fourth = square * square;
    double power[LANES] = {w, square, w * square, fourth};
    double sum[LANES] = {0.0, 0.0, 0.0, 0.0};
    for (int n = 1; n <= ORDER; n += LANES)
        for (int i = 0; i < LANES; i++) {
            double term = b[n + i] * power[i];
            sum[i] += term < 0.0 ? term : 0.0; /* a blend: a branch would not be a vector */
            power[i] *= fourth;
        }
    double constant = 0.0; /* a series that begins at a zero, or below it by rounding */
    if (b[0] > 0.0)
        constant = b[0];
    return constant + ((sum[0] + sum[1]) + (sum[2] + sum[3]));
}

/* An upper bound of its slope there: b1 + sum of max(0, n b_n w^(n-1)) over n >= 2. */
static inline double slope_bound(const double *restrict b, double w)
{
    double square = w * w;
    double fourth = square * square;
    double power[LANES] = {1.0, w, square, w * square};
    double sum[LANES] = {0.0, 0.0, 0.0, 0.0};
    for (int n = 1; n <= ORDER; n += LANES)
        for (int i = 0; i < LANES; i++) {
            double term = (n + i) * b[n + i] * power[i];
            sum[i] += term > 0.0 || n + i == 1 ? term : 0.0; /* a blend, as above */
            power[i] *= fourth;
        }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* The first zero in (0, h] of a series that is > 0 just after 0; -1 if there is none. Intervals
 * [from, from + width] that are not decided yet wait on a stack, the first one on top. */
static inline double first_zero(const double *restrict a, double h)
{
    double from[64], width[64], shifted[ORDER + 1];
    int waiting = 1;
    from[0] = 0.0;
    width[0] = h;
    while (waiting) {
        waiting--;
        double low = from[waiting];
        double width_now = width[waiting];
        if (low > 0.0)
            shift(a, low, shifted);
        else
            memcpy(shifted, a, sizeof shifted);
        if (lower_bound(shifted, width_now) > 0.0) /* no zero */
            continue;
        /* At most one zero, or an interval too short to be halved further. */
        if (slope_bound(shifted, width_now) <= 0.0 || width_now < 0x1p-45 * h) {
            if (value(a, low + width_now) <= 0.0)
                return zero_between(a, low, low + width_now);
            continue;
        }
        /* Both halves, the earlier one on top. */
        from[waiting] = low + 0.5 * width_now;
        width[waiting++] = 0.5 * width_now;
        from[waiting] = low;
        width[waiting++] = 0.5 * width_now;
    }
    return -1.0;
}

/* The same for a step that may end early: h is shortened to where the series provably has no zero
 * or one, which costs less than to shift the series and halve the interval. */
static inline double first_zero_soon(const double *restrict a, double *restrict h)
{
    for (double w = *h; w > 0x1p-12 * *h; w *= 0.5) {
        if (lower_bound(a, w) > 0.0) { /* no zero */
            *h = w;
            return -1.0;
        }
        if (slope_bound(a, w) <= 0.0) { /* one at most */
            *h = w;
            if (value(a, w) <= 0.0)
                return zero_between(a, 0.0, w);
            return -1.0;
        }
    }
    return first_zero(a, *h);
}

#endif

/* Taylor series of order 20: products, values, and their first zeros to the last bit.
 *
 * A stretch without a zero is told by bounds of the series, never by its ends alone: where the sum
 * of what lowers it leaves it positive there is none, where the slope is nowhere positive there is
 * at most one; else the stretch is halved.
 */
#ifndef REFDEM_SERIES_ZEROS_H
#define REFDEM_SERIES_ZEROS_H

#include <math.h>
#include <string.h>

enum {
    ORDER = 20,
    LANES = 4,
    ROOM = ORDER + 2 * LANES
}; /* room for a whole vector beyond the last coefficient */

/* A product of two series that grow with it: `sum[n]` holds of coefficient n what the coefficients
 * known so far give it, but for those of order 0. Short vectors without a sum across them: what is
 * waited for is a single multiplication and addition. */
typedef struct {
    double a[ROOM], b[ROOM], sum[ROOM];
} growing;

/* Nothing taken in yet; stores that stay short vectors, where one call for all of it took a quarter
 * of an expansion. */
static inline void cleared(growing *g)
{
    for (int k = 0; k < ROOM; k += LANES) {
        for (int i = 0; i < LANES; i++)
            g->a[k + i] = 0.0;
        for (int i = 0; i < LANES; i++)
            g->b[k + i] = 0.0;
        for (int i = 0; i < LANES; i++)
            g->sum[k + i] = 0.0;
    }
}

/* Takes in coefficients n of both factors, in turn from 0. */
static inline void grow(growing *restrict g, double a, double b, int n)
{
    int most = n - 1; /* of the coefficients known, those whose products are asked for */
    if (ORDER - n < most)
        most = ORDER - n;
    for (int k = 1; k <= most; k += LANES)
        for (int i = 0; i < LANES; i++)
            g->sum[n + k + i] = fma(a, g->b[k + i], fma(b, g->a[k + i], g->sum[n + k + i]));
    if (n > 0 && 2 * n <= ORDER)
        g->sum[2 * n] = fma(a, b, g->sum[2 * n]);
    g->a[n] = a;
    g->b[n] = b;
}

/* Coefficient n of the product, whose factors have these, not yet taken in. */
static inline double coefficient(const growing *g, double a, double b, int n)
{
    if (n == 0)
        return a * b;
    return fma(a, g->b[0], fma(b, g->a[0], g->sum[n]));
}

/* 1/n: a product is ready sooner than a quotient. */
static const double PART[ORDER + 1] = {
    0.0,      1.0 / 1,  1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,
    1.0 / 7,  1.0 / 8,  1.0 / 9,  1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13,
    1.0 / 14, 1.0 / 15, 1.0 / 16, 1.0 / 17, 1.0 / 18, 1.0 / 19, 1.0 / 20,
};

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

static inline double value(const double *restrict a, double s)
{
    return polynomial(a, ORDER + 1, s);
}

static inline double gained(const double *restrict a, double s)
{
    return polynomial(a + 1, ORDER, s) * s;
}

/* The series over the power of s with which it begins: its first `skip` coefficients are zeros. */
static inline void without_zeros(const double *restrict a, int skip, double *restrict b)
{
    for (int n = 0; n <= ORDER - skip; n++)
        b[n] = a[n + skip];
    for (int n = ORDER - skip + 1; n <= ORDER; n++)
        b[n] = 0.0;
}

/* b(s) = a(s + at) */
static inline void moved(const double *restrict a, double at, double *restrict b)
{
    for (int n = 0; n <= ORDER; n++)
        b[n] = a[n];
    for (int k = 0; k < ORDER; k++)
        for (int n = ORDER - 1; n >= k; n--)
            b[n] += at * b[n + 1];
}

/* A bracket [low, high] of a zero where a function falls through it, at `at` next: Newton's steps,
 * then a few ulps beyond the zero, so that both ends close in on it, then halves, to the last bit.
 */
typedef struct {
    double low, high, at, beyond;
} bracket;

static inline bracket bracketed(double low, double high)
{
    return (bracket){low, high, 0.5 * (low + high), 0x1p-52 * high};
}

/* Whether there is a number left between the ends; it is then `at`. */
static inline int open_still(bracket *b)
{
    if (!(b->at > b->low && b->at < b->high) || b->high - b->low <= 0x1p-50 * b->high)
        b->at = 0.5 * (b->low + b->high);
    return b->at > b->low && b->at < b->high;
}

static inline void narrowed(bracket *b, double f, double slope)
{
    double step = -f / slope;
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

/* The zero of a series in [low, high], where it falls through one, to the last bit. */
static inline double zero_between(const double *restrict a, double low, double high)
{
    bracket b = bracketed(low, high);
    double rate[ORDER];
    for (int n = 0; n < ORDER; n++)
        rate[n] = (n + 1) * a[n + 1];
    for (int i = 0; i < 200 && open_still(&b); i++) {
        double slope = 0.0; /* a half now and then, where Newton's steps creep */
        if (i % 8 != 7)
            slope = polynomial(rate, ORDER, b.at);
        narrowed(&b, value(a, b.at), slope);
    }
    return b.high;
}

/* Below the series on (0, w]: what lowers it at w, by four sums. */
static inline double least_of(const double *restrict b, double w)
{
    double square = w * w;
    double fourth = square * square;
    double power[LANES] = {w, square, w * square, fourth};
    double sum[LANES] = {0.0, 0.0, 0.0, 0.0};
    for (int n = 1; n <= ORDER; n += LANES)
        for (int i = 0; i < LANES; i++) {
            double part = b[n + i] * power[i];
            sum[i] += part < 0.0 ? part : 0.0; /* a blend: a branch would not be a vector */
            power[i] *= fourth;
        }
    double begins = 0.0; /* what begins at its zero, or below it by rounding */
    if (b[0] > 0.0)
        begins = b[0];
    return begins + ((sum[0] + sum[1]) + (sum[2] + sum[3]));
}

/* Above its slope there. */
static inline double steepest_of(const double *restrict b, double w)
{
    double square = w * w;
    double fourth = square * square;
    double power[LANES] = {1.0, w, square, w * square};
    double sum[LANES] = {0.0, 0.0, 0.0, 0.0};
    for (int n = 1; n <= ORDER; n += LANES)
        for (int i = 0; i < LANES; i++) {
            double part = (n + i) * b[n + i] * power[i];
            sum[i] += part > 0.0 || n + i == 1 ? part : 0.0; /* a blend, as above */
            power[i] *= fourth;
        }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* The first zero in (0, h] of a series that is > 0 just after 0; -1 if there is none. */
static inline double first_zero(const double *restrict a, double h)
{
    double from[64], width[64], b[ORDER + 1];
    int waiting = 1;
    from[0] = 0.0;
    width[0] = h;
    while (waiting) {
        waiting--;
        double low = from[waiting];
        double w = width[waiting];
        if (low > 0.0)
            moved(a, low, b);
        else
            memcpy(b, a, sizeof b);
        if (least_of(b, w) > 0.0)
            continue;
        if (steepest_of(b, w) <= 0.0 || w < 0x1p-45 * h) {
            if (value(a, low + w) <= 0.0)
                return zero_between(a, low, low + w);
            continue;
        }
        from[waiting] = low + 0.5 * w;
        width[waiting++] = 0.5 * w;
        from[waiting] = low;
        width[waiting++] = 0.5 * w;
    }
    return -1.0;
}

/* The same where a stretch may end early: `h` becomes shorter, to where there is no zero, rather
 * than that the series is moved. */
static inline double first_zero_soon(const double *restrict a, double *restrict h)
{
    for (double w = *h; w > 0x1p-12 * *h; w *= 0.5) {
        if (least_of(a, w) > 0.0) {
            *h = w;
            return -1.0;
        }
        if (steepest_of(a, w) <= 0.0) {
            *h = w;
            if (value(a, w) <= 0.0)
                return zero_between(a, 0.0, w);
            return -1.0;
        }
    }
    return first_zero(a, *h);
}

#endif

/* Taylor series of order 20: products, values, and their first zeros to the last bit.
 *
 * A stretch without a zero is told by bounds of the series, never by its ends alone: where the sum of what lowers it leaves it positive
 * there is none, where the slope is nowhere positive there is at most one; else the stretch is halved.
 */
#ifndef REFDEM_SERIES_ZEROS_H
#define REFDEM_SERIES_ZEROS_H

#include <math.h>
#include <string.h>

enum { ORDER = 20 };

/* 1/n: a product is ready sooner than a quotient. */
static const double PART[ORDER + 1] = {
    0.0,      1.0 / 1,  1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,  1.0 / 7,  1.0 / 8,  1.0 / 9, 1.0 / 10,
    1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15, 1.0 / 16, 1.0 / 17, 1.0 / 18, 1.0 / 19, 1.0 / 20,
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
    return n % 2 ? 2.0 * sum : 2.0 * sum + a[n / 2] * a[n / 2];
}

static inline double value(const double *restrict a, double s)
{
    double sum = a[ORDER];
    for (int n = ORDER - 1; n >= 0; n--)
        sum = fma(sum, s, a[n]);
    return sum;
}

static inline double gained(const double *restrict a, double s)
{
    double sum = 0.0;
    for (int n = ORDER; n >= 1; n--)
        sum = (sum + a[n]) * s;
    return sum;
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

/* A bracket [low, high] of a zero where a function falls through it, at `at` next: Newton's steps, then a few ulps beyond the zero, so
 * that both ends close in on it, then halves, to the last bit. */
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
    if (fabs(step) < b->beyond) {
        step = f > 0.0 ? b->beyond : -b->beyond;
        b->beyond *= 4.0;
    }
    b->at += step;
}

/* The zero of a series in [low, high], where it falls through one, to the last bit. */
static inline double zero_between(const double *restrict a, double low, double high)
{
    bracket b = bracketed(low, high);
    for (int i = 0; i < 200 && open_still(&b); i++) {
        double f = a[ORDER], slope = 0.0;
        for (int n = ORDER - 1; n >= 0; n--)
            slope = fma(slope, b.at, f), f = fma(f, b.at, a[n]);
        if (i % 8 == 7)
            slope = 0.0; /* a half now and then, where Newton's steps creep */
        narrowed(&b, f, slope);
    }
    return b.high;
}

/* Below the series on (0, w], and above its slope there. */
static inline double least_of(const double *restrict b, double w)
{
    double least = b[0] > 0.0 ? b[0] : 0.0, power = w;
    for (int n = 1; n <= ORDER; n++, power *= w) {
        double part = b[n] * power;
        least += part < 0.0 ? part : 0.0;
    }
    return least;
}

static inline double steepest_of(const double *restrict b, double w)
{
    double steepest = b[1], power = w;
    for (int n = 2; n <= ORDER; n++, power *= w) {
        double part = n * b[n] * power;
        steepest += part > 0.0 ? part : 0.0;
    }
    return steepest;
}

/* The first zero in (0, h] of a series that is > 0 just after 0; -1 if there is none. */
static inline double first_zero(const double *restrict a, double h)
{
    double from[64], width[64], b[ORDER + 1];
    int waiting = 1;
    from[0] = 0.0, width[0] = h;
    while (waiting) {
        waiting--;
        double low = from[waiting], w = width[waiting];
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
        from[waiting] = low + 0.5 * w, width[waiting++] = 0.5 * w;
        from[waiting] = low, width[waiting++] = 0.5 * w;
    }
    return -1.0;
}

/* The same where a stretch may end early: `h` becomes shorter, to where there is no zero, rather than that the series is moved. */
static inline double first_zero_soon(const double *restrict a, double *restrict h)
{
    for (double w = *h; w > 0x1p-12 * *h; w *= 0.5) {
        if (least_of(a, w) > 0.0) {
            *h = w;
            return -1.0;
        }
        if (steepest_of(a, w) <= 0.0) {
            *h = w;
            return value(a, w) <= 0.0 ? zero_between(a, 0.0, w) : -1.0;
        }
    }
    return first_zero(a, *h);
}

#endif

/* The motion of a point on a belt (belt.h): at given times; and its section by v = 0, x > 0 for
 * many frequencies of the drive, with the growth of tangents, whose mean logarithm per time is the
 * largest Lyapunov exponent. */
#include <assert.h>

#include "belt.h"
#include "simd.h"

/* Writes the sample (3) at `since` [s] in this segment: x, v = side |u| + belt, work. */
static inline void record(const belt *p, const motion *m, const segment *y, double since,
                          double *restrict out)
{
    out[0] = dd_round(add_small(m->x, gained(y->x, since)));
    out[1] = m->side * value(y->w, since) + p->belt;
    out[2] = dd_round(add_small(m->work, gained(y->work, since)));
}

int64_t refdem_stick_slip(const refdem_belt *p, double x0, double v0, double t0, int64_t samples,
                          const double *t, int64_t most, double *event, double *out)
{
    assert(p && t && samples >= 1 && most >= 0);
    assert(out && (most == 0 || event)); /* (samples, 3) and (most, 2) doubles */
    segment y = {0};
    motion m = begin(p, x0, v0, t0);
    int64_t events = 0;
    for (int64_t row = 0; row < samples;) {
        expand(p, &m, 1, &y);
        locate(p, &m, &y);
        for (; row < samples; row++, out += 3) {
            double since = dd_round(dd_sub(dd_of(t[row]), m.now));
            if (since > y.end)
                break;
            record(p, &m, &y, since, out);
            if (since == 0.0 && row == 0) /* the start as it was given */
                out[1] = v0;
        }
        if (row == samples)
            break;
        accept(p, &m, &y);
        int kind = change_mode(p, &m, &y);
        if (kind && events < most) {
            event[2 * events] = dd_round(m.now);
            event[2 * events + 1] = kind;
            events++;
        }
    }
    return events;
}

/* Appends to `out` the places x + origin > 0 at which v = side |u| + belt is zero along a slip, in
 * order, from number `count` on, at most `most`; returns how many there are then. */
static int64_t crossings(const belt *p, const motion *m, const segment *y, double origin,
                         int64_t most, int64_t count, double *restrict out)
{
    double v[ORDER + 1], guard[ORDER + 1];
    double from = 0.0;
    double largest_value = 0.0;
    double power = 1.0;
    for (int n = 0; n <= ORDER; n++)
        v[n] = m->side * y->w[n];
    v[0] += p->belt;
    for (int n = 0; n <= ORDER; n++, power *= y->end)
        largest_value += fabs(v[n]) * power;
    if (2.0 * fabs(v[0]) > largest_value) /* |v0| > sum of |v_n| h^n, n >= 1: there is no zero */
        return count;
    /* A series with a zero at its start is divided by that power of the time, so that the next zero
     * is found: at the start of the segment if v = 0 there, and after each zero that was found. */
    int zeros = 0;
    if (v[0] == 0.0)
        zeros = 1;
    while (from < y->end) {
        double shifted[ORDER + 1];
        if (from > 0.0)
            shift(v, from, shifted);
        else
            memcpy(shifted, v, sizeof shifted);
        divide_by_power(shifted, zeros, guard);
        if (guard[0] < 0.0) { /* its zeros are those of its negative, which begins above zero */
            for (int n = 0; n <= ORDER; n++)
                guard[n] = -guard[n];
        }
        double zero = first_zero(guard, y->end - from);
        if (!(zero > 0.0))
            break;
        from += zero;
        zeros = 1;
        double x = value(y->x, from) + origin;
        if (x > 0.0 && count < most)
            out[count++] = x;
    }
    return count;
}

/* Arguments as in kernels.h. The tangent is normalised after every segment, and the logarithms of
 * its lengths are summed in blocks of the time after the transient (Benettin et al. 1980). The
 * largest exponent is their sum divided by this time. A motion that is no longer finite ends there.
 */
REFDEM_EVERY_CPU
int refdem_stick_slip_section(const refdem_belt *p, int64_t n, const double *frequency,
                              double origin, double x0, double v0, int64_t skip, int64_t keep,
                              int64_t blocks, int64_t most, double *counts, double *sums,
                              double *out)
{
    assert(p && frequency && counts && out); /* (n), (n, most) doubles */
    assert(blocks == 0 || sums);             /* (n, blocks) doubles */
    for (int64_t i = 0; i < n; i++, out += most, sums += blocks) {
        belt driven = *p;
        driven.frequency = frequency[i];
        motion m = begin(&driven, x0, v0, 0.0);
        segment y = {0};
        m.has_tangent = blocks > 0;
        double period = 2.0 * DD_PI.hi / frequency[i];
        /* The transient of `skip` periods, then `keep` periods of the section. */
        double keep_from = period * (double)skip;
        double keep_until = period * (double)(skip + keep);
        int64_t count = 0;
        for (int64_t k = 0; k < blocks; k++)
            sums[k] = 0.0;
        while (m.now.hi < keep_until) {
            expand(&driven, &m, 0, &y);
            locate(&driven, &m, &y);
            if (!isfinite(y.end))
                break;
            if (m.now.hi >= keep_from && m.side)
                count = crossings(&driven, &m, &y, origin, most, count, out);
            double segment_start = m.now.hi;
            accept(&driven, &m, &y);
            change_mode(&driven, &m, &y);
            if (m.has_tangent) {
                /* log |(dx, du)| of the segment, and (dx, du) back to length 1. */
                double growth = fmax(hypot(m.tangent[0], m.tangent[1]), 1e-300);
                m.tangent[0] /= growth;
                m.tangent[1] /= growth;
                /* The transient is over: the growth belongs to the block of the segment's start. */
                if (segment_start >= keep_from) {
                    double block
                        = (segment_start - keep_from) / (keep_until - keep_from) * (double)blocks;
                    sums[(int64_t)fmin(block, (double)(blocks - 1))] += log(growth);
                }
            }
        }
        counts[i] = (double)count;
    }
    return 0;
}

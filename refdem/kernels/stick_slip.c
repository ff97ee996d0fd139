/* The motion on a belt (belt.h) at given times, and its section v = 0, x > 0 for many frequencies
 * of the drive, with growth of tangents. */
#include <assert.h>

#include "belt.h"
#include "simd.h"

int64_t refdem_stick_slip(const refdem_belt *p, double x0, double v0, double t0, int64_t samples,
                          const double *t, int64_t most, double *event, double *out)
{
    assert(samples >= 1 && most >= 0 && event && out);
    piece y = {0};
    motion m = begun(p, x0, v0, t0);
    int64_t events = 0;
    for (int64_t row = 0; row < samples;) {
        next_piece(p, &m, 1, &y);
        for (; row < samples; row++, out += 3) {
            double since = dd_round(dd_sub(dd_of(t[row]), m.now));
            if (since > y.end)
                break;
            out[0] = dd_round(grown(m.x, gained(y.x, since)));
            out[1] = m.side * value(y.w, since) + p->belt;
            if (since == 0.0 && row == 0) /* the start as it was given */
                out[1] = v0;
            out[2] = dd_round(grown(m.work, gained(y.work, since)));
        }
        if (row == samples)
            break;
        int kind = pass(p, &m, &y);
        if (kind && events < most) {
            event[2 * events] = dd_round(m.now);
            event[2 * events + 1] = kind;
            events++;
        }
    }
    return events;
}

/* Places x + origin > 0 at which v = 0 along a slip, in order, added to `out` from `count` on. */
static int64_t crossings(const belt *p, const motion *m, const piece *y, double origin,
                         int64_t most, int64_t count, double *restrict out)
{
    double v[ORDER + 1], a[ORDER + 1];
    double from = 0.0;
    double sum = 0.0;
    double power = 1.0;
    for (int n = 0; n <= ORDER; n++)
        v[n] = m->side * y->w[n];
    v[0] += p->belt;
    for (int n = 0; n <= ORDER; n++, power *= y->end)
        sum += fabs(v[n]) * power;
    if (2.0 * fabs(v[0]) > sum) /* its other terms cannot make it zero */
        return count;
    for (int skip = v[0] == 0.0; from < y->end; skip = 1) {
        double here[ORDER + 1];
        if (from > 0.0)
            moved(v, from, here);
        else
            memcpy(here, v, sizeof here);
        without_zeros(here, skip, a);
        if (a[0] < 0.0) { /* its zeros are those of its negative, which falls through them */
            for (int n = 0; n <= ORDER; n++)
                a[n] = -a[n];
        }
        double at = first_zero(a, y->end - from);
        if (!(at > 0.0))
            break;
        from += at;
        double x = value(y->x, from) + origin;
        if (x > 0.0 && count < most)
            out[count++] = x;
    }
    return count;
}

/* What goes in and comes out is in kernels.h. A tangent that is carried along is brought back to
 * length 1 after every piece; the logarithms of its growth are summed by blocks of the kept time
 * and make Lyapunov's exponent. A motion that is not finite any more ends there. */
REFDEM_EVERY_CPU
int refdem_stick_slip_section(const refdem_belt *p, int64_t n, const double *frequency,
                              double origin, double x0, double v0, int64_t skip, int64_t keep,
                              int64_t blocks, int64_t most, double *counts, double *sums,
                              double *out)
{
    for (int64_t i = 0; i < n; i++, out += most, sums += blocks) {
        belt own = *p;
        own.frequency = frequency[i];
        motion m = begun(&own, x0, v0, 0.0);
        piece y = {0};
        m.follows = blocks > 0;
        double period = 2.0 * DD_PI.hi / frequency[i];
        double begin = period * (double)skip;
        double end = period * (double)(skip + keep);
        int64_t count = 0;
        for (int64_t k = 0; k < blocks; k++)
            sums[k] = 0.0;
        while (m.now.hi < end) {
            next_piece(&own, &m, 0, &y);
            if (!isfinite(y.end))
                break;
            if (m.now.hi >= begin && m.side)
                count = crossings(&own, &m, &y, origin, most, count, out);
            double at = m.now.hi;
            pass(&own, &m, &y);
            if (m.follows) {
                double size = fmax(hypot(m.tangent[0], m.tangent[1]), 1e-300);
                m.tangent[0] /= size;
                m.tangent[1] /= size;
                if (at >= begin)
                    sums[(int64_t)fmin((at - begin) / (end - begin) * (double)blocks,
                                       (double)(blocks - 1))] += log(size);
            }
        }
        counts[i] = (double)count;
    }
    return 0;
}

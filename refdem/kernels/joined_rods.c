/* Points on rods that hang from fixed pivots, joined by springs to each other or to fixed points,
 * in a plane, in angles.
 *
 * Point i: r_i = pivot_i + l_i (sin th_i, -cos th_i), with the tangent t_i = (cos th_i, sin th_i),
 *
 *   m_i l_i th_i'' = (m_i g + sum of the pulls on i).t_i.
 *
 * A spring from a to b with d = r_b - r_a pulls a with k (1 - s/|d|) d, and b with the opposite of
 * it; s is its length without force. State (2 N + S): angles since the start [rad], rates [rad/s],
 * and log |d| of each spring. Where |d| = 0 the pull has no direction. The singularity of log |d|
 * stops the integration there even if the pull has a regular series, as for points that pass
 * straight through each other.
 */
#include <assert.h>

#include "kernels.h"
#include "taylor.h"

enum { MOST = 8 }; /* of rods, and of springs */

typedef struct {
    int rods, springs;
    const double *length, *mass, *aim, *pivot; /* (n), (n), (n, 2), (n, 2); aim: sine and cosine of
                                                  each angle at the start, from which it counts */
    const int64_t *ends;                       /* (s, 2): points; -1 is the fixed point */
    const double *fixed, *stiffness, *rest; /* (s, 2), (s), (s): rest is the length without force */
    double gravity[2];
    double
        outer_rate; /* sqrt(g/l) of the shortest rod + sqrt(sum k/m) of the lightest point [1/s] */
} rods;

/* Coefficient n of the position pivot_i + l_i (sin th_i, -cos th_i), with sin th_i = sin th_0 cos a
 * + cos th_0 sin a and cos th_i = cos th_0 cos a - sin th_0 sin a of the angle a since the start.
 */
static void place(const rods *p, int i, const double *s, const double *c, series *sine,
                  series *cosine, series *r, int n)
{
    const double *aim = p->aim + 2 * i;
    /* Exact at the start, where a = 0, so that a rod that stands upright at rest stays so. */
    (*sine)[n] = aim[0] * c[n] + aim[1] * s[n];
    (*cosine)[n] = aim[1] * c[n] - aim[0] * s[n];
    r[0][n] = p->length[i] * (*sine)[n];
    r[1][n] = -p->length[i] * (*cosine)[n];
    if (n == 0)
        for (int axis = 0; axis < 2; axis++)
            r[axis][0] += p->pivot[2 * i + axis];
}

typedef struct {
    series branch[2], squared, distance, inverse, strength; /* d, d.d, |d|, 1/|d|, k (1 - s/|d|) */
} spring;

/* Coefficient n of k (1 - s/|d|), from |d| |d| = d.d and |d| (1/|d|) = 1. */
static void stretch(double stiffness, double rest, spring *e, int n)
{
    e->strength[n] = 0.0;
    if (n == 0)
        e->strength[0] = stiffness;
    if (rest == 0.0)
        return;
    /* (d.d)_n, and with sums over 0 < k < n and 0 < k <= n:
     *   2 |d|_0 |d|_n = (d.d)_n - sum |d|_k |d|_(n-k),
     *   |d|_0 (1/|d|)_n = -sum |d|_k (1/|d|)_(n-k). */
    e->squared[n] = cauchy(e->branch[0], e->branch[0], n) + cauchy(e->branch[1], e->branch[1], n);
    if (n == 0) {
        e->distance[0] = sqrt(e->squared[0]);
        e->inverse[0] = 1.0 / e->distance[0];
    } else {
        e->distance[n] = 0.0;
        e->distance[n]
            = (e->squared[n] - cauchy_rest(e->distance, e->distance, n)) / (2.0 * e->distance[0]);
        e->inverse[n] = -cauchy_rest(e->distance, e->inverse, n) / e->distance[0];
    }
    /* k (1 - s/|d|). */
    e->strength[n] -= stiffness * rest * e->inverse[n];
}

/* Coefficients 1 to TERMS of the state, order by order n: places, springs, forces, th''. */
static void expand(const void *system, dd time, series *y, double *scale)
{
    const rods *p = system;
    series s[MOST], c[MOST], sine[MOST], cosine[MOST], r[MOST][2], force[MOST][2];
    spring springs[MOST];
    (void)time;
    for (int n = 0; n < TERMS; n++) {
        for (int i = 0; i < p->rods; i++) {
            sine_cosine(y[i], y[p->rods + i], s[i], c[i], n);
            place(p, i, s[i], c[i], &sine[i], &cosine[i], r[i], n);
            /* The force on point i begins with m_i g, which is constant in time. */
            for (int axis = 0; axis < 2; axis++) {
                force[i][axis][n] = 0.0;
                if (n == 0)
                    force[i][axis][0] = p->mass[i] * p->gravity[axis];
            }
        }
        for (int j = 0; j < p->springs; j++) {
            double *logarithm = y[2 * p->rods + j];
            spring *e = &springs[j];
            int64_t a = p->ends[2 * j];
            int64_t b = p->ends[2 * j + 1];
            /* d = r_b - r_a, with r_b the fixed point, constant in time, where b = -1. */
            for (int axis = 0; axis < 2; axis++) {
                double other = 0.0;
                if (b >= 0)
                    other = r[b][axis][n];
                else if (n == 0)
                    other = p->fixed[2 * j + axis];
                e->branch[axis][n] = other - r[a][axis][n];
            }
            stretch(p->stiffness[j], p->rest[j], e, n);
            /* (log |d|)' = |d|' (1/|d|): n log_n = sum over k = 1 .. n of k |d|_k (1/|d|)_(n-k).
             * The coefficient TERMS, for which |d| is not known, is left 0. */
            logarithm[n + 1] = 0.0;
            if (p->rest[j] > 0.0 && n > 0) {
                double sum = 0.0;
                for (int k = 1; k <= n; k++)
                    sum += k * e->distance[k] * e->inverse[n - k];
                logarithm[n] = sum / n;
            }
            /* The pull k (1 - s/|d|) d on a, and its opposite on b. */
            for (int axis = 0; axis < 2; axis++) {
                double pull = cauchy(e->strength, e->branch[axis], n);
                force[a][axis][n] += pull;
                if (b >= 0)
                    force[b][axis][n] -= pull;
            }
        }
        /* th_i'' = (m_i g + pulls on i).t_i/(m_i l_i), t_i = (cos th_i, sin th_i). */
        for (int i = 0; i < p->rods; i++) {
            double along = cauchy(force[i][0], cosine[i], n) + cauchy(force[i][1], sine[i], n);
            y[i][n + 1] = y[p->rods + i][n] / (n + 1);
            y[p->rods + i][n + 1] = along / (p->mass[i] * p->length[i]) / (n + 1);
        }
    }
    /* Sizes relative to which the last coefficients determine the step: 1 rad, the largest |th'|
     * plus `outer_rate`, and 1 for log |d|. */
    double rate = 0.0;
    for (int i = 0; i < p->rods; i++)
        rate = fmax(rate, fabs(y[p->rods + i][0]));
    for (int i = 0; i < p->rods; i++) {
        scale[i] = 1.0;
        scale[p->rods + i] = rate + p->outer_rate;
    }
    for (int j = 0; j < p->springs; j++)
        scale[2 * p->rods + j] = 1.0;
}

int refdem_joined_rods(int64_t count, const double *length, const double *mass, const double *aim,
                       const double *pivot, int64_t springs, const int64_t *ends,
                       const double *fixed, const double *stiffness, const double *rest,
                       const double *gravity, int64_t samples, const double *t, double *out)
{
    assert(length && mass && aim && pivot && ends && fixed && stiffness && rest && gravity);
    assert(samples >= 1 && t && out); /* (samples), (samples, 2 count + springs) doubles */
    rods p = {.rods = (int)count,
              .springs = (int)springs,
              .length = length,
              .mass = mass,
              .aim = aim,
              .pivot = pivot,
              .ends = ends,
              .fixed = fixed,
              .stiffness = stiffness,
              .rest = rest,
              .gravity = {gravity[0], gravity[1]}};
    series y[3 * MOST];
    double shortest = INFINITY;
    double lightest = INFINITY;
    double stiff = 0.0;
    if (count < 1 || count > MOST || springs < 0 || springs > MOST) /* there is no room for them */
        return 1;
    for (int i = 0; i < p.rods; i++) {
        shortest = fmin(shortest, length[i]);
        lightest = fmin(lightest, mass[i]);
    }
    for (int j = 0; j < p.springs; j++)
        stiff += fabs(stiffness[j]);
    /* sqrt(|g|/min l) + sqrt(sum |k|/min m), a rate of the motion that is there even at rest. */
    p.outer_rate = sqrt(hypot(gravity[0], gravity[1]) / shortest) + sqrt(stiff / lightest);
    return taylor_run(expand, &p, 2 * p.rods + p.springs, y, samples, t, out);
}

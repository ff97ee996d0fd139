/* Many plane pendulums at once: theta'' = -w0^2 sin theta by a symmetric composition of Verlet's
 * method, a block of them at a time.
 *
 * A step h of s stages with weights c_1 .. c_s, c_i = c_(s+1-i), sum 1 (Yoshida 1990; Hairer,
 * Lubich and Wanner, V.3): for each i drift theta += d_i theta', kick theta' -= c_i h w0^2 sin
 * theta, and a last drift, d_i = (c_(i-1) + c_i) h/2 with c_0 = c_(s+1) = 0.
 *
 * During the integration angles are measured in half turns, and rates in half turns a second: the
 * reduction of an angle then subtracts a whole number. The sine is a polynomial that interpolates
 * at Chebyshev's nodes on -1/2..1/2 half turns.
 */
#include <assert.h>

#include "kernels.h"
#include "simd.h"

enum {
    MEMBERS = 512, /* of a block: angles and rates fill a quarter of a first cache */
    MOST_STAGES = 63
};

/* sin(pi x)/pi, absolute error 2e-16/pi. With the whole number n next to x it is (-1)^n sin(pi
 * r)/pi, r = x - n, exact. Adding 1.5 2^52 rounds x to n; the last bit of that sum is the parity of
 * n, and is moved to the place of the sign. */
static inline double sine_of_half_turns(double x)
{
    double shifted = x + 0x1.8p52;
    double r = x - (shifted - 0x1.8p52);
    double z = r * r;
    double p;
    uint64_t parity, bits;
    memcpy(&parity, &shifted, sizeof parity);
    memcpy(&bits, &r, sizeof bits);
    bits ^= parity << 63;
    memcpy(&r, &bits, sizeof r);
    /* sin(pi r)/pi = r + r z p(z), z = r^2, where p(z) begins with -pi^2/6 + pi^4/120 z. */
    p = fma(z, 2.459180384815939e-07, -6.972960555564221e-06);
    p = fma(z, p, 0.00014842817816693618);
    p = fma(z, p, -0.0023460809634923995);
    p = fma(z, p, 0.026147847813078808);
    p = fma(z, p, -0.19075182412194128);
    p = fma(z, p, 0.8117424252833519);
    p = fma(z, p, -1.6449340668482264);
    return fma(r * z, p, r);
}

/* x *= factor, to an ulp. */
static inline void convert(int count, dd factor, double *restrict x)
{
    for (int k = 0; k < count; k++)
        x[k] = fma(x[k], factor.hi, x[k] * factor.lo);
}

/* The drifts d_i = (c_(i-1) + c_i) h/2 (stages + 1) and kicks c_i h (stages) [s] of one step;
 * `weight` holds the first half of the c_i and the middle one. */
static void set_stages(int stages, const double *weight, double h, double *restrict drift,
                       double *restrict kick)
{
    for (int s = 0; s <= stages / 2; s++) {
        kick[s] = h * weight[s];
        kick[stages - 1 - s] = kick[s];
    }
    /* A drift is half of the step before it and half of the one after it. */
    drift[0] = 0.5 * kick[0];
    drift[stages] = 0.5 * kick[stages - 1];
    for (int s = 1; s < stages; s++)
        drift[s] = 0.5 * (kick[s - 1] + kick[s]);
}

REFDEM_EVERY_CPU
int refdem_pendulum_ensemble(int stages, const double *weight, double square, double h,
                             int64_t steps, int64_t members, double *angle, double *rate)
{
    double drift[MOST_STAGES + 1], kick[MOST_STAGES];
    assert(weight && (members == 0 || (angle && rate))); /* ((stages + 1) / 2), (members) doubles */
    if (stages > MOST_STAGES)
        return 1;
    set_stages(stages, weight, h, drift, kick);
    for (int s = 0; s < stages; s++)
        kick[s] *= square;
    /* With a = theta/pi and w = theta'/pi the kick is w -= c h w0^2 sin(pi a)/pi. */
    dd per_half_turn = dd_div(dd_of(1.0), DD_PI);
    for (int64_t first = 0; first < members; first += MEMBERS) {
        int count = MEMBERS;
        if (members - first < MEMBERS) /* the last ones */
            count = (int)(members - first);
        double *restrict a = angle + first;
        double *restrict w = rate + first;
        convert(count, per_half_turn, a);
        convert(count, per_half_turn, w);
        for (int64_t n = 0; n < steps; n++) {
            for (int s = 0; s < stages; s++)
                for (int k = 0; k < count; k++) {
                    /* a += d_s w,   w -= c_s h w0^2 sin(pi a)/pi. */
                    a[k] = fma(drift[s], w[k], a[k]);
                    w[k] = fma(-kick[s], sine_of_half_turns(a[k]), w[k]);
                }
            for (int k = 0; k < count; k++)
                a[k] = fma(drift[stages], w[k], a[k]);
        }
        convert(count, DD_PI, a);
        convert(count, DD_PI, w);
    }
    return 0;
}

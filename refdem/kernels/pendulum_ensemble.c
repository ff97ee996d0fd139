/* Many plane pendulums at once: theta'' = -w0^2 sin theta by Verlet's method composed to order 8, a block of them at a time.
 *
 * Coefficients: M. Suzuki and K. Umeno (1993), in Hairer, Lubich and Wanner, Geometric Numerical Integration, V.3.11. The sine is a
 * polynomial interpolated at Chebyshev's nodes on -pi/2..pi/2, after whole half turns are taken off.
 */
#include "kernels.h"
#include "simd.h"

enum { MEMBERS = 512, STAGES = 15 }; /* angles and rates of a block fill a quarter of a first cache */

static const double WEIGHTS[8] = {0.74167036435061295345,  -0.40910082580003159400, 0.19075471029623837995,  -0.57386247111608226666,
                                  0.29906418130365592384,  0.33462491824529818378,  0.31529309239676659663, -0.79688793935291635402};

/* sin x for |x| < 1e9: absolute error 2e-16 and what the reduction leaves, 1e-33 |x|. */
static inline double sine(double x)
{
    double n = nearest(x * (1.0 / DD_PI.hi)), r = fma(-n, DD_PI.lo, fma(-n, DD_PI.hi, x)), z = r * r, p;
    double odd = n - 2.0 * nearest(0.5 * n);
    p = fma(z, 2.7215749422983443e-15, -7.643026557971632e-13);
    p = fma(z, p, 1.605894087848656e-10);
    p = fma(z, p, -2.505210689056952e-08);
    p = fma(z, p, 2.7557319211229606e-06);
    p = fma(z, p, -0.00019841269841208676);
    p = fma(z, p, 0.008333333333333186);
    p = fma(z, p, -0.16666666666666666);
    return fma(-2.0, fabs(odd), 1.0) * fma(r * z, p, r);
}

/* h of each drift and kick of one step. */
static void staged(double h, double *restrict drift, double *restrict kick)
{
    for (int s = 0; s < STAGES; s++)
        kick[s] = h * WEIGHTS[s < 8 ? s : STAGES - 1 - s];
    for (int s = 0; s <= STAGES; s++)
        drift[s] = 0.5 * ((s > 0 ? kick[s - 1] : 0.0) + (s < STAGES ? kick[s] : 0.0));
}

REFDEM_EVERY_CPU
int refdem_pendulum_ensemble(double square, double h, int64_t steps, int64_t members, double *angle, double *rate)
{
    double drift[STAGES + 1], kick[STAGES];
    staged(h, drift, kick);
    for (int s = 0; s < STAGES; s++)
        kick[s] *= square;
    for (int64_t first = 0; first < members; first += MEMBERS) {
        int count = members - first < MEMBERS ? (int)(members - first) : MEMBERS;
        double *restrict a = angle + first, *restrict w = rate + first;
        for (int64_t n = 0; n < steps; n++) {
            for (int s = 0; s < STAGES; s++)
                for (int k = 0; k < count; k++) {
                    a[k] = fma(drift[s], w[k], a[k]);
                    w[k] = fma(-kick[s], sine(a[k]), w[k]);
                }
            for (int k = 0; k < count; k++)
                a[k] = fma(drift[STAGES], w[k], a[k]);
        }
    }
    return 0;
}

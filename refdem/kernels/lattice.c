/* Verlet's method on a lattice: places X and velocities V are whole numbers of their units, so that
 * every kick and drift is undone exactly.
 *
 * D. Levesque and L. Verlet, J. Stat. Phys. 72 (1993) 519; here in velocity form,
 *   kick V += [h/2 a(X)],   drift X += [h V],   kick V += [h/2 a(X)],
 * with [] the nearest whole number. Reversed in time, the method subtracts the same whole numbers.
 * Sums of whole numbers have no rounding errors.
 */
#include <assert.h>

#include "kernels.h"
#include "simd.h"

/* a(x) = (weight - k |x|^n sgn x - cubic x^3)/m [m/s^2]. */
static inline double acceleration(const refdem_lattice *p, double x)
{
    double spring_force = p->stiffness * x;
    if (p->exponent != 1.0)
        spring_force = copysign(p->stiffness * pow(fabs(x), p->exponent), x);
    double cubic_force = p->cubic * x * x * x;
    return (p->weight - spring_force - cubic_force) / p->mass;
}

/* The whole number nearest to factor * count, where count and the product may have more bits than
 * binary64. With count = rough + rest and factor rough = hi + lo exactly,
 *
 *   [factor count] = [hi] + [(hi - [hi]) + factor rest + lo]. */
static inline int64_t rounded_product(double factor, int64_t count)
{
    double rough = (double)count;
    dd product = two_product(factor, rough);
    int64_t whole = llrint(product.hi);
    return whole
           + llrint((product.hi - (double)whole)
                    + fma(factor, (double)(count - (int64_t)rough), product.lo));
}

REFDEM_EVERY_CPU
int refdem_lattice_verlet(const refdem_lattice *p, double x0, double v0, double h, int64_t samples,
                          int64_t stride, double *out)
{
    assert(p);
    assert(samples >= 1 && stride >= 0 && out); /* (samples, 2) doubles */
    int64_t place = llrint(x0 / p->place);
    int64_t speed = llrint(v0 / p->speed);
    double half_kick = 0.5 * h / p->speed;
    double drift = h * p->speed / p->place;
    out[0] = x0;
    out[1] = v0;
    int64_t velocity_change = llrint(half_kick * acceleration(p, (double)place * p->place));
    for (int64_t row = 1; row < samples; row++) {
        for (int64_t n = 0; n < stride; n++) {
            /* Kick, drift, kick. The change of the last kick is that of the next step's first. */
            speed += velocity_change;
            place += rounded_product(drift, speed);
            velocity_change = llrint(half_kick * acceleration(p, (double)place * p->place));
            speed += velocity_change;
        }
        out[2 * row] = (double)place * p->place;
        out[2 * row + 1] = (double)speed * p->speed;
    }
    return 0;
}

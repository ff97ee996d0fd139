/* Verlet's method on a lattice: places and velocities are whole numbers of their units, so that
 * every kick and drift is undone exactly.
 *
 * D. Levesque and L. Verlet, J. Stat. Phys. 72 (1993) 519; here in velocity form: V += [h a(X)/2],
 * X += [h V], V += [h a(X)/2], [] to the nearest whole number. With time reversed the same whole
 * numbers are taken away again. Nothing is lost in large sums either.
 */
#include "kernels.h"
#include "simd.h"

static inline double acceleration(const refdem_lattice *p, double x)
{
    double pull = p->stiffness * x;
    if (p->exponent != 1.0)
        pull = copysign(p->stiffness * pow(fabs(x), p->exponent), x);
    double hardening = p->cubic * x * x * x;
    return (p->weight - pull - hardening) / p->mass;
}

/* The whole number nearest to part * count, though count may have more bits than binary64, and so
 * may the product. */
static inline int64_t share(double part, int64_t count)
{
    double rough = (double)count;
    dd product = two_product(part, rough);
    int64_t whole = llrint(product.hi);
    return whole
           + llrint((product.hi - (double)whole)
                    + fma(part, (double)(count - (int64_t)rough), product.lo));
}

REFDEM_EVERY_CPU
int refdem_lattice_verlet(const refdem_lattice *p, double x0, double v0, double h, int64_t samples,
                          int64_t stride, double *out)
{
    int64_t place = llrint(x0 / p->place);
    int64_t speed = llrint(v0 / p->speed);
    double kick = 0.5 * h / p->speed;
    double drift = h * p->speed / p->place;
    out[0] = x0;
    out[1] = v0;
    int64_t push = llrint(kick * acceleration(p, (double)place * p->place));
    for (int64_t row = 1; row < samples; row++) {
        for (int64_t n = 0; n < stride; n++) {
            speed += push;
            place += share(drift, speed);
            push = llrint(kick * acceleration(p, (double)place * p->place));
            speed += push;
        }
        out[2 * row] = (double)place * p->place;
        out[2 * row + 1] = (double)speed * p->speed;
    }
    return 0;
}

/* Lorenz' three equations (Journal of the Atmospheric Sciences 20 (1963) 130, (25)-(27)) by Taylor
 * series:
 *
 *   x' = sigma (y - x),   y' = x (rho - z) - y,   z' = x y - beta z.
 *
 * The clock counts iterates: a rate by the clock is `interval` times a rate by the time, so that no
 * product n interval is rounded.
 */
#include <assert.h>
#include <math.h>

#include "lorenz_kernel.h"
#include "taylor.h"

/* Coefficients 1 to TERMS of x, y and z: (k + 1) y_(k+1) = interval times coefficient k of the
 * rates above. */
static void expand(const void *system, dd clock, series *state, double *scale)
{
    const refdem_lorenz_numbers *p = system;
    double *x = state[0];
    double *y = state[1];
    double *z = state[2];
    (void)clock; /* the equations do not depend on the time */
    for (int k = 0; k < TERMS; k++) {
        double part = p->interval / (k + 1);
        double xy = cauchy(x, y, k);
        double xz = cauchy(x, z, k);
        x[k + 1] = part * (p->sigma * (y[k] - x[k]));
        y[k + 1] = part * (p->rho * x[k] - xz - y[k]);
        z[k + 1] = part * (xy - p->beta * z[k]);
    }
    /* One size for all three: they are coordinates of one point, and each may pass through 0. */
    double size = fabs(x[0]) + fabs(y[0]) + fabs(z[0]);
    for (int i = 0; i < 3; i++)
        scale[i] = size;
}

int refdem_lorenz(const refdem_lorenz_numbers *p, int64_t samples, const double *n, double *out)
{
    assert(p && samples >= 1 && n && out); /* (samples), (samples, 3) doubles */
    series state[3];
    return taylor_run(expand, p, 3, state, samples, n, out);
}

/* A body with internal damping: its angular momentum is constant in space, and its energy decreases
 * (Bloch, Krishnaprasad, Marsden and Ratiu, Commun. Math. Phys. 175 (1996) 1: the double bracket).
 *
 * In principal axes, with w = J^-1 L and the rate of turning W = w + c L x w:
 *   L' = L x W,   q' = q W/2.
 * State (7): L [kg m^2/s], q = (w, x, y, z); in the code v is the third component of q, and y the
 * state.
 */
#include <assert.h>

#include "kernels.h"
#include "taylor.h"

typedef struct {
    double inverse_inertia[3], damping; /* 1/J [1/(kg m^2)]; c [s/(kg m^2)] */
} damped;

/* Coefficients 1 to TERMS of the state by these equations. */
static void expand(const void *system, dd time, series *y, double *scale)
{
    const damped *p = system;
    series omega[3], turn[3];
    double *w = y[3];
    double *x = y[4];
    double *v = y[5];
    double *z = y[6];
    (void)time;
    for (int k = 0; k < TERMS; k++) {
        /* omega = J^-1 L, coefficient k. */
        for (int i = 0; i < 3; i++)
            omega[i][k] = y[i][k] * p->inverse_inertia[i];
        /* W = omega + c L x omega, the rate at which the axes turn. */
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3;
            int l = (i + 2) % 3;
            turn[i][k] = omega[i][k]
                         + p->damping * (cauchy(y[j], omega[l], k) - cauchy(y[l], omega[j], k));
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3;
            int l = (i + 2) % 3;
            /* L' = L x W. */
            y[i][k + 1] = (cauchy(y[j], turn[l], k) - cauchy(y[l], turn[j], k)) / (k + 1);
        }
        /* q' = q (0, W)/2 of the attitude q = (w, x, v, z). */
        double half = 0.5 / (k + 1);
        w[k + 1] = -half * (cauchy(x, turn[0], k) + cauchy(v, turn[1], k) + cauchy(z, turn[2], k));
        x[k + 1] = half * (cauchy(w, turn[0], k) + cauchy(v, turn[2], k) - cauchy(z, turn[1], k));
        v[k + 1] = half * (cauchy(w, turn[1], k) + cauchy(z, turn[0], k) - cauchy(x, turn[2], k));
        z[k + 1] = half * (cauchy(w, turn[2], k) + cauchy(x, turn[1], k) - cauchy(v, turn[0], k));
    }
    double size = sqrt(y[0][0] * y[0][0] + y[1][0] * y[1][0] + y[2][0] * y[2][0]);
    for (int i = 0; i < 3; i++)
        scale[i] = size;
    for (int i = 3; i < 7; i++)
        scale[i] = 1.0;
}

int refdem_dissipating_body(const double *inertia, double damping, int64_t samples, const double *t,
                            double *out)
{
    assert(inertia && samples >= 1 && t && out); /* (3), (samples), (samples, 7) doubles */
    damped p = {{1.0 / inertia[0], 1.0 / inertia[1], 1.0 / inertia[2]}, damping};
    series y[7];
    return taylor_run(expand, &p, 7, y, samples, t, out);
}

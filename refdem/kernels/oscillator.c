/* A point on a linear spring of no natural length, in closed form. In each direction, with w^2 =
 * k/m and the equilibrium xe = anchor + m g/k:
 *
 *   x = xe + (x0 - xe) cos w t + (v0/w) sin w t,   v = w ((v0/w) cos w t - (x0 - xe) sin w t).
 *
 * The phase w t is kept in double-double, so that its error does not grow with time.
 */
#include <assert.h>

#include "double_double.h"
#include "kernels.h"

int refdem_harmonic(double mass, double stiffness, const double *gravity, const double *anchor,
                    const double *position, const double *velocity, double t0, int64_t samples,
                    const double *t, double *out_position, double *out_velocity)
{
    assert(gravity && anchor && position && velocity);
    assert(samples == 0 || (t && out_position && out_velocity)); /* (samples, 3) doubles each */
    dd m = dd_of(mass);
    dd k = dd_of(stiffness);
    dd w = dd_sqrt(dd_div(k, m));
    double equilibrium[3], displacement[3], v0_over_w[3]; /* xe, x0 - xe, v0/w, all [m] */
    for (int i = 0; i < 3; i++) {
        dd xe = dd_add(dd_of(anchor[i]), dd_div(dd_scale(m, gravity[i]), k));
        equilibrium[i] = dd_round(xe);
        displacement[i] = dd_round(dd_sub(dd_of(position[i]), xe));
        v0_over_w[i] = dd_round(dd_div(dd_of(velocity[i]), w));
    }
    for (int64_t n = 0; n < samples; n++) {
        double cosine, sine;
        turned(dd_mul(w, two_sum(t[n], -t0)), &cosine, &sine);
        for (int i = 0; i < 3; i++) {
            out_position[3 * n + i]
                = equilibrium[i] + fma(displacement[i], cosine, v0_over_w[i] * sine);
            out_velocity[3 * n + i] = w.hi * fma(v0_over_w[i], cosine, -displacement[i] * sine);
        }
        if (t[n] != t0)
            continue;
        for (int i = 0; i < 3; i++) { /* the start as it was given */
            out_position[3 * n + i] = position[i];
            out_velocity[3 * n + i] = velocity[i];
        }
    }
    return 0;
}

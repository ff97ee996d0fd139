/* A point on a linear spring of no natural length, in closed form: x = xe + (x0 - xe) cos wt +
 * (v0/w) sin wt in each direction, w^2 = k/m, xe = anchor + m g/k. */
#include "double_double.h"
#include "kernels.h"

int refdem_harmonic(double mass, double stiffness, const double *gravity, const double *anchor,
                    const double *position, const double *velocity, double t0, int64_t samples,
                    const double *t, double *out_position, double *out_velocity)
{
    dd m = dd_of(mass);
    dd k = dd_of(stiffness);
    dd w = dd_sqrt(dd_div(k, m));
    double rest[3], from[3], speed[3];
    for (int i = 0; i < 3; i++) {
        dd middle = dd_add(dd_of(anchor[i]), dd_div(dd_scale(m, gravity[i]), k));
        rest[i] = dd_round(middle);
        from[i] = dd_round(dd_sub(dd_of(position[i]), middle));
        speed[i] = dd_round(dd_div(dd_of(velocity[i]), w));
    }
    for (int64_t n = 0; n < samples; n++) {
        double c, s;
        turned(dd_mul(w, two_sum(t[n], -t0)), &c, &s);
        for (int i = 0; i < 3; i++) {
            out_position[3 * n + i] = rest[i] + fma(from[i], c, speed[i] * s);
            out_velocity[3 * n + i] = w.hi * fma(speed[i], c, -from[i] * s);
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

/* A string over a wheel: a pendulum of changing length on one side, a mass that moves straight up
 * and down on the other.
 *
 * With the free string r of the pendulum, its angle th from straight down, the speed of the string
 * u = r' - R th' and w = th':
 *
 *   (M + m + J/R^2) u' = m r w^2 - M g + m g cos th,
 *   r w' = -(2 u w + R w^2 + g sin th)
 *
 * (Lagrange's equations with the velocity of the pendulum u along the string and r w across it;
 * for R = 0 Swinging Atwood's machine, Tufillaro, Abbott and Griffiths, Am. J. Phys. 52 (1984)
 * 895). State (4): r [m], th [rad], u [m/s], w [rad/s].
 */
#include <assert.h>

#include "kernels.h"
#include "taylor.h"

typedef struct {
    double mass, counter, whole, radius, gravity; /* m, M, M + m + J/R^2 [kg], R [m], g [m/s^2] */
} wheel;

/* Coefficients 1 to TERMS of the state by these equations; r and th decide the step. */
static void expand(const void *system, dd time, series *y, double *scale)
{
    const wheel *p = system;
    double *r = y[0];
    double *angle = y[1];
    double *u = y[2];
    double *w = y[3];
    series s, c, r_w, w_rate;
    (void)time;
    for (int k = 0; k < TERMS; k++) {
        sine_cosine(angle, w, s, c, k);
        r_w[k] = cauchy(r, w, k);
        double counter_weight = 0.0; /* of the mass, constant in time */
        if (k == 0)
            counter_weight = p->counter * p->gravity;
        /* m r w^2 - M g + m g cos th, and 2 u w + R w^2 + g sin th. */
        double force_along = p->mass * (cauchy(r_w, w, k) + p->gravity * c[k]) - counter_weight;
        double across = 2.0 * cauchy(u, w, k) + p->radius * cauchy(w, w, k) + p->gravity * s[k];
        /* r w' = -across, solved for coefficient k of w'. */
        w_rate[k] = -(across + cauchy_rest(r, w_rate, k)) / r[0];
        /* r' = u + R w, th' = w, (M + m + J/R^2) u' = force_along. */
        r[k + 1] = (u[k] + p->radius * w[k]) / (k + 1);
        angle[k + 1] = w[k] / (k + 1);
        u[k + 1] = force_along / p->whole / (k + 1);
        w[k + 1] = w_rate[k] / (k + 1);
    }
    scale[0] = fabs(r[0]);
    scale[1] = 1.0;
    scale[2] = 0.0;
    scale[3] = 0.0;
}

int refdem_string_wheel(double mass, double counter, double drag, double radius, double gravity,
                        int64_t samples, const double *t, double *out)
{
    assert(samples >= 1 && t && out); /* (samples), (samples, 4) doubles */
    wheel p = {mass, counter, mass + counter + drag, radius, gravity};
    series y[4];
    int failed = taylor_run(expand, &p, 4, y, samples, t, out);
    if (failed)
        return failed;
    /* A pendulum that hangs straight down reaches the wheel, r = 0, without a singularity: such a
     * motion is refused here. */
    for (int64_t k = 0; k < samples; k++)
        if (!(out[4 * k] > 0.0))
            return (int)k + 1;
    return 0;
}

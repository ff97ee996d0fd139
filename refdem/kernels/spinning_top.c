/* A rigid body about a fixed point in uniform gravity (Euler 1758; Landau and Lifshitz, section
 * 36), in body axes:
 *
 *   q' = q w/2,   J w' = (J w) x w + arm x f,   f = R(q)^T weight.
 *
 * J: principal moments about the fixed point; arm: from it to the centre of mass. State (7): q =
 * (w, x, y, z), w [rad/s].
 */
#include <assert.h>

#include "kernels.h"
#include "taylor.h"

typedef struct {
    const double *inertia, *arm, *weight; /* (3) each: [kg m^2], [m] in body axes, [N] in space */
} top;

/* Coefficient k of f = R^T weight. R is quadratic in q: R_ii = q0^2 + q_i^2 - q_j^2 - q_l^2, R_ij =
 * 2 (q_i q_j - q0 q_l), R_ji = 2 (q_i q_j + q0 q_l) for (i, j, l) cyclic. */
static void weight_in_body(const top *p, series *q, int k, double *restrict f)
{
    double qq[4][4];
    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++) {
            qq[i][j] = cauchy(q[i], q[j], k);
            qq[j][i] = qq[i][j];
        }
    const double *g = p->weight;
    f[0] = g[0] * (qq[0][0] + qq[1][1] - qq[2][2] - qq[3][3])
           + 2.0 * (g[1] * (qq[1][2] + qq[0][3]) + g[2] * (qq[1][3] - qq[0][2]));
    f[1] = g[1] * (qq[0][0] - qq[1][1] + qq[2][2] - qq[3][3])
           + 2.0 * (g[2] * (qq[2][3] + qq[0][1]) + g[0] * (qq[1][2] - qq[0][3]));
    f[2] = g[2] * (qq[0][0] - qq[1][1] - qq[2][2] + qq[3][3])
           + 2.0 * (g[0] * (qq[1][3] + qq[0][2]) + g[1] * (qq[2][3] - qq[0][1]));
}

/* The size of omega [1/s], sqrt(|w|^2 + |w'|): the second term counts where the top is at rest. */
static double omega_size(series *w)
{
    double square = 0.0;
    double rate_square = 0.0;
    for (int i = 0; i < 3; i++) {
        square += w[i][0] * w[i][0];
        rate_square += w[i][1] * w[i][1];
    }
    return sqrt(square + sqrt(rate_square));
}

/* Coefficients 1 to TERMS of the state by these equations. Attitude and omega decide the step: in
 * body axes omega and the weight turn with the spin, the attitude with half of it. */
static void expand(const void *system, dd time, series *y, double *scale)
{
    const top *p = system;
    series *q = y;
    series *w = y + 4;
    (void)time;
    for (int k = 0; k < TERMS; k++) {
        double f[3];
        double rate = 0.5 / (k + 1);
        weight_in_body(p, q, k, f);
        /* q' = q (0, w)/2. */
        q[0][k + 1]
            = -rate * (cauchy(q[1], w[0], k) + cauchy(q[2], w[1], k) + cauchy(q[3], w[2], k));
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3;
            int m = (i + 2) % 3;
            q[i + 1][k + 1]
                = rate
                  * (cauchy(q[0], w[i], k) + cauchy(q[j + 1], w[m], k) - cauchy(q[m + 1], w[j], k));
            /* J_i w_i' = (J_j - J_m) w_j w_m + (arm x f)_i. */
            double turning = (p->inertia[j] - p->inertia[m]) * cauchy(w[j], w[m], k)
                             + p->arm[j] * f[m] - p->arm[m] * f[j];
            w[i][k + 1] = turning / p->inertia[i] / (k + 1);
        }
    }
    for (int i = 0; i < 4; i++)
        scale[i] = 1.0;
    double size = omega_size(w);
    for (int i = 4; i < 7; i++)
        scale[i] = size; /* 0 at rest in equilibrium, where omega stays 0 */
}

int refdem_spinning_top(const double *inertia, const double *arm, const double *weight,
                        int64_t samples, const double *t, double *out)
{
    assert(inertia && arm && weight);
    assert(samples >= 1 && t && out); /* (samples), (samples, 7) doubles */
    top p = {inertia, arm, weight};
    series y[7];
    return taylor_run(expand, &p, 7, y, samples, t, out);
}

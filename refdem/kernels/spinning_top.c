/* A rigid body about a fixed point in uniform gravity: q' = q w/2, J w' = (J w) x w + arm x (R^T
 * weight), in body axes.
 *
 * J: principal moments about the fixed point; arm: from it to the centre of mass (Euler 1758;
 * Landau and Lifshitz, section 36).
 */
#include "kernels.h"
#include "taylor.h"

typedef struct {
    const double *inertia, *arm, *weight;
} top;

/* Coefficient k of the weight in body axes: the rows of R are quadratic in q. */
static void felt(const top *p, series *q, int k, double *restrict f)
{
    double w[4][4];
    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            w[i][j] = w[j][i] = cauchy(q[i], q[j], k);
    const double *g = p->weight;
    f[0] = g[0] * (w[0][0] + w[1][1] - w[2][2] - w[3][3])
           + 2.0 * (g[1] * (w[1][2] + w[0][3]) + g[2] * (w[1][3] - w[0][2]));
    f[1] = g[1] * (w[0][0] - w[1][1] + w[2][2] - w[3][3])
           + 2.0 * (g[2] * (w[2][3] + w[0][1]) + g[0] * (w[1][2] - w[0][3]));
    f[2] = g[2] * (w[0][0] - w[1][1] - w[2][2] + w[3][3])
           + 2.0 * (g[0] * (w[1][3] + w[0][2]) + g[1] * (w[2][3] - w[0][1]));
}

static void expand(const void *system, dd time, series *y, double *scale)
{
    const top *p = system;
    series *q = y;
    series *w = y + 4;
    (void)time;
    for (int k = 0; k < TERMS; k++) {
        double f[3];
        double rate = 0.5 / (k + 1);
        felt(p, q, k, f);
        q[0][k + 1]
            = -rate * (cauchy(q[1], w[0], k) + cauchy(q[2], w[1], k) + cauchy(q[3], w[2], k));
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3;
            int m = (i + 2) % 3;
            q[i + 1][k + 1]
                = rate
                  * (cauchy(q[0], w[i], k) + cauchy(q[j + 1], w[m], k) - cauchy(q[m + 1], w[j], k));
            double turning = (p->inertia[j] - p->inertia[m]) * cauchy(w[j], w[m], k)
                             + p->arm[j] * f[m] - p->arm[m] * f[j];
            w[i][k + 1] = turning / p->inertia[i] / (k + 1);
        }
    }
    for (int i = 0; i < 4; i++)
        scale[i] = 1.0;
    scale[4] = scale[5] = scale[6] = 0.0;
}

int refdem_spinning_top(const double *inertia, const double *arm, const double *weight,
                        int64_t samples, const double *t, double *out)
{
    top p = {inertia, arm, weight};
    series y[7];
    return taylor_run(expand, &p, 7, y, samples, t, out);
}

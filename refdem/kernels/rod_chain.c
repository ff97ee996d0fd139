/* A planar chain of points on rigid rods that hangs from a pivot, at rest or moved along a line by
 * a law of time, in angles.
 *
 * r_i = pivot + sum over j <= i of l_j (sin th_j, -cos th_j), mu_i = m_i + ... + m_N (Lagrange;
 * Landau and Lifshitz, Mechanics, sec. 5): sum_j mu_max(i,j) l_i l_j (cos(th_i - th_j) th_j'' +
 * sin(th_i - th_j) th_j'^2) = mu_i l_i G.(cos th_i, sin th_i), G = gravity - pivot'', pivot'' =
 * -drive Omega^2 cos(Omega t + phase). The matrix is factored once a step; its Taylor coefficients
 * of higher order go to the other side. The pivot does work at the rate F.pivot', F = sum mu_i l_i
 * (sin th_i, -cos th_i)'' - mu_1 G.
 */
#include <assert.h>

#include "kernels.h"
#include "taylor.h"

enum { MOST = 8 };

typedef struct {
    int n;
    const double *length, *aim; /* aim (n, 2): sine and cosine of each rod's angle at the start,
                                   from which angles count */
    double load[MOST];          /* mu */
    double gravity[2], drive[2], frequency, phase;
} chain;

/* Sine and cosine of the whole angle from those since the start: exact there, so that what stands
 * upright stays. */
static void aimed(const double *restrict aim, double *restrict s, double *restrict c)
{
    double sine = *s;
    double cosine = *c;
    *s = aim[0] * cosine + aim[1] * sine;
    *c = aim[1] * cosine - aim[0] * sine;
}

static double coupling(const chain *p, int i, int j)
{
    int lower = i; /* of the two bobs: it and those below it move with both rods */
    if (j > i)
        lower = j;
    return p->load[lower] * p->length[i] * p->length[j];
}

/* Lower factor of a symmetric positive matrix, in place. */
static void factor(int n, double m[MOST][MOST])
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = m[i][j];
            for (int k = 0; k < j; k++)
                sum -= m[i][k] * m[j][k];
            if (i == j)
                m[i][j] = sqrt(sum);
            else
                m[i][j] = sum / m[j][j];
        }
    }
}

static void solve(int n, double m[MOST][MOST], double *b)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= m[i][k] * b[k];
        b[i] /= m[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= m[k][i] * b[k];
        b[i] /= m[i][i];
    }
}

/* G and the pivot's velocity along both axes of the plane as series about a time. */
static void felt_gravity(const chain *p, dd time, series *g, series *velocity)
{
    double c, s;
    double power = p->frequency;
    turned(dd_add(dd_mul(dd_of(p->frequency), time), dd_of(p->phase)), &c, &s);
    double wave[4] = {c, -s, -c, s};
    for (int k = 0; k <= TERMS; k++) {
        for (int axis = 0; axis < 2; axis++) {
            double constant = 0.0;
            if (k == 0)
                constant = p->gravity[axis];
            g[axis][k] = constant + p->drive[axis] * p->frequency * power * wave[k % 4];
        }
        for (int axis = 0; axis < 2; axis++)
            velocity[axis][k] = p->drive[axis] * power * wave[(k + 1) % 4];
        power *= p->frequency / (k + 1);
    }
}

static void expand(const void *system, dd time, series *y, double *scale)
{
    const chain *p = system;
    series g[2], moved[2], pull[2], s[MOST], c[MOST], square[MOST], turn[MOST], across[MOST][MOST],
        along[MOST][MOST];
    double matrix[MOST][MOST], b[MOST];
    int n = p->n;
    felt_gravity(p, time, g, moved);
    for (int k = 0; k < TERMS; k++) {
        for (int i = 0; i < n; i++) {
            sine_cosine(y[i], y[n + i], s[i], c[i], k);
            if (k == 0)
                aimed(p->aim + 2 * i, &s[i][0], &c[i][0]);
            square[i][k] = cauchy(y[n + i], y[n + i], k);
        }
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                double weight = coupling(p, i, j);
                if (i != j) { /* weight cos and sin of the angle between the rods */
                    along[i][j][k] = weight * (cauchy(c[i], c[j], k) + cauchy(s[i], s[j], k));
                    across[i][j][k] = weight * (cauchy(s[i], c[j], k) - cauchy(c[i], s[j], k));
                    continue;
                }
                along[i][i][k] = 0.0;
                across[i][i][k] = 0.0;
                if (k == 0)
                    along[i][i][k] = weight;
            }
        }
        for (int i = 0; i < n; i++) {
            b[i] = p->load[i] * p->length[i] * (cauchy(g[0], c[i], k) + cauchy(g[1], s[i], k));
            for (int j = 0; j < n; j++)
                b[i] -= cauchy(across[i][j], square[j], k) + cauchy_rest(along[i][j], turn[j], k);
        }
        if (k == 0) {
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    matrix[i][j] = along[i][j][0];
            factor(n, matrix);
        }
        solve(n, matrix, b);
        for (int i = 0; i < n; i++) {
            turn[i][k] = b[i];
            y[i][k + 1] = y[n + i][k] / (k + 1);
            y[n + i][k + 1] = b[i] / (k + 1);
        }
        for (int axis = 0; axis < 2; axis++)
            pull[axis][k] = -p->load[0] * g[axis][k];
        for (int i = 0; i < n; i++) {
            double weight = p->load[i] * p->length[i];
            pull[0][k] += weight * (cauchy(turn[i], c[i], k) - cauchy(square[i], s[i], k));
            pull[1][k] += weight * (cauchy(turn[i], s[i], k) + cauchy(square[i], c[i], k));
        }
        y[2 * n][k + 1] = (cauchy(pull[0], moved[0], k) + cauchy(pull[1], moved[1], k)) / (k + 1);
    }
    for (int i = 0; i < n; i++) {
        scale[i] = 1.0;
        scale[n + i] = 0.0;
    }
    scale[2 * n] = 0.0;
}

int refdem_rod_chain(int64_t rods, const double *length, const double *aim, const double *mass,
                     const double *gravity, const double *drive, double frequency, double phase,
                     int64_t samples, const double *t, double *out)
{
    assert(samples >= 1 && out);
    chain p
        = {.n = (int)rods, .length = length, .aim = aim, .frequency = frequency, .phase = phase};
    series y[2 * MOST + 1];
    double load = 0.0;
    if (rods < 1 || rods > MOST)
        return 1;
    for (int i = p.n - 1; i >= 0; i--)
        p.load[i] = load += mass[i];
    for (int axis = 0; axis < 2; axis++) {
        p.gravity[axis] = gravity[axis];
        p.drive[axis] = drive[axis];
    }
    return taylor_run(expand, &p, 2 * p.n + 1, y, samples, t, out);
}
